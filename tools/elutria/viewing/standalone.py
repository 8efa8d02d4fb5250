"""The page with a recording in it: one .html file that needs no server and no network."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from typing import Any

from elutria.errors import ElutriaError
from elutria.files import write_text
from elutria.viewing.frames import Scene
from elutria.viewing.recording import Recording
from elutria.viewing.server import page_files
from elutria.viewing.statistics import Statistics, summary
from elutria.viewing.walls import read_walls

LIMIT = 60_000_000
"""Bytes of the file, at most."""
CURVES = 15
"""Fits of the curve over the recording."""


def write_standalone(run: Path, to: Path, about: dict[str, Any], rate: float = 20.0) -> None:
    """Write the page of a run's recording, `rate` frames a second of the run."""
    recording = Recording(run)
    scene = recording.scene
    first, last = recording.times[0], recording.times[-1]
    count = max(int((last - first) * rate), 1)
    numbers = sorted({recording.at(first + (last - first) * k / count) for k in range(count + 1)})
    packed = zlib.compressobj(9)
    content = (
        b"".join(packed.compress(recording.frame(k).content) for k in numbers) + packed.flush()
    )
    data = {
        "scene": {
            "mode": "replay", "scene": scene.json, "walls": read_walls(run).as_json(),
            "about": {**about, "duration_s": last},
            "control": {"gas": 1, "loading": 1, "pause": False, "speed": 1},
        },
        "fates": base64.b64encode(recording.fates().tobytes()).decode(),
        "statistics": _curves(scene, recording, numbers),
        "frames": base64.b64encode(content).decode(),
    }  # fmt: skip
    recording.close()
    text = _page(data)
    if len(text) > LIMIT:
        raise ElutriaError(
            f"{to}: would have {len(text) / 1e6:.0f} MB, allowed: {LIMIT / 1e6:g} MB; record fewer "
            "frames (perSecond of system/frames) or a shorter run"
        )
    write_text(to, text)


def _curves(scene: Scene, recording: Recording, numbers: list[int]) -> list[dict[str, Any]]:
    """Statistics at some of the frames, each with the time from which it holds."""
    every = max(len(numbers) // CURVES, 1)
    statistics, counted, found = Statistics(scene), 0, []
    for number in [*numbers[::every], numbers[-1]]:
        for departures in recording.departures[counted : number + 1]:
            statistics.add(departures)
        counted = max(counted, number + 1)
        entry = summary(scene, statistics.rows(), 0.0)
        found.append({**entry, "time": recording.times[number]})
    return found


def _page(data: dict[str, Any]) -> str:
    """The page with its style, its script and its data in it."""
    files = {name: content.decode() for name, content in page_files().items()}
    text = json.dumps(data).replace("</", "<\\/")
    style = f"<style>{files['page.css']}</style>"
    script = files["page.js"].replace("</script", "<\\/script")
    page = files["index.html"].replace('<link rel="stylesheet" href="page.css">', style)
    block = (
        f'<script type="application/json" id="recording">{text}</script>\n<script>{script}</script>'
    )
    return page.replace('<script src="page.js"></script>', block)
