"""The verification book: chapters of sections, bound to one page (Markdown and HTML).

A section is a case: what is checked, a table of rows, pictures of reference and ours. Each module
writes its chapter into a folder of its own; the page beside these folders is made again from all
chapters that are there.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from matplotlib.figure import Figure

from elutria.files import write_csv, write_json
from elutria.output.plots import save
from elutria_validation.book.page import bind
from elutria_validation.harness.common import Options, machine

COLUMNS = (
    "section", "case", "checked", "reference", "ours", "error", "allowed", "peers", "verdict",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One thing that is checked: reference and ours in SI units, `error` against `allowed`.

    Without `allowed` the row is for information and not judged.
    """

    case: str
    checked: str
    reference: float
    ours: float
    error: float
    allowed: float | None
    peers: str = ""

    @classmethod
    def relative(
        cls, case: str, checked: str, reference: float, ours: float, allowed: float | None,
        peers: str = "",
    ) -> Row:  # fmt: skip
        """With the relative difference as error."""
        return cls(case, checked, reference, ours, abs(ours / reference - 1), allowed, peers)

    @property
    def verdict(self) -> str:
        """pass, FAIL or info; an error that is no number fails."""
        if self.allowed is None:
            return "info"
        return "pass" if self.error <= self.allowed else "FAIL"

    @property
    def failure(self) -> str:
        """The line that names a judged row that fails."""
        return f"FAIL {self.case}: {self.checked}: {self.error:.3g}, allowed {self.allowed:.3g}"


@dataclass
class Section:
    """A case: `text` says what it is; `found` what was learnt, above all where a row fails."""

    title: str
    text: str
    found: str = ""
    rows: list[Row] = field(default_factory=list)
    figures: dict[str, tuple[Figure, str]] = field(default_factory=dict)  # figure and caption


@dataclass
class Chapter:
    """What one module found."""

    name: str
    title: str
    sections: list[Section] = field(default_factory=list)

    def section(self, title: str, text: str, found: str = "") -> Section:
        """A new section at the end."""
        self.sections.append(Section(title, text, found))
        return self.sections[-1]

    @property
    def rows(self) -> list[Row]:
        """Of all sections."""
        return [row for section in self.sections for row in section.rows]

    @property
    def failed(self) -> list[Row]:
        """Judged rows that fail."""
        return [row for row in self.rows if row.verdict == "FAIL"]


def write_chapter(options: Options, chapter: Chapter) -> Chapter:
    """rows.csv, the figures and chapter.json in the options' folder; then the page beside it."""
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    sections = [_written(section, options) for section in chapter.sections]
    rows = [{"section": section["title"], **row} for section in sections for row in section["rows"]]
    write_csv(folder / "rows.csv", COLUMNS, rows)
    write_json(
        folder / "chapter.json",
        {"name": chapter.name, "title": chapter.title, "sections": sections, "machine": machine()},
    )
    bind(folder.parent)
    judged = [row for row in chapter.rows if row.allowed is not None]
    passed = len(judged) - len(chapter.failed)
    options.say(f"{chapter.name}: {passed} of {len(judged)} rows pass")
    for row in chapter.failed:
        options.say(f"  {row.failure}")
    return chapter


def _written(section: Section, options: Options) -> dict[str, Any]:
    captions = {}
    for name, (figure, caption) in section.figures.items():
        save(figure, options.folder / f"{name}.png")
        captions[f"{name}.png"] = caption
    return {
        "title": section.title,
        "text": section.text,
        "found": section.found,
        "rows": [{**asdict(row), "verdict": row.verdict} for row in section.rows],
        "figures": captions,
    }
