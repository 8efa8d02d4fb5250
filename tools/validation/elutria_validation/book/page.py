"""The verification book's page: index.md and index.html from the chapters' files and the notes."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from elutria.files import read_json, write_text
from elutria_validation.harness.programs import project_root

ROW_COLUMNS = ("case", "checked", "reference", "ours", "error", "allowed", "peers", "verdict")
ORDER = ("contacts", "impacts", "settling", "drag", "clouds", "bed", "fluidised",
         "goldschmidt", "profiles", "dispersion", "wake", "budgets", "classification",
         "measured")  # fmt: skip


@dataclass(frozen=True)
class Note:
    """What somebody wrote of a section: text, and when it was true."""

    written: str
    text: str


def bind(folder: Path) -> None:
    """index.md and index.html in `folder` from the chapters below it."""
    chapters = [read_json(path) for path in folder.glob("*/chapter.json")]
    chapters.sort(key=lambda chapter: (
        ORDER.index(chapter["name"]) if chapter["name"] in ORDER else len(ORDER), chapter["name"]
    ))  # fmt: skip
    for chapter in chapters:
        notes = read_notes(project_root() / "docs/verification/notes" / f"{chapter['name']}.md")
        for section in chapter["sections"]:
            section["note"] = notes.get(section["title"])
            section["summary"] = _summary(section["rows"])
    judged = [
        row for chapter in chapters for section in chapter["sections"] for row in section["rows"]
        if row["allowed"] is not None
    ]  # fmt: skip
    passed = sum(row["verdict"] == "pass" for row in judged)
    for name in ("index.md", "index.html"):
        template = templates("book").get_template(f"{name}.j2")
        write_text(
            folder / name,
            template.render(chapters=chapters, columns=ROW_COLUMNS, passed=passed, of=len(judged)),
        )


def read_notes(path: Path) -> dict[str, Note]:
    """Notes by the section's title; the file's second line says when they were written."""
    if not path.is_file():
        return {}
    head, *parts = re.split(r"^## ", path.read_text(), flags=re.M)
    written = head.strip().splitlines()[-1]
    found = {}
    for part in parts:
        title, _, text = part.partition("\n")
        found[title.strip()] = Note(written, " ".join(text.split()))
    return found


def templates(room: str) -> jinja2.Environment:
    """The templates of a room; those of .html escape what they are given."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("elutria_validation", f"{room}/templates"),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters |= {"anchor": _anchor, "cell": _cell}
    return environment


def _summary(rows: list[dict[str, Any]]) -> tuple[str, str, str, str]:
    """Cells of the summary table, without the case."""
    judged = [row for row in rows if row["allowed"] is not None]
    passed = sum(row["verdict"] == "pass" for row in judged)
    shares = [row["error"] / row["allowed"] for row in judged if row["allowed"]]
    worst = f"{max(shares):.2g}" if shares else ""
    peers = "; ".join(dict.fromkeys(row["peers"] for row in rows if row["peers"]))
    verdict = "info" if not judged else "pass" if passed == len(judged) else "FAIL"
    return f"{passed} of {len(judged)}", worst, peers, verdict


def _cell(row: dict[str, Any], name: str) -> str:
    value = row[name]
    if value is None:
        return ""
    if not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.2g}" if name in ("error", "allowed") else f"{value:.6g}"


def _anchor(title: str) -> str:
    """As GitHub makes it from a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
