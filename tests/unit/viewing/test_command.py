"""`elutria view` refuses what it cannot show in one line, before anything is run."""

from __future__ import annotations

import fcntl
import shutil
import socket
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from elutria.case.case import Case
from elutria.cli import main
from elutria.running.marker import Identity, Marker
from elutria.running.run import _steered
from elutria.viewing.film import RATE, SIZE, record
from elutria.viewing.sessions import is_going_on
from tests.support.frames import falling, write_run


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    with pytest.raises(SystemExit) as end:
        main(["view", "--no-browser", *arguments])
    assert end.value.code == 2
    said = capsys.readouterr().err.strip()
    assert "\n" not in said
    return said


def test_what_is_no_case_and_no_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "no such folder" in refused(capsys, str(tmp_path / "nowhere"))
    for name in ("U5", "U6"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "elutria.json").write_text("{}")
    assert "none of its 2 runs has recorded frames" in refused(capsys, str(tmp_path))
    assert "no frames were recorded" in refused(capsys, str(tmp_path / "U5"))


def test_a_finished_run_is_not_overwritten(
    column: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    run.mkdir()
    (run / "finished.json").write_text("{}")
    assert "holds a finished run" in refused(capsys, str(column), "--to", str(run))
    assert (run / "finished.json").is_file()


def test_the_frames_of_a_run_that_goes_on_stay(
    column: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A second view of a case in the same folder is refused, not the first one spoilt."""
    frames = tmp_path / "run/postProcessing/frames/frames.bin"
    frames.parent.mkdir(parents=True)
    frames.touch()
    with (tmp_path / ".run.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(SystemExit) as end:
            main(["view", "--no-browser", str(column), "--to", str(tmp_path / "run")])
    assert end.value.code == 1
    assert "locked by another elutria" in capsys.readouterr().err
    assert frames.is_file()


def test_the_frames_of_a_run_of_other_inputs_stay(
    column: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of an earlier view at another velocity, in the folder that is taken if none is given."""
    monkeypatch.chdir(tmp_path)
    run, case = tmp_path / "results" / column.name / "view", Case(column)
    frames = run / "postProcessing/frames/frames.bin"
    frames.parent.mkdir(parents=True)
    frames.touch()
    settings = case.settings_for(5, [])
    Marker(Identity.of(case, settings), case.fingerprint(settings), ready=True).write(run)
    said = refused(capsys, str(column), "--velocity", "6")
    assert (
        "holds a run of other inputs (system/simulationParameters:gasVelocity (5, now 6))" in said
    )
    assert frames.is_file()


def test_a_film_of_another_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = write_run(tmp_path / "run", falling(3))
    assert ".mp4, .gif, .html" in refused(capsys, str(run), "--record", str(tmp_path / "a.avi"))


def test_mp4_without_ffmpeg_says_how_to_get_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    run = write_run(tmp_path / "run", falling(3))
    assert "apt-get install ffmpeg" in refused(
        capsys, str(run), "--record", str(tmp_path / "a.mp4")
    )


def test_a_port_that_is_taken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = write_run(tmp_path / "run", falling(3))
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        assert f"--port {port}: " in refused(capsys, str(run), "--port", str(port))


def test_a_gif_has_the_recording_s_length_and_moves(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", falling(12))
    shares: list[float] = []
    record(run, tmp_path / "film.gif", 0.5, shares.append)
    with Image.open(tmp_path / "film.gif") as film:
        pictures = [frame.convert("RGB").tobytes() for frame in ImageSequence.Iterator(film)]
        length = sum(frame.info["duration"] for frame in ImageSequence.Iterator(film)) / 1000
    assert length == pytest.approx(0.55 / 0.5, abs=2 / RATE)
    assert len(set(pictures)) == 12
    assert shares[-1] == 1


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg: apt-get install ffmpeg")
def test_an_mp4_opens_and_has_the_frames(tmp_path: Path) -> None:
    """Decoded again: as many pictures as the recording is long, with each frame in them."""
    run = write_run(tmp_path / "run", falling(12))
    record(run, tmp_path / "film.mp4", 0.5, lambda _: None)
    size = (int(100 * SIZE[0]), int(100 * SIZE[1]))
    decoded = subprocess.run(
        ["ffmpeg", "-v", "error", "-i", tmp_path / "film.mp4", "-f", "rawvideo", "-pix_fmt",
         "rgb24", "-"], capture_output=True, check=True,
    )  # fmt: skip
    assert decoded.stderr == b""
    pictures = np.frombuffer(decoded.stdout, np.uint8).reshape(-1, size[1], size[0], 3)
    # 0.55 s of the run at half speed
    assert len(pictures) == pytest.approx(0.55 / 0.5 * RATE + 1, abs=1)
    sides = pictures[:, :, : size[0] // 5].astype(int)  # the column, not the curve
    moved = [np.abs(after - before).max() > 150 for before, after in pairwise(sides)]
    assert sum(moved) == 11  # twelve frames were recorded, each is there
    orange = sides[5][..., 0] - sides[5][..., 2] > 80  # colours are half as sharp as shapes
    assert orange.sum() > 1000  # 200 parcels


def test_a_run_goes_on_while_its_folder_is_locked(tmp_path: Path) -> None:
    run = tmp_path / "run"
    assert not is_going_on(run)
    with (tmp_path / ".run.lock").open("w") as lock:
        assert not is_going_on(run)
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert is_going_on(run)
    assert not is_going_on(run)


def test_a_steered_run_is_not_one_of_the_case(column: Path, tmp_path: Path) -> None:
    case, run = Case(column), tmp_path / "run"
    (run / "system").mkdir(parents=True)
    assert _steered(case, run, "hash") == "hash"
    (run / "system/steering").write_text("changes ((1 2 1));")
    assert _steered(case, run, "hash") != "hash"
    (column / "system/steering").write_text("changes ((1 2 1));")
    assert _steered(case, run, "hash") == "hash"
