"""The command line: reads options, calls the other modules, turns errors into lines and codes."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Mapping
from contextlib import suppress
from importlib import import_module
from math import isfinite
from pathlib import Path
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from elutria.errors import ElutriaError, InputError, one_line
from elutria.files import NOT_THE_PLACE

if TYPE_CHECKING:
    from elutria.case.case import Case
    from elutria.classification.classify import Classification, Row
    from elutria.classification.precision import Precision
    from elutria.estimates.price import Price
    from elutria.running.axes import Point
    from elutria.running.budget import Budget
    from elutria.running.solver import Step
    from elutria.running.sweep import SweepResult
    from elutria.warned import Warned

app = typer.Typer(
    name="elutria",
    help="Air classification computed with gas and particles, from feed to partition curve.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    add_completion=False,
)
console = Console(emoji=False)  # ":B:" of A:B:N is no picture
errors = Console(stderr=True, emoji=False)
state = {"debug": False}
INTERRUPTED = 130
"""What typer makes of Ctrl-C."""

VelocitiesOption = Annotated[
    str | None, typer.Option(metavar="A:B:N|LIST", help="Gas velocities, m/s.")
]
CaseArgument = Annotated[Path, typer.Argument(help="Folder of an OpenFOAM case.")]
SetOption = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="FILE:ENTRY=VALUE", help="Give an entry another value."),
]
ProcessorsOption = Annotated[
    int, typer.Option("--np", min=1, help="Processors of each run, at most: as many as pay.")
]
WideOption = Annotated[bool, typer.Option("--wide", help="Print every column of summary.csv.")]
FormatOption = Annotated[
    list[str] | None,
    typer.Option("--format", metavar="png|svg|pdf", help="Of the figures; repeatable."),
]
ResultsArgument = Annotated[
    Path, typer.Argument(help="Folder with summary.csv and partition.csv: of a sweep or a run.")
]


@app.callback(epilog="Any command takes --debug: show the traceback of an error.")
def options() -> None:
    """Air classification computed with gas and particles, from feed to partition curve."""


@app.command(epilog="Example: elutria check cases/column")
def check(case: CaseArgument) -> None:
    """Say what was understood of a case: feed, limits, loading, what is skipped. Runs nothing."""
    from elutria.estimates import machine
    from elutria.estimates.check import report
    from elutria.estimates.price import in_words
    from elutria.output.terminal import print_table
    from elutria.running.known import plan_of

    known = plan_of(case)
    solvers = known["plan"]
    name = case.resolve().name
    for table in report(name, known["velocity"], solvers, known["keeps_mesh"]):
        print_table(console, table)
    _say(f"expected of {in_words(machine.expected([solvers])[0], 1)}")


@app.command(epilog="Example: elutria run cases/column --velocity 6 --to results/one")
def run(
    case: CaseArgument,
    to: Annotated[Path | None, typer.Option(help="Folder of the run.")] = None,
    velocity: Annotated[float | None, typer.Option(help="Gas velocity, m/s.")] = None,
    set_: SetOption = None,
    np: ProcessorsOption = 1,
    extend: Annotated[
        bool, typer.Option(help="Go on with a longer drain or feed, or another loading.")
    ] = False,
    wide: WideOption = False,
    formats: FormatOption = None,
    frames: Annotated[
        bool, typer.Option("--frames", help="Record frames for elutria view.")
    ] = False,
) -> None:
    """Copy, mesh, solve and classify a case; go on where it was stopped."""
    from elutria.case.case import Case
    from elutria.running.axes import parse_velocities
    from elutria.running.gas import require_acting_velocity
    from elutria.running.progress import ProgressDisplay
    from elutria.running.run import is_finished, run_case
    from elutria.running.worker import note

    source = Case(case)
    if velocity is not None:
        parse_velocities(repr(velocity))
    settings = source.settings_for(velocity, set_ or [])
    speed = source.velocity() if velocity is None else velocity
    source.check_settings(settings)
    folder = (to or Path("results") / source.name / f"U{speed:.12g}").resolve()
    _refuse_overlap(source.path, folder)
    if not is_finished(folder, source.fingerprint(settings, np)):
        require_acting_velocity(source, [(speed, settings)])
    with ProgressDisplay(console) as display:

        def on_step(share: float, step: Step) -> None:
            display.update(f"{source.name}", share, note(step))

        run_case(
            source, folder, settings, np, on_step, anew=False, extend=extend, frames=frames,
            say=_say,
        )  # fmt: skip
    _classify_folder(folder, folder, wide=wide)
    _plot(folder, formats)


@app.command(epilog="Example: elutria sweep cases/column --velocity 3:10:8 --to results/column")
def sweep(
    case: CaseArgument,
    velocity: VelocitiesOption = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(metavar="FILE:ENTRY=A:B:N|LIST", help="Vary another entry: a full grid."),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(help="A csv file, a row per run: gas_velocity_m_s and FILE:ENTRY columns."),
    ] = None,
    replicates: Annotated[int, typer.Option(help="Runs of each velocity, each own seed.")] = 1,
    jobs: Annotated[int, typer.Option(help="Runs at a time; 0: as many as cores.")] = 0,
    to: Annotated[Path | None, typer.Option(help="Folder of the results.")] = None,
    set_: SetOption = None,
    np: ProcessorsOption = 1,
    precision: Annotated[
        float | None,
        typer.Option(help="Replicates until the 95 % interval of d50 is +- this share of it."),
    ] = None,
    most_runs: Annotated[int, typer.Option(help="Runs of a velocity for --precision.")] = 12,
    budget: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Replicates for so much processor time: 10min, 2h."),
    ] = None,
    engine: Annotated[
        str,
        typer.Option(metavar="local|dask:ADDRESS|slurm[:OPTIONS]", help="Where the runs are done."),
    ] = "local",
    wide: WideOption = False,
    formats: FormatOption = None,
) -> None:
    """Run a case at several gas velocities, or other settings, side by side. What is finished is
    never run again; the tables hold all runs of the folder."""
    from elutria.case.case import Case
    from elutria.running.engine import open_engine, slots, threads_each
    from elutria.running.results import Results
    from elutria.running.sweep import paying, plan, run_sweep

    source = Case(case)
    wanted = _points(source, velocity, vary or [], points)
    folder = (to or Path("results") / source.name).resolve()
    _refuse_overlap(source.path, folder)
    members = plan(source, folder, wanted, replicates, set_ or [])
    results = Results(source, folder, set_ or [])
    goal = _goal(precision, most_runs, budget)
    each = np
    if engine == "local":
        choice = paying(source, members, np)
        each = choice.np
        if choice.why:
            _say(choice.why)
    at_once = slots(engine, jobs, each)
    together = at_once if goal else min(at_once, len(members))
    threads = threads_each(together, each) if engine == "local" else None
    with (
        open_engine(engine, jobs, each, (source.path, folder), _say) as executor,
        _SweepDisplay(len(members), at_once) as display,
    ):
        try:
            result = run_sweep(results, members, executor, np, display, goal, threads)
        except KeyboardInterrupt:
            done = sum(len(runs) for runs in results.finished().values())
            _say(f"{done} of {len(members)} runs are finished; their tables are in {folder}")
            raise
    _tell(result, at_once, goal, wide, folder)
    if result.tables.summary:
        _plot(folder, formats)
    _raise_failures(result.failures, len(members), folder)


@app.command(epilog="Example: elutria find cases/column --d50 500e-6 --to results/find")
def find(
    case: CaseArgument,
    d50: Annotated[float, typer.Option("--d50", help="The cut size that is asked for, m.")],
    vary: Annotated[
        str | None,
        typer.Option(metavar="FILE:ENTRY=A:B", help="Setting to find; default: gas velocity."),
    ] = None,
    material: Annotated[str, typer.Option(help="Whose cut size; default: of all.")] = "all",
    most_runs: Annotated[int, typer.Option(help="Runs at most.")] = 12,
    to: Annotated[Path | None, typer.Option(help="Folder of the results.")] = None,
    set_: SetOption = None,
    np: ProcessorsOption = 1,
    wide: WideOption = False,
    formats: FormatOption = None,
) -> None:
    """Find the gas velocity, or another setting, that has a cut size, in few runs."""
    from elutria.case.case import Case
    from elutria.running.inverse import answer

    source = Case(case)
    folder = (to or Path("results") / source.name).resolve()
    _refuse_overlap(source.path, folder)
    with _SweepDisplay(1, 1) as display:
        lines, tables = answer(
            source, folder, (d50, material, vary, most_runs), set_ or [], np, display
        )
    _show(tables, wide, folder)
    for line in lines:
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    _plot(folder, formats)


@app.command(epilog="Example: elutria classify results/column/U5 --json")
def classify(
    case: CaseArgument,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
    to: Annotated[Path | None, typer.Option(help="Folder of the tables; default: CASE.")] = None,
    wide: WideOption = False,
) -> None:
    """Outlet fractions and partition curve of a finished run."""
    summary = _classify_folder(case, to or case, quiet=as_json, wide=wide)
    if as_json:
        print(json.dumps([{k: _json(v) for k, v in row.items()} for row in summary], indent=2))


@app.command(epilog="Example: elutria plot results/column --format pdf")
def plot(
    results: ResultsArgument,
    formats: FormatOption = None,
) -> None:
    """Draw the figures again from the csv files."""
    _plot(results, formats, again=True)


@app.command(epilog="Example: elutria report results/column --to column.html --pdf")
def report(
    results: ResultsArgument,
    to: Annotated[Path | None, typer.Option(help="Default: RESULTS/report.html.")] = None,
    pdf: Annotated[bool, typer.Option("--pdf", help="Print it with Chromium, if there is one.")] = (
        False
    ),
) -> None:
    """One page to hand on: what was asked, the answer, how it came about. Needs no network."""
    from elutria.pages.browser import find_browser, print_pdf
    from elutria.pages.report import write_report

    page = write_report(results, to or results / "report.html")
    console.print(str(page), highlight=False, soft_wrap=True)
    if pdf:
        program = find_browser()
        if program is None:
            errors.print("no PDF: no Chromium or Chrome on PATH; open the page and print it")
        else:
            printed = print_pdf(program, page, page.with_suffix(".pdf"))
            console.print(str(printed), highlight=False, soft_wrap=True)


@app.command(epilog="Example: elutria atlas results/column --to atlas.html")
def atlas(
    results: ResultsArgument,
    to: Annotated[Path | None, typer.Option(help="Default: RESULTS/atlas.html.")] = None,
) -> None:
    """One page with sliders that answers between the runs of a sweep, and for other feeds."""
    from elutria.pages.atlas import write_atlas

    console.print(str(write_atlas(results, to or results / "atlas.html")), soft_wrap=True)


@app.command(epilog="Example: elutria compare results/column measured.csv --velocity 6")
def compare(
    results: ResultsArgument,
    measured: Annotated[
        Path,
        typer.Argument(
            metavar="MEASURED.csv", help="Sizes, shares to coarse or product masses, uncertainty."
        ),
    ],
    to: Annotated[Path | None, typer.Option(help="Folder; default: RESULTS/compare.")] = None,
    velocity: Annotated[float | None, typer.Option(help="Which of the results, m/s.")] = None,
    material: Annotated[str | None, typer.Option(help="Whose curve; default: that of all.")] = None,
    formats: FormatOption = None,
) -> None:
    """Compare with a measured partition curve: overlay, chi-square, differences with intervals."""
    from elutria.comparing.answer import write_comparison

    folder = to or results / "compare"
    lines, figures = write_comparison(results, measured, folder, velocity, material, formats or ())
    for line in [*lines, *map(str, figures)]:
        _say(line)


@app.command(epilog="Example: elutria view cases/column --velocity 5")
def view(
    place: Annotated[
        Path, typer.Argument(help="A case, which is run; or a run or a sweep, live or recorded.")
    ],
    to: Annotated[Path | None, typer.Option(help="Folder of the run of a case.")] = None,
    velocity: Annotated[float | None, typer.Option(help="Gas velocity, m/s.")] = None,
    set_: SetOption = None,
    np: ProcessorsOption = 1,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page; 0: any.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
    film: Annotated[
        Path | None, typer.Option("--record", help="Write a film: FILE.mp4, .gif or .html.")
    ] = None,
    speed: Annotated[float, typer.Option(min=0.01, help="Of the film over real time.")] = 1.0,
) -> None:
    """Watch a column in the browser and steer it, on this machine only; or make a film of it."""
    from elutria.viewing import film as films
    from elutria.viewing import view as viewing

    if film is not None:
        films.check_film(film)
        films.require_one(place)
    run = place
    if not viewing.is_run(place):
        run = viewing.folder_for(place, to)
        _refuse_overlap(place, run)
        arguments = viewing.run_arguments(place, velocity, set_ or [], np, run)
        if film is None:
            viewing.view_case(arguments, run, port, _say, browser=browser)
            return
        viewing.run_case_to_end(arguments, run)
    if film is None:
        viewing.look_on(viewing.session_for(run), port, _say, browser=browser)
        return
    from elutria.running.progress import ProgressDisplay

    with ProgressDisplay(console) as display:
        films.record(run, film, speed, lambda share: display.update(film.name, share))
    _say(str(film))


def _say(line: str) -> None:
    console.print(line, highlight=False, markup=False, soft_wrap=True)


@app.command(epilog="Example: elutria vtk results/column/U5")
def vtk(
    case: CaseArgument,
    to: Annotated[Path | None, typer.Option(help="Folder of the .vtu files.")] = None,
) -> None:
    """Write a run's gas and particles as .vtu and .pvd files that ParaView opens."""
    from elutria.output.vtk import write_vtk

    for path in write_vtk(case, to or case / "VTK"):
        console.print(str(path), highlight=False, soft_wrap=True)


def _points(
    source: Case, velocity: str | None, vary: list[str], points: Path | None
) -> list[Point]:
    """The points of a sweep, by a file or by its axes."""
    from elutria.running.axes import grid, read_points

    if points is not None:
        if velocity is not None or vary:
            raise InputError(f"--points {points}: allowed: either it, or --velocity and --vary")
        return read_points(source, points)
    if velocity is None and not vary:
        raise InputError("--velocity: is missing; allowed: it, --vary or --points")
    return grid(source, velocity, vary)


def _goal(precision: float | None, most_runs: int, budget: str | None) -> Precision | Budget | None:
    """What replicates are run for; None: there are as many as were asked for."""
    from elutria.classification.precision import Precision
    from elutria.running.budget import parse_budget

    if precision is not None and budget is not None:
        raise InputError(f"--budget {budget}: allowed: either it, or --precision")
    if budget is not None:
        return parse_budget(budget)
    return None if precision is None else Precision(precision, most_runs)


def _tell(
    result: SweepResult,
    at_once: int,
    goal: Precision | Budget | None,
    wide: bool,
    folder: Path,
) -> None:
    """What a sweep has cost and found, with its warnings."""
    from elutria.classification.precision import Precision
    from elutria.estimates.price import in_words
    from elutria.running import costs

    if result.skipped:
        console.print(f"{result.skipped} runs were complete before", style="dim")
    if result.ran:
        _say(f"spent by {in_words(costs.came_to(result.ran), at_once)}")
    _show(result.tables, wide, folder)
    _warn(result.warnings)
    if isinstance(goal, Precision):
        width = f"+- {100 * goal.half_width:g} % after {goal.most_runs} runs. Increase --most-runs."
        for name in result.imprecise:
            console.print(f"{name}: the 95 % interval of d50 is wider than {width}")


def _raise_failures(failures: Mapping[str, str], runs: int, folder: Path) -> None:
    for name, reason in failures.items():
        errors.print(f"{name}: {reason}", style="red", markup=False, soft_wrap=True)
    if failures:
        raise ElutriaError(f"{len(failures)} of {runs} runs failed; the others are in {folder}")


def _refuse_overlap(case: Path, folder: Path) -> None:
    source = case.resolve()
    if folder == source or source.is_relative_to(folder) or folder.is_relative_to(source):
        raise InputError(f"--to {folder}: lies within the case {case} or holds it; choose another")


def _classify_folder(folder: Path, to: Path, quiet: bool = False, wide: bool = False) -> list[Row]:
    from elutria.case.case import Case
    from elutria.classification.classify import classify as classify_run
    from elutria.classification.crossings import write_crossings
    from elutria.classification.events import read_run
    from elutria.estimates.model_error import model_errors
    from elutria.estimates.theory import write_theory
    from elutria.running.gas import gas_warnings, write_gas
    from elutria.running.marker import FINISHED
    from elutria.running.run import wall_time
    from elutria.warned import read_warnings, set_tool_warnings, solver_warnings

    case = Case(folder)
    seconds = wall_time(folder) if (folder / FINISHED).is_file() else float("nan")
    velocity = case.velocity_of_run()
    run = read_run(folder)
    labels = gas_warnings(folder, velocity)
    warned = len(solver_warnings(folder)) + len(labels)
    tables = classify_run(run, velocity, seconds, warned, model_errors(case))
    tables.write(to)
    set_tool_warnings(folder, [*labels, *tables.notes])
    write_theory(case, [velocity], to)
    write_gas(to, [({"gas_velocity_m_s": velocity}, folder)])
    write_crossings(folder, to, run.events.partition_to)
    if not quiet:
        _show(tables, wide, to)
        _warn({f"{velocity:g} m/s": read_warnings(folder)})
    lost, mass = run.accounts["all"].lost
    if lost:
        raise ElutriaError(
            f"{folder}: {lost:.12g} particles, {mass:.3g} kg, are in no product and not inside; "
            "allowed: none lost (see the end of log.elutriaFoam)"
        )
    return tables.summary


def _warn(runs: Mapping[str, list[Warned]]) -> None:
    """The warnings of runs, by kind; nothing where there are none."""
    from elutria.warned import grouped

    for line in grouped(runs):
        console.print(
            f"Warning: {line}", highlight=False, markup=False, soft_wrap=True, style="yellow"
        )


def _show(tables: Classification, wide: bool, folder: Path) -> None:
    from elutria.output.results import read_theory
    from elutria.output.settings import Settings
    from elutria.output.terminal import print_table, summary_table
    from elutria.tables import product_names

    if tables.summary:
        settings = Settings(tables.summary, tables.partition)
        fines = product_names(tables.partition, tables.product_partition)["fines"]
        table, keys = summary_table(tables.summary, settings, wide, read_theory(folder), fines)
        print_table(console, table, keys)
        if not wide:
            console.print("every column: summary.csv, or --wide", style="dim")


def _prepare_to_draw() -> None:
    """Load what draws the figures while other runs are at work."""
    Thread(target=import_module, args=["elutria.output.plots"]).start()


def _plot(folder: Path, formats: list[str] | None, again: bool = False) -> None:
    """Draw the figures of RESULTS where they are older than its tables, or `again`; name them."""
    from elutria.output.results import current_figures, formats_of

    wanted = formats_of(formats or ())
    figures = [] if again else current_figures(folder, wanted)
    if not figures:
        from elutria.output.plots import write_figures

        figures = write_figures(folder, wanted)
    for path in figures:
        console.print(str(path), highlight=False, soft_wrap=True)


def _json(value: Any) -> Any:
    return None if isinstance(value, float) and not isfinite(value) else value


class _SweepDisplay:
    """Shows a sweep: a bar per running velocity and one for all of it."""

    def __init__(self, runs: int, at_once: int):
        from elutria.running.progress import ProgressDisplay

        self.display = ProgressDisplay(console, every=10.0)
        self.shares: dict[str, float] = {}
        self.runs = runs
        self.at_once = at_once
        self.began = monotonic()

    def __enter__(self) -> _SweepDisplay:
        self.display.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self.display.__exit__(*error)

    def progress(self, name: str, share: float, note: str) -> None:
        self.shares[name] = share
        self.display.update(name, share, note)
        self._all()

    def _all(self) -> None:
        from elutria.estimates.price import duration

        runs = max(self.runs, len(self.shares))  # a search does not know how many it makes
        share, gone = sum(self.shares.values()) / runs, monotonic() - self.began
        left = f"{duration(gone * (1 - share) / share)} left" if share > 0.02 else ""
        self.display.update("all", share, left)

    def planned(self, runs: int) -> None:
        self.runs = runs

    def expected(self, cost: Price) -> None:
        from elutria.estimates.price import in_words

        self.display.say(f"expected of {in_words(cost, self.at_once)}")

    def finished(self, name: str, line: str) -> None:
        _prepare_to_draw()
        self.shares[name] = 1.0
        self.display.close(name)
        self.display.say(f"{name}: {line}")
        self._all()


def _add_commands() -> None:
    """The commands of other packages (entry points `elutria.commands`); bench and verify say where
    they come from while that package is not installed. They are not looked for where a command of
    this package is called: that would take a quarter of its start."""
    own = {command.callback.__name__ for command in app.registered_commands if command.callback}
    if own & set(sys.argv[1:2]) and not {"-h", "--help"} & set(sys.argv):
        return
    from importlib.metadata import entry_points

    for point in entry_points(group="elutria.commands"):
        point.load()(app)
    known = {command.callback.__name__ for command in app.registered_commands if command.callback}
    for name in {"bench", "verify"} - known:

        @app.command(
            name, context_settings={"allow_extra_args": True, "ignore_unknown_options": True}
        )
        def missing(context: typer.Context) -> None:
            """Not installed: python -m pip install -e tools/validation"""
            raise InputError(
                f"{context.info_name}: is not installed; in a clone of the project: "
                "python -m pip install -e tools/validation"
            )


_add_commands()


def _start_in_utf8() -> None:
    """Start this program again with names of files in UTF-8, as it writes them, where the locale
    has them in another encoding. Raises InputError for a name that is not UTF-8."""
    if sys.getfilesystemencoding() != "utf-8":
        os.environ["PYTHONUTF8"] = "1"  # of the programs that this one starts
        os.environ.setdefault("PYTHONIOENCODING", f"{sys.stdout.encoding}:backslashreplace")
        os.execv(sys.executable, [sys.executable, "-X", "utf8", *sys.orig_argv[1:]])
    names = sys.argv[1:]
    with suppress(OSError):
        names.append(str(Path.cwd()))
    for name in names:
        if (plain := os.fsencode(name)).decode(errors="replace") != name:
            shown = plain.decode("ascii", "backslashreplace")
            raise InputError(f"{shown}: is not UTF-8; allowed: names in UTF-8")


def main(arguments: list[str] | None = None) -> None:
    """Entry point: one line and exit code 1 or 2 for what goes wrong."""
    called = arguments is None
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    state["debug"] = "--debug" in arguments  # wherever it stands
    try:
        if called:
            _start_in_utf8()
        code = app([word for word in arguments if word != "--debug"], standalone_mode=False)
        if code == INTERRUPTED:
            raise KeyboardInterrupt
    except ElutriaError as error:
        _fail(str(error), error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        _fail("interrupted; the same command goes on where it stopped", 1)
    except OSError as error:
        code = 1 if error.errno in NOT_THE_PLACE else 2
        _fail(f"{error.filename or 'a file'}: {error.strerror or one_line(error)}", code)
    except Exception as error:
        if hasattr(error, "format_message"):  # an option that typer refuses
            _fail(f"{one_line(error.format_message())}; see elutria --help", 2)
        _fail(f"internal error: {type(error).__name__}: {one_line(error)}; see --debug", 1)


def _fail(line: str, code: int) -> None:
    if state["debug"]:
        traceback.print_exc()
    errors.print(f"elutria: {line}", markup=False, highlight=False, soft_wrap=True)
    sys.exit(code)
