"""`elutria bench` and `elutria verify`: read options, run modules, turn failed rows into codes.

What is heavy to load is imported where it is used: every command of elutria reads this file.
"""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from elutria.errors import ElutriaError, InputError, one_line, suggestion

if TYPE_CHECKING:
    from elutria_validation.book.rows import MakeSection

console = Console(emoji=False)
errors = Console(stderr=True, emoji=False)

QuickOption = Annotated[bool, typer.Option("--quick", help="A short version.")]
OwnOptions = Annotated[
    list[str] | None, typer.Option("--option", metavar="KEY=VALUE", help="Its own; see 'list'.")
]


def register(app: typer.Typer) -> None:
    """Give elutria's command line both commands."""
    app.command(epilog="Example: elutria bench neighbours --quick")(bench)
    app.command(epilog="Example: elutria verify all --quick")(verify)


def bench(
    name: Annotated[str, typer.Argument(help="Which one; 'list' names them all.")],
    to: Annotated[Path | None, typer.Option(help="Folder; default: results/bench/NAME.")] = None,
    repeats: Annotated[int, typer.Option(min=1, help="Runs of each timed thing.")] = 5,
    quick: QuickOption = False,
    option: OwnOptions = None,
) -> None:
    """Benchmarks: each writes csv, a figure, and the versions and machine it ran on."""
    from elutria_validation.harness.job import Job, parse_options

    known = modules("benchmarks")
    if name == "list":
        _list(known)
        return
    module = _chosen(known, name)
    options: Any = parse_options(_options(module), option or [], quick)
    module.run(Job(to or Path("results/bench") / name, repeats, quick, _say), options)


def verify(
    name: Annotated[str, typer.Argument(help="Which one; 'list' names them, 'all' runs all.")],
    to: Annotated[Path | None, typer.Option(help="Folder; default: results/verify/NAME.")] = None,
    quick: QuickOption = False,
    jobs: Annotated[int, typer.Option(min=1, help="Of 'all': so many side by side.")] = 2,
    section: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Of a chapter this alone; its folder's others stay."),
    ] = None,
    option: OwnOptions = None,
) -> None:
    """Reference results, run through the code that users run; exit code 1 if a judged row fails."""
    from concurrent.futures import ProcessPoolExecutor

    from elutria_validation.harness.job import NoOptions, parse_options

    known = modules("chapters")
    if name == "list":
        _list(known)
        return
    parse_options(NoOptions, option or [], quick)
    folder = to or Path("results/verify") / ("" if name == "all" else name)
    if name == "all":
        if section:
            raise InputError("--section: is of one chapter; allowed: not with 'all'")
        with ProcessPoolExecutor(jobs) as pool:
            pending = {key: pool.submit(_failures, key, folder / key, quick) for key in known}
        failures = [f"{key}: {line}" for key, done in pending.items() for line in done.result()]
    else:
        _sections(_chosen(known, name), section)
        failures = _failures(name, folder, quick, section)
    for line in failures:
        errors.print(line, style="red", markup=False, highlight=False, soft_wrap=True)
    if failures:
        raise ElutriaError(f"verify {name}: {len(failures)} judged rows failed; see {folder}")


def modules(room: str) -> dict[str, Any]:
    """By NAME, the modules of a room that are a benchmark or a chapter."""
    import importlib
    import pkgutil

    package = importlib.import_module(f"elutria_validation.{room}")
    found = {}
    for entry in pkgutil.iter_modules(package.__path__):
        module = importlib.import_module(f"{package.__name__}.{entry.name}")
        if hasattr(module, "NAME"):
            found[module.NAME] = module
    return found


def _failures(name: str, folder: Path, quick: bool, only: list[str] | None = None) -> list[str]:
    """A line for each judged row that failed, or for the chapter that could not be run."""
    from elutria_validation.book.writing import run_chapter
    from elutria_validation.harness.job import Job

    module = modules("chapters")[name]
    try:
        job = Job(folder, quick=quick, say=_say)
        sections = _sections(module, only)
        chapter = run_chapter(job, module.NAME, module.TITLE, sections, bool(only))
    except InputError:
        raise
    except ElutriaError as error:
        return [f"FAIL {error}"]
    return [row.failure for row in chapter.failed]


def _chosen(known: dict[str, Any], name: str) -> Any:
    if name not in known:
        raise InputError(
            f"'{one_line(name, 40)}'{suggestion(name, known)}; "
            f"allowed: list, {', '.join(sorted(known))}"
        )
    return known[name]


def _sections(module: Any, only: list[str] | None) -> list[MakeSection]:
    """Those of a chapter that are asked for by their functions' names; all where none is."""
    known = {one.__name__: one for one in module.SECTIONS}
    for name in only or ():
        if name not in known:
            raise InputError(f"--section {one_line(name, 40)}{suggestion(name, known)}; "
                             f"allowed: {', '.join(known)}")  # fmt: skip
    return [known[name] for name in only or known]


def _options(module: Any) -> type:
    """The dataclass of a module's own options."""
    from elutria_validation.harness.job import NoOptions

    kind: type = getattr(module, "Options", NoOptions)
    return kind


def _list(known: dict[str, Any]) -> None:
    from elutria_validation.harness.job import describe

    for key in sorted(known):
        own = ", ".join(describe(one) for one in fields(_options(known[key])))
        options = f" --option {own}" if own else ""
        console.print(f"{key}: {known[key].HELP}{options}", highlight=False, markup=False,
                      soft_wrap=True)  # fmt: skip


def _say(text: str) -> None:
    console.print(text, highlight=False, markup=False, soft_wrap=True)
