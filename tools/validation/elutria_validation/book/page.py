"""The verification book's page: index.md and index.html from the chapters' files."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from elutria.files import read_json, write_text

ROW_COLUMNS = ("case", "checked", "reference", "ours", "error", "allowed", "peers", "verdict")
SUMMARY_COLUMNS = ("case", "rows that pass", "largest error over allowed", "peers", "verdict")
ORDER = ("contacts", "impacts", "settling", "drag", "clouds", "bed", "fluidised",
         "goldschmidt", "profiles", "dispersion", "wake", "budgets", "classification")  # fmt: skip

STYLE = """body{font:15px/1.45 sans-serif;max-width:70em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;font-size:13px;margin:.8em 0}
td,th{border:1px solid #ccc;padding:2px 8px;vertical-align:top}th{text-align:left;background:#eee}
.FAIL{background:#fbb}.info{color:#555}figure{margin:1em 0}img{max-width:32em;width:100%}
h2{border-bottom:1px solid #999;margin-top:2.2em}"""

Section = dict[str, Any]


def bind(folder: Path) -> None:
    """index.md and index.html in `folder` from the chapters below it."""
    chapters = [read_json(path) for path in folder.glob("*/chapter.json")]
    chapters.sort(key=lambda chapter: (
        ORDER.index(chapter["name"]) if chapter["name"] in ORDER else len(ORDER), chapter["name"]
    ))  # fmt: skip
    write_text(folder / "index.md", "\n".join(_markdown(chapters)) + "\n")
    write_text(folder / "index.html", "\n".join(_html(chapters)) + "\n")


def _opening(chapters: list[dict[str, Any]]) -> str:
    judged = [
        row for _, section in _sections(chapters) for row in section["rows"]
        if row["allowed"] is not None
    ]  # fmt: skip
    passed = sum(row["verdict"] == "pass" for row in judged)
    return (
        f"{passed} of {len(judged)} rows pass. Every reference runs through elutriaFoam, the "
        "solver that users run; `elutria verify all --to docs/verification` makes this page again. "
        "Errors are relative unless the row says otherwise. No tolerance was widened: a row that "
        "fails stays, with what was found. Rows marked info are not judged. Peers: what the "
        "authors of the reference, or other codes on it, report."
    )


def _sections(chapters: list[dict[str, Any]]) -> Iterator[tuple[dict[str, Any], Section]]:
    for chapter in chapters:
        for section in chapter["sections"]:
            yield chapter, section


def _summary(section: Section) -> tuple[str, ...]:
    """Cells of the summary table, without the case."""
    judged = [row for row in section["rows"] if row["allowed"] is not None]
    passed = sum(row["verdict"] == "pass" for row in judged)
    shares = [row["error"] / row["allowed"] for row in judged if row["allowed"]]
    worst = f"{max(shares):.2g}" if shares else ""
    peers = "; ".join(dict.fromkeys(row["peers"] for row in section["rows"] if row["peers"]))
    verdict = "info" if not judged else "pass" if passed == len(judged) else "FAIL"
    return f"{passed} of {len(judged)}", worst, peers, verdict


def _number(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, (int, float)) else str(value)


def _cells(row: dict[str, Any]) -> list[str]:
    def text(name: str) -> str:
        value = row[name]
        if value is None:
            return ""
        return f"{value:.2g}" if name in ("error", "allowed") else _number(value)

    return [text(name) for name in ROW_COLUMNS]


def _anchor(title: str) -> str:
    """As GitHub makes it from a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")


def _made(chapter: dict[str, Any]) -> str:
    made = chapter["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in made["packages"].items())
    return (
        f"{chapter['title']}: made {made['made']} on {made['processor']}, {made['cores']} cores, "
        f"{made['system']}; OpenFOAM {made['openfoam']}, {made['compiler']}, Python "
        f"{made['python']}, {packages}; commit {made['commit'][:12]}."
    )


def _markdown(chapters: list[dict[str, Any]]) -> list[str]:
    def table(columns: tuple[str, ...]) -> list[str]:
        return [f"| {' | '.join(columns)} |", "|" + " --- |" * len(columns)]

    lines = ["# Verification", "", _opening(chapters), "", *table(SUMMARY_COLUMNS)]
    for _, section in _sections(chapters):
        title = section["title"]
        cells = (f"[{title}](#{_anchor(title)})", *_summary(section))
        lines.append(f"| {' | '.join(cells)} |")
    for chapter, section in _sections(chapters):
        lines += ["", f"## {section['title']}", "", section["text"], ""]
        for file, caption in section["figures"].items():
            lines += [f"![{caption}]({chapter['name']}/{file})", "", caption, ""]
        lines += table(ROW_COLUMNS)
        lines += [f"| {' | '.join(_cells(row))} |" for row in section["rows"]]
        if section["found"]:
            lines += ["", f"**Found.** {section['found']}"]
    lines += ["", "## Versions and machine", ""]
    return lines + [f"- {_made(chapter)}" for chapter in chapters]


def _html(chapters: list[dict[str, Any]]) -> list[str]:
    say = html.escape

    def row(cells: tuple[str, ...] | list[str], kind: str = "td", style: str = "") -> str:
        return f'<tr class="{style}">' + "".join(f"<{kind}>{c}</{kind}>" for c in cells) + "</tr>"

    lines = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f"<title>Verification of Elutria</title><style>{STYLE}</style></head><body>",
        f"<h1>Verification</h1><p>{say(_opening(chapters))}</p>",
        "<table>" + row(SUMMARY_COLUMNS, "th"),
    ]
    for _, section in _sections(chapters):
        title, summary = section["title"], _summary(section)
        link = f'<a href="#{_anchor(title)}">{say(title)}</a>'
        lines.append(row([link, *map(say, summary)], style=summary[-1]))
    lines.append("</table>")
    for chapter, section in _sections(chapters):
        title = section["title"]
        lines.append(f'<h2 id="{_anchor(title)}">{say(title)}</h2><p>{say(section["text"])}</p>')
        for file, caption in section["figures"].items():
            lines.append(
                f'<figure><img src="{chapter["name"]}/{file}" alt="{say(caption)}">'
                f"<figcaption>{say(caption)}</figcaption></figure>"
            )
        lines.append("<table>" + row(ROW_COLUMNS, "th"))
        lines += [row([say(c) for c in _cells(r)], style=r["verdict"]) for r in section["rows"]]
        lines.append("</table>")
        if section["found"]:
            lines.append(f"<p><b>Found.</b> {say(section['found'])}</p>")
    lines.append("<h2>Versions and machine</h2><ul>")
    lines += [f"<li>{say(_made(chapter))}</li>" for chapter in chapters]
    return [*lines, "</ul></body></html>"]
