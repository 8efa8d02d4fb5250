"""A chapter from its sections, and its files: rows.csv, chapter.json, the figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from matplotlib import rc_context

from elutria.files import read_json, write_csv, write_json
from elutria.output.style import STYLE, save
from elutria_validation.book.page import bind
from elutria_validation.book.rows import Chapter, MakeSection, Section
from elutria_validation.harness.job import Job
from elutria_validation.harness.provenance import machine

COLUMNS = (
    "section", "case", "checked", "reference", "ours", "error", "allowed", "peers", "verdict",
)  # fmt: skip


def run_chapter(
    job: Job, name: str, title: str, sections: Sequence[MakeSection], others_stay: bool = False
) -> Chapter:
    """Run the sections one after another and write their chapter."""
    chapter = Chapter(name, title)
    with TemporaryDirectory() as work, rc_context(STYLE):
        for number, make in enumerate(sections):
            folder = Path(work) / str(number)
            folder.mkdir()
            chapter.sections.append(make(folder, job.quick))
        write_chapter(job, chapter, others_stay)
    return chapter


def write_chapter(job: Job, chapter: Chapter, others_stay: bool = False) -> None:
    """rows.csv, the figures and chapter.json in the job's folder; then the page beside it. Sections
    that the folder has and `chapter` has not are left out, or stay."""
    job.folder.mkdir(parents=True, exist_ok=True)
    sections = [_written(section, job.folder) for section in chapter.sections]
    if others_stay:
        sections = _among_others(sections, job.folder / "chapter.json")
    rows = [{"section": section["title"], **row} for section in sections for row in section["rows"]]
    write_csv(job.folder / "rows.csv", COLUMNS, rows)
    write_json(
        job.folder / "chapter.json",
        {"name": chapter.name, "title": chapter.title, "sections": sections, "machine": machine()},
    )
    bind(job.folder.parent)
    passed = len(chapter.judged) - len(chapter.failed)
    job.say(f"{chapter.name}: {passed} of {len(chapter.judged)} rows pass")
    for row in chapter.failed:
        job.say(f"  {row.failure}")


def _among_others(sections: list[dict[str, Any]], file: Path) -> list[dict[str, Any]]:
    """The file's sections in their order, these in place of those of their title or behind them."""
    own = {section["title"]: section for section in sections}
    there = read_json(file)["sections"] if file.is_file() else []
    return [own.pop(section["title"], section) for section in there] + list(own.values())


def _written(section: Section, folder: Path) -> dict[str, Any]:
    captions = {}
    for name, (figure, caption) in section.figures.items():
        save(figure, folder / f"{name}.png")
        captions[f"{name}.png"] = caption
    return {
        "title": section.title,
        "text": section.text,
        "found": section.found,
        "rows": [{**asdict(row), "verdict": row.verdict} for row in section.rows],
        "figures": captions,
    }
