"""One run of a sweep in a process of its own.

`python -m elutria.running.worker CASE FOLDER NP NEIGHBOUR SETTING...` prints
`progress SHARE NOTE` lines; on failure one line on the error output and the exit code 1 or 2.
NEIGHBOUR is the folder of the run whose settled gas this one starts from, or empty.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from elutria.case.case import Case, Setting
from elutria.errors import ElutriaError
from elutria.running.run import run_case

if TYPE_CHECKING:
    from elutria.running.solver import Step


def main(arguments: list[str]) -> int:
    """Run the case; the exit code is the error's, 0 without one."""
    case, folder, np, neighbour, *settings = arguments
    last = 0.0

    def on_step(share: float, step: Step) -> None:
        nonlocal last
        if time.monotonic() - last > 0.5:
            last = time.monotonic()
            print(f"progress {share:.4f} {note(step)}", flush=True)

    try:
        chosen = [Setting.parse(text) for text in settings]
        run_case(
            Case(Path(case)),
            Path(folder).resolve(),
            chosen,
            int(np),
            on_step,
            Path(neighbour).resolve() if neighbour else None,
        )
    except ElutriaError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    return 0


def note(step: Step) -> str:
    """The solver's numbers, short."""
    return f"fines {step.fines} coarse {step.coarse} inside {step.inside}"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
