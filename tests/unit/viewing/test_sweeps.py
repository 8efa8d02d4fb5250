"""`elutria view RESULTS`: the runs of a sweep, of which one is chosen, live or recorded."""

from __future__ import annotations

import asyncio
import fcntl
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from elutria.cli import main
from elutria.errors import InputError
from elutria.viewing.sweeps import SweepSession, runs_in
from tests.support.frames import falling, write_run


@pytest.fixture(autouse=True)
def page_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's files, as if they were built."""
    files = {"index.html": b"<p>page</p>", "page.css": b"p {}", "page.js": b"0;"}
    monkeypatch.setattr("elutria.viewing.server.page_files", lambda: files)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    """U5, U9 and U10 recorded, U7 not."""
    for name in ("U10", "U9", "U5"):
        write_run(tmp_path / name, falling(5))
    (tmp_path / "U7").mkdir()
    for name in ("U5", "U7", "U9", "U10"):
        (tmp_path / name / "elutria.json").write_text(json.dumps({"case": name}))
    (tmp_path / "sweep.json").write_text("{}")
    return tmp_path


async def told(page: ClientConnection, kind: str) -> dict[str, Any]:
    """The next message of a kind."""
    async for message in page:
        if isinstance(message, str) and json.loads(message)["kind"] == kind:
            return dict(json.loads(message))
    raise AssertionError("the stream has ended")


def watched(results: Path, talk: Any) -> None:
    """`talk(page)`, while the sweep is shown."""

    async def watch() -> None:
        session = SweepSession(results)
        address = await session.server.start()
        playing = asyncio.create_task(session.play())
        origin = address.rpartition("/")[0].rpartition("/")[0]
        try:
            async with connect(f"ws{address[4:]}stream", origin=origin) as page:
                await asyncio.wait_for(talk(page), 30)
        finally:
            playing.cancel()
            await session.server.stop()

    asyncio.run(watch())


def test_runs_are_in_the_order_of_their_numbers(results: Path) -> None:
    assert [run.name for run in runs_in(results)] == ["U5", "U7", "U9", "U10"]


def test_another_run_is_chosen(results: Path) -> None:
    async def talk(page: ClientConnection) -> None:
        runs = await told(page, "runs")
        assert runs["chosen"] == "U5"
        assert {run["name"]: run["state"] for run in runs["runs"]} == {
            "U5": "recorded", "U7": "", "U9": "recorded", "U10": "recorded",
        }  # fmt: skip
        await page.send(json.dumps({"run": "U7"}))  # has no frames
        await page.send(json.dumps({"run": "../U9"}))
        await page.send(json.dumps({"run": "U10"}))
        while (scene := await told(page, "scene"))["about"]["name"] != "U10":
            assert scene["about"]["name"] == "U5"
        assert scene["mode"] == "replay"
        assert (await told(page, "runs"))["chosen"] == "U10"
        await page.send(json.dumps({"control": {"pause": True}}))
        assert (await told(page, "control"))["control"]["pause"] is True

    watched(results, talk)


@pytest.fixture
def at_work(results: Path) -> Iterator[Any]:
    """An elutria that works on U9."""
    with (results / ".U9.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield lock


@pytest.mark.usefixtures("at_work")
def test_the_run_that_goes_on_is_watched_and_not_steered(results: Path) -> None:
    async def talk(page: ClientConnection) -> None:
        scene = await told(page, "scene")
        assert scene["about"]["name"] == "U9"
        assert scene["mode"] == "watch"
        await page.send(json.dumps({"control": {"gas": 2}}))
        assert (await told(page, "control"))["control"]["gas"] == 2
        await page.send(json.dumps({"run": "U5"}))
        assert (await told(page, "scene"))["mode"] == "replay"

    watched(results, talk)
    assert not (results / "U9/postProcessing/frames/control").exists()


def test_a_sweep_without_frames_is_refused(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as end:
        main(["view", "--no-browser", str(results), "--record", str(tmp_path / "film.gif")])
    assert end.value.code == 2
    assert "a film of one of them (U5, U7, U9, U10)" in capsys.readouterr().err
    for file in results.glob("*/postProcessing/frames/frames.bin"):
        file.unlink()
    with pytest.raises(InputError, match="none of its 4 runs has recorded frames"):
        SweepSession(results)
