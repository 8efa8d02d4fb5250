"""A run's frames written by hand, byte by byte as docs/user/outputs.md describes them."""

from __future__ import annotations

import json
import struct
from pathlib import Path

HEAD = {
    "box_m": [[0, 0, 0], [0.05, 0.05, 0.5]],
    "largest_diameter_m": 0.002,
    "up": [0, 0, 1],
    "materials": [{"name": "quartz", "density_kg_m3": 2650}],
    "products": ["fines", "coarse"],
    "slice": {
        "corner_m": [0, 0.025, 0],
        "across_m": [0.05, 0, 0],
        "along_m": [0, 0, 0.5],
        "points": [2, 3],
    },
}
CUBE = ("g walls wall", *(f"v {x} {y} {z}" for x in (0, 0.05) for y in (0, 0.05) for z in (0, 0.5)),
        "f -8 -7 -5 -6", "f -4 -2 -1 -3", "f -8 -4 -3 -7", "f -6 -5 -1 -2",
        "g bottom patch", *(f"v {x} {y} 0" for x in (0, 0.05) for y in (0, 0.05)), "f -4 -3 -1 -2",
        )  # fmt: skip


def frame(
    time: float,
    parcels: list[tuple[int, tuple[float, float, float], float, float]],
    left: list[tuple[int, int, float]] = [],  # noqa: B006
    samples: list[int] = [],  # noqa: B006
) -> bytes:
    """A frame of parcels (number, place as shares of the box, diameter in m, rise in m/s), of those
    that left (number, product, diameter in m), and of the gas (mm/s)."""
    body = b"".join(
        struct.pack(
            "<8H", *(round(65535 * share) for share in place), round(65535 * size / 0.002),
            round(1000 * rise + 32768), 0, number & 0xFFFF, number >> 16,
        )
        for number, place, size, rise in parcels
    )  # fmt: skip
    body += b"".join(
        struct.pack("<IHHffff", number, 0, product, time, 0.3, size, 2.0)
        for number, product, size in left
    )
    body += struct.pack(f"<{len(samples)}H", *samples)
    head = struct.pack(
        "<IIIIdddffIIII", 64 + len(body), len(parcels), len(left), len(samples),
        time, 2 * time, 0.001, 1.0, 1.0, len(parcels) + len(left), 0, 0, 0,
    )  # fmt: skip
    return head + body


def write_run(run: Path, frames: list[bytes]) -> Path:
    """A folder with nothing but frames and walls."""
    folder = run / "postProcessing/frames"
    folder.mkdir(parents=True)
    head = json.dumps(HEAD).encode()
    (folder / "frames.bin").write_bytes(
        b"ELUFRAM1" + struct.pack("<I", len(head)) + head + b"".join(frames)
    )
    (folder / "boundary.obj").write_text("# Faces\n" + "\n".join(CUBE) + "\n")
    return run


def falling(count: int = 40, parcels: int = 200) -> list[bytes]:
    """Frames 0.05 s apart in which parcels fall or rise by size, and leave for the two products."""
    frames, gone = [], set()
    for k in range(count):
        time, inside, left = 0.05 * k, [], []
        for number in range(parcels):
            size = 0.0003 + 0.0014 * (number * 37 % parcels) / parcels
            rise = 0.9 - size / 0.001 + 0.02 * (number % 7 - 3)
            height = 0.5 + rise * time
            if number in gone:
                continue
            if 0 < height < 1:
                place = ((number % 20 + 0.5) / 20, (number // 20 + 0.5) / 10, height)
                inside.append((number, place, size, 0.5 * rise))
            else:
                gone.add(number)
                left.append((number, int(height <= 0), size))
        gas = [min(1000 * (k + 1), 60_000)] * 6 if k % 10 == 0 else []
        frames.append(frame(time, inside, left, gas))
    return frames
