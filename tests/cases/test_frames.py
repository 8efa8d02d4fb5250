"""Frames show what the run's other files say; steering does what it says; neither ends a run."""

from __future__ import annotations

import csv
import os
import re
import resource
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from elutria.errors import ElutriaError
from elutria.viewing.frames import Frame, FrameReader, rises
from elutria.viewing.walls import read_walls
from elutria_validation.harness.box import BoxCase, Contacts
from elutria_validation.harness.cases import CONTROL, add_feed, change, material, read_gas, solve
from elutria_validation.harness.particles import read_particles
from tests.support.browser import wait_for

FEED = {
    "massFlowRate": 8e-3,
    "duration": 0.3,
    "particles": 400,
    "parcels": "evenSizes",
    "velocity": [0.2, 0, 0],
    "materials": material(2650, type="uniform", min=2e-4, max=6e-4),
}
FRAMES = ("-frames",)
FOLDER = "postProcessing/frames"


def box(folder: Path, end: float = 0.3, **entries: object) -> Path:
    case = BoxCase(
        gas_velocity=2, cells=(4, 4, 4), contacts=Contacts(), end=end, interval=0.1, **entries
    ).make(folder)
    add_feed(case, FEED)
    return case


def frames_of(case: Path) -> list[Frame]:
    reader = FrameReader(case)
    frames = list(reader)
    reader.close()
    return frames


def rows(case: Path, name: str = "outlets/*/particles.csv") -> dict[int, dict[str, str]]:
    """Recorded rows by the parcel's number."""
    found = {}
    for file in sorted((case / "postProcessing").glob(name)):
        with file.open() as table:
            found |= {int(row["id"]): row for row in csv.DictReader(table)}
    return found


def compare_departures(case: Path) -> None:
    """All that left are in the frames, once, as particles.csv has them."""
    left = np.concatenate([frame.departures for frame in frames_of(case)])
    told = rows(case)
    assert len(told) > 100
    assert sorted(left["id"].tolist()) == sorted(told)
    products = FrameReader(case).scene.products
    for record in left:
        row = told[int(record["id"])]
        assert products[record["product"]] == row["outlet"]
        for name, column in (("time", "time_s"), ("age", "residence_time_s"),
                             ("diameter", "diameter_m"), ("number", "n_particle")):  # fmt: skip
            assert record[name] == pytest.approx(float(row[column]), rel=1e-6, abs=1e-7)


def compare_inside(case: Path, frame: Frame) -> None:
    """Numbers, sizes and velocities are those of inside.csv, places those of OpenFOAM's file."""
    scene, told = FrameReader(case).scene, rows(case, "inside.csv")
    ids = frame.particles["id"].tolist()
    assert len(ids) > 20
    assert sorted(ids) == sorted(told)
    low, high = scene.box
    sizes, speeds, places = scene.diameters(frame), rises(frame), scene.positions(frame)
    for k, number in enumerate(ids):
        assert abs(sizes[k] - float(told[number]["diameter_m"])) < 6e-4 / 65535
        assert abs(speeds[k] - float(told[number]["uz_m_s"])) <= 0.5e-3 + 1e-9
    if not any(case.glob("processor*")):
        written = read_particles(case, f"{frame.time:g}").position
        nearest = np.abs(written[None] - places[:, None]).max(axis=2).min(axis=1)
        assert nearest.max() < ((high - low) / 65535).max()


@pytest.mark.parametrize("processors", [1, 2])
def test_frames_show_what_the_files_say(tmp_path: Path, processors: int) -> None:
    case = box(tmp_path / "box")
    change(case, {"system/frames:perSecond": 1000})
    solve(case, processors, options=FRAMES)
    frames = frames_of(case)
    compare_departures(case)
    compare_inside(case, frames[-1])
    assert frames[-1].time == pytest.approx(0.3)
    assert np.all(np.diff([frame.time for frame in frames]) > 0)
    # the gas: everywhere in the box as fast as it enters
    samples = frames[0].samples
    assert len(samples) > 1000
    assert np.all(np.abs(samples - 2000.0) <= 1)
    # a box of six sides: twelve edges, of four cells each
    walls = read_walls(case)
    length = np.linalg.norm(np.diff(walls.lines, axis=1), axis=2).sum()
    assert length == pytest.approx(12 * 0.1)
    assert len(walls.triangles) == 4 * 16 * 2


def test_nothing_is_written_unless_asked_for(tmp_path: Path) -> None:
    plain, shown = (box(tmp_path / name) for name in ("plain", "shown"))
    solve(plain)
    solve(shown, options=FRAMES)
    assert not (plain / FOLDER).exists()
    assert rows(plain) == rows(shown)


def test_a_case_may_ask_for_frames(tmp_path: Path) -> None:
    case = box(tmp_path / "box")
    change(case, {"system/frames:record": True})
    solve(case)
    assert frames_of(case)[-1].time == pytest.approx(0.3)


@pytest.mark.slow
def test_two_processors_are_steered_as_one_is(tmp_path: Path) -> None:
    one, two = (steered(tmp_path / name, "(0.1 1.5 2)") for name in ("one", "two"))
    solve(one)
    solve(two, processors=2, options=FRAMES)
    first, second = numbers(one), numbers(two)
    assert set(first) == set(second)
    for number, (_, weight) in first.items():
        assert second[number][1] == pytest.approx(weight)
    left, told = rows(one), rows(two)
    same = sum(row["outlet"] == told.get(k, row)["outlet"] for k, row in left.items())
    assert same == len(left) > 50
    assert frames_of(two)[-1].head["gas"] == 1.5
    compare_departures(two)


def test_frames_keep_to_their_rate(tmp_path: Path) -> None:
    case = box(tmp_path / "box")
    change(case, {"system/frames:perSecond": 200})  # of steps of 1 ms, on any machine
    solve(case, options=FRAMES)
    times = np.array([frame.time for frame in frames_of(case)])
    written = np.isclose(times, 0.1 * np.round(times / 0.1))  # one then too, for a restart
    gaps = np.diff(times[~written])
    assert len(gaps) > 0
    assert gaps.min() >= 1 / 200 - 1e-9


def test_a_restart_keeps_the_frames_before_it_and_no_others(tmp_path: Path) -> None:
    case = box(tmp_path / "box")
    change(case, {"system/frames:perSecond": 1000})
    solve(case, options=FRAMES)
    times = [frame.time for frame in frames_of(case)]
    for late in case.glob("0.[23]"):
        late.rename(case / f"was{late.name}")
    solve(case, options=FRAMES)
    again = [frame.time for frame in frames_of(case)]
    assert [t for t in again if t <= 0.1] == [t for t in times if t <= 0.1]
    assert np.all(np.diff(again) > 0)
    assert again[-1] == times[-1]
    compare_departures(case)


def test_the_limit_makes_frames_rarer(tmp_path: Path) -> None:
    """Half of the room at the full rate, the next quarter at half of it, and so on."""
    limit, rate = 1e5, 1000
    case = box(tmp_path / "box", end=1)
    change(case, {"system/frames:perSecond": rate, "system/frames:limit": limit / 1e6})
    solve(case, options=FRAMES)
    size = (case / FOLDER / "frames.bin").stat().st_size
    assert size <= limit
    frames = frames_of(case)
    filled = size - np.cumsum([len(frame.content) for frame in frames][::-1])[::-1]
    rarer = 2 ** np.floor(-np.log2(1 - filled[1:] / limit))
    assert rarer.max() >= 4
    times = np.array([frame.time for frame in frames])
    gaps = np.diff(times)
    written = np.abs(times[1:] - np.round(times[1:], 1)) < 1e-9  # these have a frame anyway
    assert np.count_nonzero(~written) > 10
    assert np.all((gaps >= rarer / rate - 1e-9)[~written])


def test_a_disk_that_takes_nothing_costs_a_warning(tmp_path: Path) -> None:
    case = box(tmp_path / "box")
    (case / FOLDER).mkdir(parents=True)
    (case / FOLDER / "frames.bin").symlink_to("/dev/full")
    log = solve(case, options=FRAMES)
    assert "elutria: finished" in log
    assert len(re.findall("Warning: .*frames.bin", log)) == 1


def test_a_disk_that_fills_up_leaves_whole_frames(tmp_path: Path) -> None:
    case = box(tmp_path / "box")
    change(case, {"system/frames:perSecond": 1000})
    most = 60_000

    def full() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    done = subprocess.run(
        ["elutriaFoam", *FRAMES], cwd=case, preexec_fn=full, capture_output=True, text=True,
        check=False, env=environment(case),
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-600:]
    assert len(re.findall("Warning: .*frames.bin", done.stdout)) == 1
    frames = frames_of(case)
    size = (case / FOLDER / "frames.bin").stat().st_size
    assert len(frames) > 5
    assert sum(len(frame.content) for frame in frames) < size <= most


def environment(case: Path) -> dict[str, str]:
    return {**os.environ, "PWD": str(case)}


# --- steering


def steered(folder: Path, changes: str, end: float = 0.3) -> Path:
    case = box(folder, end, solve_gas=True)
    (case / "system/steering").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object steering; }\n"
        f"changes ({changes});\n"
    )
    return case


def numbers(case: Path) -> dict[int, tuple[float, float]]:
    """Of every parcel: when it entered, and the particles that it stands for."""
    table = {**rows(case), **rows(case, "inside.csv")}
    return {
        number: (float(row["time_s"]) - float(row["residence_time_s"]), float(row["n_particle"]))
        for number, row in table.items()
    }


def test_a_column_is_steered_by_its_file(tmp_path: Path) -> None:
    plain, changed = box(tmp_path / "plain", solve_gas=True), steered(
        tmp_path / "steered", "(0.1 1.5 1) (0.2 1.5 3)"
    )  # fmt: skip
    solve(plain)
    log = solve(changed)
    assert re.findall(r"elutria: gas velocity (\S+) times, loading (\S+) times", log) == [
        ("1.5", "1"), ("1.5", "3"),
    ]  # fmt: skip
    assert read_gas(changed, "0.1")[:, 2].mean() == pytest.approx(2, rel=1e-2)
    assert read_gas(changed, "0.3")[:, 2].mean() == pytest.approx(3, rel=1e-2)
    before, after = numbers(plain), numbers(changed)
    assert set(before) == set(after)
    for number, (entered, weight) in before.items():
        if abs(entered - 0.2) > 2e-3:  # a parcel enters within a step
            factor = 3 if entered > 0.2 else 1
            assert after[number][1] == pytest.approx(factor * weight)
    assert sum(entered > 0.2 for entered, _ in before.values()) > 50
    total = (changed / "postProcessing/ledger.json").read_text()
    assert re.search(r'"lost": \{"parcels": 0, "number": 0', total)


INFLOWS = {
    "fixedValue": {"value": "uniform (0 0 2)"},
    "surfaceNormalFixedValue": {"refValue": "uniform -2"},
    "flowRateInletVelocity": {"volumetricFlowRate": 0.02, "value": "uniform (0 0 2)"},
    "uniformFixedValue": {"uniformValue": "constant (0 0 2)"},
}
"""Conditions that let the gas in at 2 m/s, through 0.1 m x 0.1 m."""


@pytest.mark.parametrize("kind", INFLOWS)
def test_gas_that_enters_otherwise_is_steered_too_or_named(tmp_path: Path, kind: str) -> None:
    case = steered(tmp_path / "box", "(0.1 1.5 1)")
    text = (case / "0/U.air").read_text()
    entries = "".join(f"{name} {value}; " for name, value in INFLOWS[kind].items())
    condition = f"inflow {{ type {kind}; phi phi.air; {entries} }}"
    text, found = re.subn(r"inflow\s*\{[^}]*\}", condition, text, count=1)
    assert found == 1
    (case / "0/U.air").write_text(text)
    log = solve(case)
    known = kind != "uniformFixedValue"
    speed = read_gas(case, "0.3")[:, 2].mean()
    assert speed == pytest.approx(3 if known else 2, rel=1e-2)
    named = re.findall(r"Warning: the gas that enters through \S*bottom\S* cannot be steered", log)
    assert len(named) == (0 if known else 1)


def test_a_steered_run_goes_on_as_if_uninterrupted(tmp_path: Path) -> None:
    changes = "(0.05 1.5 2) (0.1 1 1) (0.2 0.8 1)"
    whole, parts = (steered(tmp_path / name, changes) for name in ("whole", "parts"))
    solve(whole)
    for end in (0.1, 0.3):
        change(parts, {f"{CONTROL}:endTime": end})
        solve(parts)
    first, second = rows(whole), rows(parts)
    assert len(first) > 50
    assert set(first) == set(second)
    for number, row in first.items():
        for name in ("time_s", "n_particle", "uz_m_s"):
            assert float(row[name]) == pytest.approx(float(second[number][name]), abs=1e-6)


def test_impossible_changes_are_refused(tmp_path: Path) -> None:
    for changes in ("(0.1 0 1)", "(0.1 1 -1)", "(0.2 1 1) (0.1 2 1)"):
        case = steered(tmp_path / re.sub(r"\W+", "_", changes), changes)
        with pytest.raises(ElutriaError, match=r"steering.*allowed: \(time gas loading\)"):
            solve(case)


@contextmanager
def running(case: Path) -> Iterator[subprocess.Popen[bytes]]:
    with (case / "log").open("wb") as log:
        process = subprocess.Popen(
            ["elutriaFoam", *FRAMES], cwd=case, stdout=log, env=environment(case)
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


def ask(case: Path, text: str) -> None:
    draft = case / FOLDER / "control.new"
    draft.write_text(text)
    draft.rename(case / FOLDER / "control")


def test_a_running_column_is_steered_paused_and_paced(tmp_path: Path) -> None:
    case = box(tmp_path / "box", end=1000, solve_gas=True)
    change(case, {"constant/feed:duration": 900, "constant/feed:particles": 900_000})
    (case / FOLDER).mkdir(parents=True)
    ask(case, "pause yes;")  # of an earlier run: not meant for this one
    with running(case):
        wait_for(lambda: (case / FOLDER / "frames.bin").is_file() and frames_of(case), 60, "frames")
        log = case / "log"
        ask(case, "gas 1.25; loading 2; speed 0.1;")
        wait_for(lambda: "velocity 1.25 times, loading 2 times" in log.read_text(), 30, "a change")
        wait_for(lambda: frames_of(case)[-1].head["gas"] == 1.25, 30, "a frame of it")
        ask(case, "gas many;")
        wait_for(lambda: re.search("Warning: .*control is ignored", log.read_text()), 30, "a line")
        ask(case, "gas 1.25; loading 2; pause yes;")
        wait_for(lambda: len(set(_sizes(log))) == 1, 30, "a pause")
        ask(case, "gas 0.5; loading 2;")
        wait_for(lambda: "velocity 0.5 times, loading 2 times" in log.read_text(), 30, "it goes on")
        wait_for(lambda: frames_of(case)[-1].head["gas"] == 0.5, 30, "a frame of it")
    kept = (case / "system/steering").read_text()
    done = re.findall(r"velocity (\S+) times, loading (\S+) times.* time (\S+)", log.read_text())
    told = re.findall(r"\((\S+) (\S+) (\S+)\)", kept)
    assert [(gas, loading) for gas, loading, _ in done] == [("1.25", "2"), ("0.5", "2")]
    assert [tuple(map(float, (g, w, t))) for t, g, w in told] == [
        pytest.approx(tuple(map(float, row)), rel=1e-9) for row in done
    ]
    # shown after a step of 1 ms, or 33 ms of the clock at a tenth of real time: not after 33 ms
    for gas, _, since in done:
        shown = next(one.time for one in frames_of(case) if one.head["gas"] == float(gas))
        assert shown - float(since) < 0.006


def _sizes(log: Path) -> Iterator[int]:
    """The log's size, now and for a while."""
    for _ in range(5):
        yield log.stat().st_size
        time.sleep(0.1)
