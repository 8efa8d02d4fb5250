"""`python -m elutria_validation.fits [--measure] [--write]`: all constants, with their residuals.

Exit code 1 where one is worse on other data than allowed. --measure runs the grains of the wake
again, --write makes docs/verification/fits/index.md.
"""

from __future__ import annotations

import sys

from elutria.files import write_text
from elutria_validation.fits import onset_weight, own_wake
from elutria_validation.fits.constants import Fit, lines
from elutria_validation.harness.programs import project_root
from elutria_validation.harness.provenance import machine


def all_fits() -> list[Fit]:
    """Every fit there is."""
    return [own_wake.fit_viscous(), own_wake.fit_inertial(), onset_weight.fit()]


def write(fits: list[Fit]) -> None:
    """The page, with the note beside it."""
    folder = project_root() / "docs/verification/fits"
    made = machine()
    head = (
        f"`python -m elutria_validation.fits`, {made['made'][:10]}, commit {made['commit'][:12]}. "
        "Each constant as it stands in the source, and as the script fits it today."
    )
    block = "\n".join(["```", *lines(fits), "```"])
    note = (folder / "note.md").read_text()
    write_text(folder / "index.md", f"# Fitted constants\n\n{head}\n\n{block}\n\n{note}")


def main() -> int:
    """Print the fits; exit code."""
    if "--measure" in sys.argv[1:]:
        own_wake.measure()
    fits = all_fits()
    print("\n".join(lines(fits)))
    if "--write" in sys.argv[1:]:
        write(fits)
    return 0 if all(fit.passes for fit in fits) else 1


if __name__ == "__main__":
    sys.exit(main())
