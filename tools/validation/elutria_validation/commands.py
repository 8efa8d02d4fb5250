"""`elutria bench` and `elutria verify`: read options, run modules, turn failed rows into codes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from elutria.errors import ElutriaError, InputError, one_line, suggestion

console = Console()
errors = Console(stderr=True)


def register(app: typer.Typer) -> None:
    """Give elutria's command line both commands."""
    app.command(epilog="Example: elutria bench neighbours --quick")(bench)
    app.command(epilog="Example: elutria verify all --quick")(verify)


def bench(
    name: Annotated[str, typer.Argument(help="Which one; 'list' names them all.")],
    to: Annotated[Path | None, typer.Option(help="Folder; default: results/bench/NAME.")] = None,
    repeats: Annotated[int, typer.Option(min=1, help="Runs of each timed thing.")] = 5,
    quick: Annotated[bool, typer.Option("--quick", help="A short version.")] = False,
    option: Annotated[
        list[str] | None, typer.Option(metavar="KEY=VALUE", help="The benchmark's own options.")
    ] = None,
) -> None:
    """Benchmarks: each writes csv, a figure, and the versions and machine it ran on."""
    from elutria_validation import benchmarks

    _run_module(benchmarks, name, to or Path("results/bench") / name, repeats, quick, option)


def verify(
    name: Annotated[str, typer.Argument(help="Which one; 'list' names them, 'all' runs all.")],
    to: Annotated[Path | None, typer.Option(help="Folder; default: results/verify/NAME.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="A short version.")] = False,
    jobs: Annotated[int, typer.Option(min=1, help="Of 'all': so many side by side.")] = 2,
    option: Annotated[
        list[str] | None, typer.Option(metavar="KEY=VALUE", help="The reference's own options.")
    ] = None,
) -> None:
    """Reference results, run through the code that users run; exit code 1 if a judged row fails."""
    from concurrent.futures import ProcessPoolExecutor

    from elutria_validation import chapters

    if name != "all":
        folder = to or Path("results/verify") / name
        _refuse_failures(name, _verify_chapter(name, folder, quick, option), folder)
        return
    folder = to or Path("results/verify")
    with ProcessPoolExecutor(jobs) as pool:
        pending = {
            chosen: pool.submit(_verify_chapter, chosen, folder / chosen, quick, option)
            for chosen in modules(chapters)
        }
    _refuse_failures(
        "all", [f"{key}: {line}" for key, done in pending.items() for line in done.result()], folder
    )


def modules(package: Any) -> dict[str, Any]:
    """By NAME, the modules of a package that have a `run`."""
    import importlib
    import pkgutil

    found = {}
    for entry in pkgutil.iter_modules(package.__path__):
        module = importlib.import_module(f"{package.__name__}.{entry.name}")
        if hasattr(module, "NAME") and hasattr(module, "run"):
            found[module.NAME] = module
    return found


def _verify_chapter(name: str, folder: Path, quick: bool, option: list[str] | None) -> list[str]:
    """A line for each judged row that failed, or for the chapter that could not be run."""
    from elutria_validation import chapters

    try:
        chapter = _run_module(chapters, name, folder, 1, quick, option)
    except InputError:
        raise
    except ElutriaError as error:
        return [f"FAIL {error}"]
    return [] if chapter is None else [row.failure for row in chapter.failed]


def _refuse_failures(name: str, failures: list[str], folder: Path) -> None:
    """Raises ElutriaError where there are failures, after a line for each."""
    if not failures:
        return
    for line in failures:
        errors.print(line, style="red", markup=False, highlight=False, soft_wrap=True)
    raise ElutriaError(f"verify {name}: {len(failures)} judged rows failed; see {folder}")


def _run_module(
    package: Any, name: str, folder: Path, repeats: int, quick: bool, extra: list[str] | None
) -> Any:
    """What the module's `run` returns; None after `list`."""
    from elutria_validation.harness.common import Options

    known: dict[str, Any] = modules(package)
    if name == "list":
        for key in sorted(known):
            console.print(f"{key}: {known[key].HELP}", highlight=False, soft_wrap=True)
        return None
    if name not in known:
        raise InputError(
            f"'{one_line(name, 40)}'{suggestion(name, known)}; "
            f"allowed: list, {', '.join(sorted(known))}"
        )
    pairs = [text.partition("=") for text in extra or []]
    if any(not (key and equals) for key, equals, _ in pairs):
        raise InputError(f"--option {extra}; allowed: KEY=VALUE")
    settings = {key: value for key, _, value in pairs}

    def say(text: str) -> None:
        console.print(text, highlight=False, markup=False, soft_wrap=True)

    return known[name].run(Options(folder, repeats, quick, settings, say))
