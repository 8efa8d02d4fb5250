"""The verification book: chapters of rows and figures, bound to one page (Markdown and HTML).

Each module writes its chapter into a folder of its own; the page beside these folders is made again
from all chapters that are there.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from elutria.bench.common import Options, machine
from elutria.files import read_json, write_csv, write_json, write_text
from elutria.plots import save

COLUMNS = ("case", "checked", "reference", "ours", "error", "allowed", "peers", "verdict")


@dataclass(frozen=True)
class Row:
    """One thing that is checked: reference and ours in SI units, `error` against `allowed`."""

    case: str
    checked: str
    reference: float
    ours: float
    error: float
    allowed: float
    peers: str = ""

    @classmethod
    def relative(
        cls, case: str, checked: str, reference: float, ours: float, allowed: float, peers: str = ""
    ) -> Row:
        """With the relative difference as error."""
        return cls(case, checked, reference, ours, abs(ours / reference - 1), allowed, peers)

    @property
    def verdict(self) -> str:
        """pass or FAIL; an error that is no number fails."""
        return "pass" if self.error <= self.allowed else "FAIL"


@dataclass
class Chapter:
    """What one module found."""

    name: str
    title: str
    text: str
    rows: list[Row] = field(default_factory=list)
    figures: dict[str, tuple[Figure, str]] = field(default_factory=dict)  # figure and caption


def write_chapter(options: Options, chapter: Chapter) -> None:
    """rows.csv, the figures and chapter.json in the options' folder; then the page beside it."""
    rows = [{**asdict(row), "verdict": row.verdict} for row in chapter.rows]
    folder = options.folder
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "rows.csv", COLUMNS, rows)
    captions = {}
    for name, (figure, caption) in chapter.figures.items():
        save(figure, folder / f"{name}.png")
        captions[f"{name}.png"] = caption
    write_json(
        folder / "chapter.json",
        {
            "name": chapter.name,
            "title": chapter.title,
            "text": chapter.text,
            "rows": rows,
            "figures": captions,
            "machine": machine(),
        },
    )
    bind(folder.parent)
    failed = [row for row in chapter.rows if row.verdict != "pass"]
    options.say(f"{chapter.name}: {len(rows) - len(failed)} of {len(rows)} rows pass")
    for row in failed:
        options.say(f"  FAIL {row.case}: {row.checked}: {row.error:.3g}, allowed {row.allowed:.3g}")


def bind(folder: Path) -> None:
    """README.md and index.html in `folder` from the chapters below it."""
    chapters = [read_json(path) for path in sorted(folder.glob("*/chapter.json"))]
    rows = [row for chapter in chapters for row in chapter["rows"]]
    passed = sum(row["verdict"] == "pass" for row in rows)
    opening = (
        f"{passed} of {len(rows)} rows pass. Errors are relative unless the row says otherwise; "
        "a row that fails stays in. Made by `elutria verify all`, through elutriaFoam itself."
    )
    write_text(folder / "README.md", "\n".join(_markdown(opening, chapters)) + "\n")
    write_text(folder / "index.html", "\n".join(_html(opening, chapters)) + "\n")


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, (int, float)) else str(value)


def _cells(row: dict[str, Any]) -> list[str]:
    short = {"error": "{:.2g}", "allowed": "{:.2g}"}
    return [
        short[name].format(row[name]) if name in short else _number(row[name]) for name in COLUMNS
    ]


def _made(chapter: dict[str, Any]) -> str:
    made = chapter["machine"]
    return (
        f"Made {made['made']} on {made['processor']}, {made['cores']} cores, "
        f"OpenFOAM {made['openfoam']}, commit {made['commit'][:12]}."
    )


def _markdown(opening: str, chapters: Iterable[dict[str, Any]]) -> list[str]:
    lines = ["# Verification", "", opening, ""]
    for chapter in chapters:
        lines += [f"## {chapter['title']}", "", chapter["text"], ""]
        lines += [f"| {' | '.join(COLUMNS)} |", "|" + " --- |" * len(COLUMNS)]
        lines += [f"| {' | '.join(_cells(row))} |" for row in chapter["rows"]]
        for file, caption in chapter["figures"].items():
            lines += ["", f"![{caption}]({chapter['name']}/{file})", "", caption]
        lines += ["", _made(chapter), ""]
    return lines


def _html(opening: str, chapters: Iterable[dict[str, Any]]) -> list[str]:
    say: Callable[[str], str] = html.escape
    lines = [
        "<!DOCTYPE html>",
        '<html lang="en"><head><meta charset="utf-8"><title>Verification of Elutria</title>',
        "<style>body{font:15px sans-serif;max-width:72em;margin:2em auto;padding:0 1em}"
        "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:2px 8px}"
        "th{text-align:left}.FAIL{background:#fbb}img{max-width:30em}</style></head><body>",
        f"<h1>Verification</h1><p>{say(opening)}</p>",
    ]
    for chapter in chapters:
        lines.append(f"<h2>{say(chapter['title'])}</h2><p>{say(chapter['text'])}</p><table>")
        lines.append("<tr>" + "".join(f"<th>{name}</th>" for name in COLUMNS) + "</tr>")
        for row in chapter["rows"]:
            cells = "".join(f"<td>{say(cell)}</td>" for cell in _cells(row))
            lines.append(f'<tr class="{row["verdict"]}">{cells}</tr>')
        lines.append("</table>")
        for file, caption in chapter["figures"].items():
            source = f"{chapter['name']}/{file}"
            lines.append(f'<p><img src="{source}" alt="{say(caption)}"><br>{say(caption)}</p>')
        lines.append(f"<p><small>{say(_made(chapter))}</small></p>")
    return [*lines, "</body></html>"]
