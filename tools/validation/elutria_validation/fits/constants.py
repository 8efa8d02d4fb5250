"""A fitted constant: what stands in the source, what the fit gives, and how good both are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from elutria_validation.harness.programs import project_root


@dataclass(frozen=True)
class Constant:
    """`text` as it stands in the source, and what the fit gives today."""

    name: str
    text: str
    fitted: float


@dataclass(frozen=True)
class Fit:
    """Constants of the file `source`; the largest residual on the data that they are fitted to, and
    what is judged on others; `unit` says of what both are, `note` what else there is to know."""

    title: str
    source: str
    constants: tuple[Constant, ...]
    unit: str
    residual: float
    judged: float
    allowed: float
    note: str = ""

    @property
    def passes(self) -> bool:
        """Whether the constants of the source are as good as allowed on data of their own."""
        return self.judged <= self.allowed

    def missing(self) -> list[str]:
        """Constants whose text does not stand in the source any more."""
        root = project_root()
        files = [*(root / "solver").rglob(self.source), *(root / "tools").rglob(self.source)]
        text = "".join(file.read_text() for file in files)
        return [one.name for one in self.constants if one.text not in text]


def lines(fits: Iterable[Fit]) -> list[str]:
    """What is printed of them."""
    said = []
    for fit in fits:
        said.append(f"{fit.title} ({fit.source})")
        said += [f"  {one.name}: {one.text}; fitted today {one.fitted:.4g}"
                 for one in fit.constants]  # fmt: skip
        said += [f"  {name}: its number does not stand in {fit.source} any more"
                 for name in fit.missing()]  # fmt: skip
        said.append(f"  {fit.unit}: fitted to {fit.residual:.2g}, on other data {fit.judged:.2g} "
                    f"(allowed {fit.allowed:.2g}): {'pass' if fit.passes else 'FAIL'}")  # fmt: skip
        if fit.note:
            said.append(f"  {fit.note}")
    return said
