"""What the plan skips changes nothing it promised to keep, also where it misjudged the scene."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from elutria.case.case import PARAMETERS, Case
from elutria.classification.events import Events, read_run
from elutria.running.run import ask_plan, run_case
from elutria_validation.chapters.classification import GRAINS, loaded
from elutria_validation.harness.cases import CLOUD, read_gas, times
from elutria_validation.harness.programs import project_root
from elutria_validation.harness.scenes import CoarseColumn, contacts, settling_bed

Note = Callable[[str, float, float], None]


@pytest.mark.parametrize(("start", "end"), [(3, 6), (6, 3), (0.1, 5)])
def test_gas_at_rest_wakes_when_its_inlet_changes(tmp_path: Path, start: float, end: float) -> None:
    """A ramp within 0.1 s, and particles too few to be felt."""
    ramp = f"(0 (0 0 {start})) (0.1 (0 0 {start})) (0.2 (0 0 {end})) (9 (0 0 {end}))"
    case = tmp_path / "case"
    output = CoarseColumn(start, 1e-5, inlet=ramp, particles=20).run(case)
    through = read_gas(case, times(case)[-1])[:, 2].mean()
    assert through == pytest.approx(end, rel=0.02)
    assert "left at rest" in output


def test_gas_at_rest_leaves_the_products_as_they_are(tmp_path: Path) -> None:
    """Grains within 20 % of the cut, solved on every step and as the plan decides."""
    every = loaded(tmp_path / "every", 0.2, "four-way")
    plan = loaded(tmp_path / "plan", 0.2, "four-way", gas="auto")
    assert len(plan) == len(every) == GRAINS
    shares = [float(np.mean(e.select(e.has_left).is_coarse)) for e in (every, plan)]
    chance = 1.96 * (0.5 / GRAINS) ** 0.5  # both products are about equal
    assert shares[0] == pytest.approx(shares[1], abs=chance)


def default_column(
    folder: Path, velocity: float, *settings: str, neighbour: Path | None = None
) -> Case:
    """The default column, run with settings."""
    case = Case(project_root() / "cases/column")
    return run_case(case, folder, case.settings_for(velocity, settings), neighbour=neighbour)


def test_gas_that_starts_from_its_neighbours_settles_sooner_to_the_same(tmp_path: Path) -> None:
    """As a sweep starts them; a few grains for a moment, the gas is what counts."""
    brief = [f"{PARAMETERS}:{text}" for text in ("particles=5", "feedTime=0.01", "drainTime=0.01")]
    neighbour = default_column(tmp_path / "neighbour", 5, *brief).path
    alone = default_column(tmp_path / "alone", 6, *brief).path
    helped = default_column(tmp_path / "helped", 6, *brief, neighbour=neighbour).path
    gas = [read_gas(case, times(case)[-1]) for case in (alone, helped)]
    assert np.sqrt(((gas[1] - gas[0]) ** 2).sum(axis=1).mean()) < 0.01 * 6
    steps = [settling_steps(case) for case in (alone, helped)]
    assert steps[1] < 0.6 * steps[0]
    assert seconds_of(alone, "gas") > 5 * seconds_of(alone, "particles")


SHORT = tuple(f"{PARAMETERS}:{text}" for text in ("particles=100", "feedTime=0.2", "drainTime=0.3"))


def same(one: Events, other: Events) -> bool:
    """Whether the same parcels left at the same times through the same outlets."""
    return all(
        np.array_equal(a, b, equal_nan=np.asarray(a).dtype.kind == "f")
        for a, b in zip(vars(one).values(), vars(other).values(), strict=True)
    )


def test_a_thin_feed_is_one_way_to_the_last_bit(tmp_path: Path) -> None:
    """The plan leaves the gas at rest: no parcel may notice."""
    thin = (*SHORT, f"{PARAMETERS}:loading=0.001")
    plan = default_column(tmp_path / "plan", 6, *thin).path
    alone = default_column(tmp_path / "alone", 6, *thin, f"{CLOUD}:solution/coupled=false").path
    assert "gas solved      0 times" in (plan / "log.elutriaFoam").read_text()
    assert same(read_run(plan).events, read_run(alone).events)


def test_laminar_gas_disperses_nothing_whatever_the_model(tmp_path: Path) -> None:
    laminar = (*SHORT, "constant/turbulenceProperties.air:simulationType=laminar")
    model = default_column(tmp_path / "model", 6, *laminar).path
    none = default_column(
        tmp_path / "none", 6, *laminar, f"{CLOUD}:subModels/dispersionModel=none"
    ).path
    assert "dispersion      skipped" in (model / "log.elutriaFoam").read_text()
    assert same(read_run(model).events, read_run(none).events)


def test_spheres_without_friction_move_as_with_hardly_any(tmp_path: Path) -> None:
    """Spin and tangential history are skipped without friction."""
    smooth, rough = (
        settling_bed(tmp_path / f"{friction}", contacts(friction=friction), end=0.016, step=1e-3)[1]
        for friction in (0, 1e-9)
    )
    assert np.abs(smooth.position - rough.position).max() < 1e-6  # of 1 mm
    assert np.abs(smooth.spin).max() == 0
    assert np.abs(rough.spin).max() > 0


def test_parcels_so_heavy_that_they_shift_the_cut_are_told_of(tmp_path: Path) -> None:
    """50 particles a parcel, of which some feel gas slowed by themselves by 12 %."""
    brief = ("feedTime=0.01", "drainTime=0.01")
    few = "constant/feed:particlesPerParcel=1000"
    for loading, particles, told in (1.5, 15, True), (1.5, 150, False), (0.2, 15, False):
        settings = (f"loading={loading}", f"particles={particles}", *brief)
        folder = tmp_path / f"{loading}-{particles}"
        default_column(folder, 6, *(f"{PARAMETERS}:{text}" for text in settings), few)
        log = (folder / "log.elutriaFoam").read_text()
        assert ("parcels so heavy" in log) == told


@pytest.mark.parametrize(
    ("loading", "asked", "fed"),
    [(0.2, 20, 20), (5, 20, 200), (5, 300, 707), (5, 800, 800)],
    ids=["dilute", "ten times at most", "enough", "as many as asked for"],
)
def test_a_dense_feed_has_parcels_of_few_particles(
    tmp_path: Path, loading: float, asked: int, fed: int
) -> None:
    """Some 4240 particles are fed; `elutria check` foresees as many parcels as the solver feeds."""
    settings = (f"loading={loading}", f"particles={asked}", "feedTime=0.025", "drainTime=0.001")
    case = default_column(tmp_path / "run", 4, *(f"{PARAMETERS}:{text}" for text in settings))
    assert len(read_run(case.path).events) == fed
    assert ask_plan(case)["feed"]["parcels"] == fed
    log = (case.path / "log.elutriaFoam").read_text()
    assert (f"{fed - asked} more than asked for" in log) == (fed > asked)


def test_steps_are_as_short_as_crowds_need(tmp_path: Path) -> None:
    """A particle collides 0.05 times in a step at most, as expected of the whole column."""
    longest = {}
    for loading in (0.2, 5, 10):
        settings = (f"loading={loading}", "particles=5", "feedTime=0.02", "drainTime=0.01")
        folder = tmp_path / f"{loading:g}"
        default_column(folder, 4, *(f"{PARAMETERS}:{text}" for text in settings))
        log = (folder / "log.elutriaFoam").read_text()
        longest[loading] = max(float(step) for step in re.findall(r"^deltaT = (\S+)", log, re.M))
        if loading > 1:
            collisions = float(re.findall(r"(\S+) collisions a particle", log)[0])
            stay = 0.5 / 4  # s, of the gas in the column
            assert longest[loading] == pytest.approx(0.05 * stay / collisions, rel=0.01)
    assert longest[0.2] == pytest.approx(4e-3)
    assert longest[5] == pytest.approx(2 * longest[10], rel=0.01)


def test_gas_at_rest_is_the_gas_of_every_step(tmp_path: Path, measured: Note) -> None:
    """A column in full feed: its load fluctuates by 5 % of the gas' momentum from block to block,
    and all of that in passing."""
    full = ("loading=0.2", "particles=800", "feedTime=0.2", "drainTime=0.001")
    settings = tuple(f"{PARAMETERS}:{text}" for text in full)
    plan = default_column(tmp_path / "plan", 4, *settings).path
    every = default_column(tmp_path / "every", 4, *settings, "system/scenePlan:gas=on").path
    gas = [read_gas(case, times(case)[-1]) for case in (plan, every)]
    difference = np.sqrt(((gas[1] - gas[0]) ** 2).sum(axis=1).mean()) / 4
    measured("rms difference of the gas over its velocity", difference, 0.02)
    solves = [
        int(re.findall(r"gas solved +(\d+) times", (case / "log.elutriaFoam").read_text())[0])
        for case in (plan, every)
    ]
    assert solves[0] < solves[1] / 8


def settling_steps(case: Path) -> int:
    """Steps in which the empty column's gas settled."""
    lines = (case / "log.elutriaFoam").read_text().splitlines()
    return int(next(line for line in lines if "gas settled in" in line).split()[4])


def seconds_of(case: Path, part: str) -> float:
    """What the account at the end gives a part of the work."""
    log = (case / "log.elutriaFoam").read_text()
    return float(re.findall(rf"^ +{part} +[\d.e-]+ % +([\d.e-]+) s$", log, re.MULTILINE)[-1])
