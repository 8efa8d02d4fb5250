"""What mesh, step and models move in the zigzag: its run time against its error.

The delivered case, fed within a quarter of a second and emptied for three, one thing changed at a
time, from as many seeds as `--option seeds`. Fits are of all seeds' parcels together, so that their
intervals hold chance; errors are from the finest mesh that was run. Seconds are of the processor,
mesh and start included, the seeds' median.

Runs lie in the folder's zigzag-runs. `--option only=prepare` makes their cases and run.sh, which
runs them on any machine that has elutriaFoam, blockMesh and decomposePar: `run.sh CORES SECONDS`
ends what is not finished by then. Brought back, what is finished is read and not run again;
`--option only=read` leaves out what is not there. `--option earlier=FILE` takes the rows of a table
that was made before for the points of which no run is here; zigzag.json says which, and where they
were made.
"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.figure import Figure

from elutria.case.case import Case, Setting
from elutria.classification.events import Events, join, read_run
from elutria.errors import ElutriaError
from elutria.files import read_csv, read_json, write_text
from elutria.output.style import COLUMN_WIDTH, STYLE, log_if_wide
from elutria.running.run import make_mesh, write_decomposition
from elutria_validation.benchmarks.accuracy_error import cut_of_events
from elutria_validation.benchmarks.accuracy_runs import BY_POINTS, GAS_ON, Changes, fed, step
from elutria_validation.harness.cases import PARAMETERS, change
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import project_root, slug
from elutria_validation.harness.provenance import write_result

NAME = "zigzag"
HELP = "run time against error in the zigzag: mesh, step, gas, walls, turbulence"
COLUMNS = (
    "point", "cell_size_m", "ranks", "seeds", "parcels", "inside", "d50_m", "d50_low_m",
    "d50_high_m", "d50_error", "sharpness", "sharpness_sd", "sharpness_error", "seconds",
)  # fmt: skip
CELL = 5e-3
"""m, of the delivered case."""
FEED_TIME, DRAIN_TIME = 0.25, 3.0
"""s."""
Row = dict[str, Any]


@dataclass(frozen=True)
class Point:
    """What is changed; `mesh` multiplies the cells along each edge. `ranks` makes a long run
    shorter, `seeds` is how many at most."""

    name: str
    changes: Changes
    mesh: float = 1
    ranks: int = 1
    seeds: int = 100

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return round(CELL / self.mesh, 6)


SPALDING = {'0.orig/nut.air:boundaryField/"walls|feedSlot"/type': "nutUSpaldingWallFunction"}
"""One law from the wall through the buffer layer: y+ may be anything."""
SST = {"constant/turbulenceProperties.air:RAS/RASModel": "kOmegaSST"}
LIMITED = {
    f"system/fvSchemes:divSchemes/div(alphaPhi.air,{name}.air)": ("Gauss", "limitedLinear", 1)
    for name in ("k", "epsilon")
}
"""k and epsilon by a limiter, with which the gas does not become steady."""
DEFAULT = "as delivered"
POINTS = (
    Point("mesh x 2", {}, 2, ranks=8, seeds=1),
    Point("mesh x 1.4", {}, 1.4, ranks=4),
    Point(DEFAULT, {}),
    Point("mesh x 0.7", {}, 0.7),
    Point("step x 0.5", step(0.5)),
    Point("gas on every step", GAS_ON, seeds=1),
    Point("k, epsilon limitedLinear", LIMITED, seeds=1),
    Point("Spalding's wall, mesh x 0.7", SPALDING, 0.7),
    Point("Spalding's wall", SPALDING),
    Point("gas by points, mesh x 0.7", BY_POINTS, 0.7),
    Point("gas by points", BY_POINTS),
    Point("kOmegaSST", SST),
    Point("Spalding's wall, mesh x 1.4", SPALDING, 1.4, ranks=4, seeds=1),
    Point("gas by points, mesh x 1.4", BY_POINTS, 1.4, ranks=4, seeds=1),
)
"""In the order in which they are run: what takes longest, then what matters most, first."""
QUICK = ("mesh x 0.7", "gas by points, mesh x 0.7")


@dataclass(frozen=True)
class Options:
    """Its own."""

    parcels: int = option(10000, quick=200, least=10)
    seeds: int = option(2, quick=1, least=1)
    ranks: int = option(8, least=1)
    only: Literal["all", "prepare", "read"] = option("all")
    earlier: Path | None = None


def run(job: Job, options: Options) -> None:
    """Make the cases, run what is not finished; writes zigzag.csv, .png and .json."""
    earlier = read_csv(options.earlier, COLUMNS, ("point",)) if options.earlier else []
    runs = job.folder / "zigzag-runs"
    points = [
        replace(one, ranks=min(one.ranks, options.ranks))
        for one in POINTS
        if not job.quick or one.name in QUICK
    ]
    todo = list(jobs(points, options.seeds))
    if options.only != "read":
        prepare(runs, todo, options.parcels)
    if options.only == "prepare":
        job.say(f"{runs}/run.sh CORES SECONDS")
        return
    for point, seed in todo if options.only == "all" else ():
        name = run_name(point, seed)
        if not (runs / f"{name}.json").is_file():
            job.say(name)
            subprocess.run(["bash", "run.sh", name], cwd=runs, check=True)
    rows = table(runs, points, options.seeds, earlier)
    kept = [one["point"] for one in rows if any(one is other for other in earlier)]
    notes = {}
    if options.earlier and kept:
        made = options.earlier.with_suffix(".json")
        notes["earlier"] = {"points": kept, **(read_json(made) if made.is_file() else {})}
    with mpl.rc_context(STYLE):
        write_result(job, NAME, COLUMNS, rows, figure(rows), notes)


def jobs(points: Sequence[Point], seeds: int) -> Iterator[tuple[Point, int]]:
    """All runs."""
    for point in points:
        for seed in range(1, 1 + min(seeds, point.seeds)):
            yield point, seed


def run_name(point: Point, seed: int) -> str:
    """The folder of a run."""
    return f"{slug(point.name)}-seed{seed}"


def prepare(runs: Path, todo: Sequence[tuple[Point, int]], parcels: int) -> None:
    """A case for each run that is not there, and run.sh. blockMesh's dictionary is made once for
    each size of cells."""
    plans: dict[float, Path] = {}
    for point, seed in todo:
        case = runs / run_name(point, seed)
        if point.cell not in plans:
            plans[point.cell] = mesh_plan(runs / f"mesh-{point.cell:g}", point.cell)
        if (case / "system").is_dir():
            continue
        make_case(case, point, seed, parcels)
        (case / "constant/polyMesh").mkdir()
        shutil.copy(plans[point.cell], case / "constant/polyMesh")
    write_text(runs / "run.sh", SCRIPT + "\n".join(
        f"go {run_name(point, seed)} {point.ranks}" for point, seed in todo
    ) + "\nwait\n")  # fmt: skip


def mesh_plan(folder: Path, cell: float) -> Path:
    """blockMesh's dictionary for cells of that size (m), as the case's own script writes it."""
    plan = folder / "constant/polyMesh/blockMeshDict"
    if not plan.is_file():
        shutil.rmtree(folder, ignore_errors=True)
        source = Case(project_root() / "cases/zigzag")
        setting = Setting(PARAMETERS, "cellSize", f"{cell:g}")
        make_mesh(source.copy_to(folder, [setting]))
    return plan


def make_case(case: Path, point: Point, seed: int, parcels: int) -> None:
    """The zigzag with the changes of a point."""
    Case(project_root() / "cases/zigzag").copy_to(case, [])
    changes = {
        f"{PARAMETERS}:cellSize": point.cell,
        f"{PARAMETERS}:seed": seed,
        **fed(parcels, FEED_TIME, DRAIN_TIME),
        **point.changes,
    }
    change(case, changes)
    if point.changes is SST:
        write_omega(case / "0.orig")
    shutil.rmtree(case / "0", ignore_errors=True)
    shutil.copytree(case / "0.orig", case / "0")
    if point.ranks > 1:
        write_decomposition(Case(case), point.ranks)


def write_omega(folder: Path) -> None:
    """omega.air (1/s) in the place of epsilon.air, of the same turbulence: epsilon/(0.09 k)."""
    text = (folder / "epsilon.air").read_text()
    for old, new in (
        ("epsilon.air", "omega.air"),
        ("[0 2 -3 0 0 0 0]", "[0 0 -1 0 0 0 0]"),
        ("uniform 0.82", "uniform 152"),
        ("turbulentMixingLengthDissipationRateInlet", "turbulentMixingLengthFrequencyInlet"),
        ("epsilonWallFunction", "omegaWallFunction"),
    ):
        if old not in text:
            raise ElutriaError(f"{folder / 'epsilon.air'}: has no '{old}'")
        text = text.replace(old, new)
    write_text(folder / "omega.air", text)
    (folder / "epsilon.air").unlink()


SCRIPT = """\
#!/bin/bash
# run.sh CORES SECONDS: all runs; what is not finished by then is ended. run.sh NAME: that one.
cd "$(dirname "$0")" || exit 1
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none

one() # NAME RANKS, in its folder
{
    blockMesh -dict constant/polyMesh/blockMeshDict > log.blockMesh 2>&1 || return
    if [ "$2" = 1 ]; then timeout $((end - SECONDS)) elutriaFoam; else
        decomposePar -force > log.decomposePar 2>&1 &&
            timeout $((end - SECONDS)) mpirun -np "$2" elutriaFoam -parallel
    fi > log.elutriaFoam 2>&1
}

timed() # NAME RANKS: seconds of processor in NAME.json, once it is finished
{
    [ -f "$1.json" ] && return
    rm -rf "$1"/postProcessing "$1"/processor* "$1"/[1-9]* "$1"/0.[0-9]*
    TIMEFORMAT='{"seconds": %U}'
    { time (cd "$1" && one "$1" "$2"); } 2> "$1.time"
    grep -q "^elutria: finished" "$1/log.elutriaFoam" && mv "$1.time" "$1.json"
    rm -rf "$1"/processor* "$1"/[1-9]* "$1"/0.[0-9]*
}

if [ $# = 1 ]; then only=$1; free=1000; else only=""; free=$1; fi
end=$((SECONDS + ${2:-1000000}))
declare -A width
go() # NAME RANKS, once as many cores are free
{
    [ -n "$only" ] && [ "$only" != "$1" ] && return
    while [ "$free" -lt "$2" ] && [ ${#width[@]} -gt 0 ]; do
        sleep 0.2
        for done in "${!width[@]}"; do
            kill -0 "$done" 2> /dev/null && continue
            free=$((free + width[$done])); unset "width[$done]"
        done
    done
    [ $SECONDS -ge $end ] && return
    timed "$1" "$2" &
    width[$!]=$2; free=$((free - $2))
}
"""


def table(
    runs: Path, points: Sequence[Point], seeds: int, earlier: Sequence[Row] = ()
) -> list[Row]:
    """A row per point of which a run is finished, or that `earlier` has; errors from that of the
    finest mesh which has the delivered models."""
    rows = []
    known = {one["point"]: one for one in earlier}
    for point in points:
        names = [run_name(point, seed) for _, seed in jobs([point], seeds)]
        done = [name for name in names if (runs / f"{name}.json").is_file()]
        if done:
            taken = median(float(read_json(runs / f"{name}.json")["seconds"]) for name in done)
            together = join([read_run(runs / name) for name in done])
            rows.append(row(point, len(done), taken, together.events))
        elif point.name in known:
            rows.append(known[point.name])
    if not rows:
        raise ElutriaError(f"{runs}: has no finished run; {runs}/run.sh runs them")
    plain = {point.name for point in points if not point.changes}
    finest = min((one for one in rows if one["point"] in plain), key=lambda one: one["cell_size_m"])
    for one in rows:
        one["d50_error"] = one["d50_m"] / finest["d50_m"] - 1
        one["sharpness_error"] = one["sharpness"] - finest["sharpness"]
    return rows


def row(point: Point, seeds: int, seconds: float, events: Events) -> Row:
    """The cut of a point's parcels, of all seeds together."""
    return {
        "point": point.name,
        "cell_size_m": point.cell,
        "ranks": point.ranks,
        "seeds": seeds,
        "parcels": len(events),
        "inside": int(events.is_inside.sum()),
        **cut_of_events(events).columns(),
        "seconds": seconds,
    }


def figure(rows: Sequence[Row]) -> Figure:
    """d50 and sharpness against seconds, with 95 % intervals of chance."""
    drawing = Figure(figsize=(2 * COLUMN_WIDTH, COLUMN_WIDTH))
    left, right = drawing.subplots(1, 2)
    seconds = [one["seconds"] for one in rows]
    for one in rows:
        x = [one["seconds"]]
        far = 1e6 * (one["d50_high_m"] - one["d50_m"])
        left.errorbar(x, [1e6 * one["d50_m"]], yerr=[far], marker="o", markersize=3,
                      label=f"{one['point']}")  # fmt: skip
        right.errorbar(x, [one["sharpness"]], yerr=[1.96 * one["sharpness_sd"]], marker="o",
                       markersize=3)  # fmt: skip
    for axes, name in ((left, "$d_{50}$  (µm)"), (right, "sharpness $d_{25}/d_{75}$")):
        log_if_wide(axes, min(seconds), max(seconds), "x")
        axes.set_xlabel("processor time  (s)")
        axes.set_ylabel(name)
    drawing.legend(loc="outside lower center", ncols=3, fontsize=5.5)
    return drawing
