"""Frames that were written byte by byte are read as what they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elutria.errors import InputError
from elutria.running.run import FRAMES
from elutria.viewing.control import Control
from elutria.viewing.frames import Frame, FrameReader, rises
from elutria.viewing.recording import Recording
from elutria.viewing.statistics import Statistics, summary
from elutria.viewing.walls import read_walls
from tests.support.frames import CUBE, falling, frame, write_run

ONE = frame(
    0.25, [(70000, (0.5, 0.25, 1.0), 0.001, -1.5)], [(3, 1, 0.0005)], [1000, 2000, 65535, 0, 1, 2]
)


def test_a_frame_is_read_as_it_was_meant(tmp_path: Path) -> None:
    reader = FrameReader(write_run(tmp_path, [ONE]))
    (found,) = reader
    assert found.time == 0.25
    assert found.particles["id"].tolist() == [70000]
    assert reader.scene.positions(found)[0] == pytest.approx([0.025, 0.0125, 0.5], abs=1e-5)
    assert reader.scene.diameters(found)[0] == pytest.approx(0.001, abs=2e-8)
    assert rises(found)[0] == pytest.approx(-1.5)
    assert found.departures["id"].tolist() == [3]
    assert found.departures["product"].tolist() == [1]
    assert found.samples.tolist() == [1000, 2000, 65535, 0, 1, 2]


def test_what_is_not_complete_waits(tmp_path: Path) -> None:
    file = write_run(tmp_path, [ONE, ONE]) / FRAMES
    whole = file.read_bytes()
    for cut in (1, 30, 64, len(ONE) - 1):
        file.write_bytes(whole[: len(whole) - cut])
        reader = FrameReader(tmp_path)
        assert len(list(reader)) == 1
        file.write_bytes(whole)
        assert len(list(reader)) == 1


@pytest.mark.parametrize(
    "content", [b"", b"ELUFRAM1", b"ELUFRAM2" + bytes(100), b"ELUFRAM1\x02\0\0\0{}", bytes(1000)]
)
def test_other_files_are_refused_in_one_line(tmp_path: Path, content: bytes) -> None:
    file = write_run(tmp_path, []) / FRAMES
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"frames\.bin: .*head|is not a file of frames"):
        FrameReader(tmp_path)


def test_bytes_between_frames_are_refused(tmp_path: Path) -> None:
    reader = FrameReader(write_run(tmp_path, [ONE, b"x" * 100]))
    assert reader.read() is not None
    with pytest.raises(InputError, match="no frame begins here"):
        reader.read()


def test_a_recording_knows_times_gas_and_fates(tmp_path: Path) -> None:
    recording = Recording(write_run(tmp_path, falling()))
    assert [recording.at(t) for t in (-1, 0, 0.06, 0.1, 99)] == [0, 0, 1, 2, len(recording) - 1]
    assert recording.frame(17).samples.tolist() == [11000] * 6  # of frame 10
    assert recording.frame(17).time == pytest.approx(0.85)
    fates = recording.fates()
    for departures in recording.departures:
        for row in departures:
            assert fates[row["id"]] == row["product"] + 1
    assert np.count_nonzero(fates) == sum(map(len, recording.departures)) > 100


def test_a_run_without_frames_says_how_to_get_them(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no frames were recorded.*elutria run --frames"):
        FrameReader(tmp_path)
    with pytest.raises(InputError, match="holds no frame yet"):
        Recording(write_run(tmp_path / "empty", []))


def test_another_gas_goes_with_a_frame() -> None:
    bare = Frame(frame(1, [(1, (0, 0, 0), 0.001, 0)]))
    dressed = bare.with_samples(np.array([7, 8], "<u2"))
    assert dressed.samples.tolist() == [7, 8]
    assert dressed.particles.tobytes() == bare.particles.tobytes()
    assert int(dressed.head["bytes"]) == len(dressed.content) == len(bare.content) + 4


# --- statistics


def test_the_curve_is_that_of_what_left(tmp_path: Path) -> None:
    """Fines below 900 um, coarse above: as in what write_run() was told."""
    recording = Recording(write_run(tmp_path, falling()))
    statistics = Statistics(recording.scene)
    for departures in recording.departures:
        statistics.add(departures)
    found = summary(recording.scene, statistics.rows(), 0.0)
    low, high = found["d50"][1:]
    assert low < 900e-6 < high
    rows = np.concatenate(recording.departures)
    masses = 2.0 * 2650 * np.pi / 6 * rows["diameter"].astype(float) ** 3
    for product in (0, 1):
        mass = found["products"][0]["mass_kg"][product]
        assert mass == pytest.approx(masses[rows["product"] == product].sum())
    sizes = [row[0] for row in found["curve"]]
    assert sizes == sorted(sizes)
    statistics.restart(1.0)
    statistics.add(rows)
    assert sorted(statistics.rows()["id"]) == sorted(rows["id"][rows["time"] >= 1.0])


def test_of_a_few_parcels_there_is_no_curve(tmp_path: Path) -> None:
    recording = Recording(write_run(tmp_path, [ONE]))
    found = summary(recording.scene, recording.departures[0], 0.0)
    assert (found["curve"], found["d50"], found["parcels"]) == ([], None, 1)
    nothing = summary(recording.scene, recording.departures[0][:0], 0.0)
    assert nothing["products"] == [{"material": "quartz", "mass_kg": [0.0, 0.0]}]


# --- walls


def test_a_box_has_twelve_edges(tmp_path: Path) -> None:
    walls = read_walls(write_run(tmp_path, []))
    ends = {tuple(sorted(map(tuple, line.round(6).tolist()))) for line in walls.lines}
    assert len(ends) == len(walls.lines)
    assert np.linalg.norm(np.diff(walls.lines, axis=1), axis=2).sum() >= 8 * 0.05 + 4 * 0.5 - 1e-9
    assert len(walls.triangles) == 8  # the open bottom is not solid


def test_a_thin_wall_has_its_rim_alone(tmp_path: Path) -> None:
    """Two faces on either side of a plane, back to back, as a baffle is in a mesh."""
    file = write_run(tmp_path, []) / "postProcessing/frames/boundary.obj"
    points = [f"v {x} {y} 0" for y in (0, 1) for x in (0, 1, 2)]
    one, other = ["f -6 -5 -2 -3", "f -5 -4 -1 -2"], ["f -3 -2 -5 -6", "f -2 -1 -4 -5"]
    file.write_text("\n".join(["g up wall", *points, *one, "g down wall", *points, *other]))
    lines = read_walls(tmp_path).lines
    assert np.linalg.norm(np.diff(lines, axis=1), axis=2).sum() == pytest.approx(6)


def test_a_spoilt_boundary_is_refused(tmp_path: Path) -> None:
    file = write_run(tmp_path, []) / "postProcessing/frames/boundary.obj"
    for line in ("v 1 2", "f -1 x", "f -999 -998 -997"):
        file.write_text("\n".join([*CUBE, line]))
        with pytest.raises(InputError, match=r"boundary\.obj: is not"):
            read_walls(tmp_path)


# --- wishes


def test_a_wish_is_taken_as_far_as_it_makes_sense() -> None:
    control = Control().changed({"gas": 1.5, "pause": True, "speed": 1e9, "strange": 1})
    assert control == Control(gas=1.5, pause=True, speed=100.0)
    for rubbish in (None, [], "gas", {"gas": "2"}, {"gas": float("nan")}, {"gas": [1]}):
        assert control.changed(rubbish) == control
    assert control.changed({"gas": -5}).gas == 0.05


def test_a_wish_is_written_as_a_dictionary(tmp_path: Path) -> None:
    Control(gas=1.25, pause=True).write(tmp_path)
    text = (tmp_path / "postProcessing/frames/control").read_text()
    assert text.split() == ["gas", "1.25;", "loading", "1;", "pause", "yes;", "speed", "1;"]
