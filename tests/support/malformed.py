"""Malformed inputs, made from a seed: each certainly wrong, each of a kind with a name.

An `Input` spoils one file of a case or of results in place. `entry` is the word that a message must
name beside the file, empty where the file as a whole is at fault.
"""

from __future__ import annotations

import os
import random
import re
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

FEED, PARAMETERS = "constant/feed", "system/simulationParameters"
GAS, GRAVITY = "constant/transportProperties", "constant/g"
CLOUD, CONTROL = "constant/kinematicCloudProperties", "system/controlDict"

# entries without which there is no case, and what they may not be
NUMBERS = {
    FEED: ["density", "massFraction", "d63", "n", "min", "max", "loading", "duration"],
    PARAMETERS: ["gasVelocity"],
    GAS: ["rho.air", "nu"],
    CONTROL: ["deltaT"],
}
BLOCKS = {FEED: ["outlets", "materials", "sizeDistribution"], CLOUD: ["subModels"]}
WORDS = {FEED: ["patch", "type", "seed", "particles", "drainTime"]}
SCALES = [  # the number in a common wrong unit
    (FEED, "d63", "900"),
    (FEED, "d63", "0.9"),
    (FEED, "min", "300"),
    (FEED, "max", "2000"),
    (FEED, "max", "2"),
    (FEED, "density", "2650000"),
    (FEED, "density", "2.65"),
    (GAS, "nu", "15"),
    (GAS, "rho.air", "1.2e6"),
    (PARAMETERS, "gasVelocity", "6000"),
    (FEED, "loading", "200000"),
]
CONTRADICTIONS = [
    (FEED, "max", "(max\\s+)[^;]+;", r"\g<1>200e-6;"),
    (FEED, "massFraction", "(massFraction\\s+)[^;]+;", r"\g<1>0.4;"),
    (FEED, "coarse", "(coarse\\s+)[^;]+;", r"\g<1>(top);"),
    (FEED, "coarse", "(coarse\\s+)[^;]+;", r"\g<1>(nowhere);"),
    (FEED, "patch", "(patch\\s+)[^;]+;", r"\g<1>nowhere;"),
    (FEED, "patch", "(patch\\s+[^;]+;)", r"\g<1> zone here;"),
    (FEED, "loading", "(loading\\s+[^;]+;)", r"\g<1> massFlowRate 1;"),
    (FEED, "type", "(type\\s+)[^;]+;", r"\g<1>fixedValue;"),
    (FEED, "all", "quartz", "all"),
    (FEED, "materials", "(materials\\s*)", r"\g<1>{} unused "),
]
EXECUTABLE = [
    '#calc "system(\\"touch executed\\")"',
    '#codeStream { code #{ system("touch executed"); #}; }',
    "#eval{ system(touch executed) }",
    "$(touch executed)",
    '"`touch executed`"',
    '"; touch executed #"',
]
SOLUTION, SCHEMES, MESH = "system/fvSolution", "system/fvSchemes", "system/blockMeshDict"
SILENT: list[tuple[str, str, str]] = [
    # OpenFOAM takes these, or goes on with another value: file, entry, and what is appended
    (CONTROL, "purgeWrite", "purgeWrite -1;"),
    (CONTROL, "stopAt", "stopAt nextWrite;"),
    (SCHEMES, "default", "ddtSchemes { default steadyState; }"),
    (SCHEMES, "default", "ddtSchemes { default backward; }"),
    (SCHEMES, "default", "ddtSchemes { default CrankNicolson 0.9; }"),
    (SCHEMES, "default", "ddtSchemes { default localEuler rDeltaT; }"),
    (CONTROL, "timePrecision", "timePrecision 0;"),
    (CONTROL, "writePrecision", "writePrecision 4000;"),
    (CONTROL, "timeFormat", "timeFormat sientific;"),
    (CONTROL, "writeCompression", "writeCompression perhaps;"),
    (CONTROL, "deltaT", "deltaT 1e300;"),
    (CONTROL, "endTime", "startFrom startTime; startTime 0.5; endTime 0.25;"),
    (CONTROL, "libs", 'libs ("libNowhere.so");'),
    (
        CONTROL,
        "type",
        'functions { mine { type fieldMinMux; libs ("libfieldFunctionObjects.so"); } }',
    ),
    (CONTROL, "libs", 'functions { mine { type fieldMinMax; libs ("libNowhere.so"); } }'),
    (
        CONTROL,
        "fields",
        'functions { mine { type fieldMinMax; libs ("libfieldFunctionObjects.so"); } }',
    ),
    (SOLUTION, "nOuterCorrectors", "PIMPLE { nOuterCorrectors 0; }"),
    (SOLUTION, "nCorrectors", "PIMPLE { nCorrectors -1; }"),
    (SOLUTION, "nNonOrthogonalCorrectors", "PIMPLE { nNonOrthogonalCorrectors -1; }"),
    (SOLUTION, "tolerance", "solvers { p { tolerance 2; } }"),
    (SOLUTION, "relTol", "solvers { p { relTol 1; } }"),
    (SOLUTION, "maxIter", "solvers { p { maxIter 0; } }"),
    (SOLUTION, "U.air", "relaxationFactors { equations { U.air -0.5; } }"),
    (CLOUD, "rho0", "constantProperties { rho0 1e300; }"),
]
SILENT_VALUES = [
    (FEED, "velocity", "(0 0 1e300)"),
    (FEED, "start", "1e300"),
    (FEED, "duration", "1e300"),
    (FEED, "density", "1e300"),
    (FEED, "drainTime", "-1"),
    (FEED, "particles", "0"),
    (FEED, "max", "1e300"),
    (GAS, "nu", "1e300"),
    (GAS, "rho.air", "1e300"),
]
SILENT_FIELDS = [  # field, entry, what stands there, what then stands there
    ("p", "dimensions", r"dimensions\s[^;]*;", "dimensions [0 2 -1 0 0 0 0];"),
    ("U.air", "dimensions", r"dimensions\s[^;]*;", "dimensions [0 2 -1 0 0 0 0];"),
    ("p", "internalField", r"internalField\s[^;]*;", "internalField uniform 1e300;"),
    ("k.air", "dimensions", r"dimensions\s[^;]*;", "dimensions [0 1 -1 0 0 0 0];"),
    ("k.air", "internalField", r"internalField\s[^;]*;", "internalField uniform -1;"),
    ("epsilon.air", "internalField", r"internalField\s[^;]*;", "internalField uniform 0;"),
    ("nut.air", "internalField", r"internalField\s[^;]*;", "internalField uniform -1;"),
]
HUGE_FILE = 6_000_000

outcomes: Counter[tuple[str, str, str]] = Counter()
"""Of this session's tests: number by kind, command, and what came of it."""


@dataclass(frozen=True)
class Input:
    """One malformed input: `spoil(folder)` makes it of what is sound."""

    kind: str
    target: str  # dictionary, feed, mesh or result
    file: str
    entry: str
    spoil: Callable[[Path], None]
    folder: str = "plain"

    def __str__(self) -> str:
        return f"{self.kind} {self.file} {self.entry}".strip()


def entry_inputs(draw: random.Random) -> Iterator[Input]:
    """Single entries of dictionaries that are not what they must be."""
    numbers = [(file, name) for file, names in NUMBERS.items() for name in names]
    for file, name in numbers:
        for value in ("nan", "-1", "1e400", draw.choice(["inf", "-inf", "1e300", "-0.5"])):
            yield _valued("out of range", file, name, value)
        for value in ("(1 2)", draw.choice(["heavy", '"5"', "5kg", "on"]), "{ a 1; }"):
            yield _valued("wrong type", file, name, value)
        yield _valued("executed", file, name, draw.choice(EXECUTABLE))
        yield _valued("undefined macro", file, name, "$nowhere")
        yield _valued("no value", file, name, "")
    for file, names in (*NUMBERS.items(), *WORDS.items(), *BLOCKS.items()):
        for name in names:
            yield _renamed("misspelt", file, name, name[:1] + name[2:] if len(name) > 2 else "nn")
    for file, name in [*((f, n) for f, n in numbers if n != "massFraction"), (FEED, "patch")]:
        if (file, name) not in ((FEED, "duration"), (FEED, "loading")):
            yield _removed(file, name)
    for file, names in BLOCKS.items():
        for name in names:
            yield _renamed("missing", file, name, "")
            yield _emptied(file, name)
    for file, name, value in SCALES:
        yield _valued("wrong unit", file, name, value)
    for file, name, old, new in CONTRADICTIONS:
        yield _replaced("inconsistent", file, name, old, new)
    yield _valued("executed", FEED, "patch", draw.choice(EXECUTABLE))


def silent_inputs(fields: str) -> Iterator[Input]:
    """What OpenFOAM takes without a word, or refuses late: of a case with turbulence whose fields
    of the start are in the folder `fields`."""

    def appended(file: str, text: str) -> Callable[[Path], None]:
        def spoil(folder: Path) -> None:
            with (folder / file).open("a") as stream:
                stream.write(f"\n{text}\n")

        return spoil

    for file, name, text in SILENT:
        yield Input("silent", _target(file), file, name, appended(file, text))
    for file, name, value in SILENT_VALUES:
        yield _valued("silent", file, name, value)
    for field, name, old, new in SILENT_FIELDS:
        yield _replaced("silent", f"{fields}/{field}", name, old, new)
    yield Input("twice", "feed", FEED, "seed", appended(FEED, "seed 1;"))
    for number, name in ((0, "scale"), (-0.001, "scale"), (-1, "convertToMeters")):
        yield Input("silent", "dictionary", MESH, name, appended(MESH, f"{name} {number};"))


def file_inputs(draw: random.Random, file: str, target: str) -> Iterator[Input]:
    """A whole file that is not there, not whole, not text or not a file."""

    def written(content: bytes) -> Callable[[Path], None]:
        return lambda folder: (folder / file).write_bytes(content)

    def linked(place: str) -> Callable[[Path], None]:
        def spoil(folder: Path) -> None:
            (folder / file).unlink()
            (folder / file).symlink_to(place.replace("FILE", str(folder / file)))

        return spoil

    def cut(folder: Path) -> None:
        text = (folder / file).read_bytes()
        # within the last third, which closes what was opened: not whole wherever it falls
        last = text.rstrip().rstrip(b"/* \n")
        (folder / file).write_bytes(last[: draw_cut(last)])

    share = draw.random()

    def draw_cut(text: bytes) -> int:
        end = text.rfind(b"}") if target in ("dictionary", "feed") else len(text) - 2
        return max(1, end - int(share * 0.2 * len(text)) - 1)

    def pipe(folder: Path) -> None:
        (folder / file).unlink()
        os.mkfifo(folder / file)

    def directory(folder: Path) -> None:
        (folder / file).unlink()
        (folder / file).mkdir()

    def absent(folder: Path) -> None:
        (folder / file).unlink()

    def padded(folder: Path) -> None:
        with (folder / file).open("ab") as stream:
            stream.write(b"a 1;\n" * (HUGE_FILE // 5) if target != "result" else b"\x00" * 100)

    rubbish = draw.randbytes(draw.randrange(50, 5000)) + b"\x00\xff"
    for kind, spoil in {
        "truncated": cut,
        "binary": written(rubbish),
        "empty": written(b""),
        "absent": absent,
        "huge": padded,
        "nested": written(b"(" * draw.randrange(20_000, 60_000)),
        "link to itself": linked("FILE"),
        "link to nothing": linked("/nowhere/at/all"),
        "link to a device": linked("/dev/zero"),
        "folder": directory,
        "pipe": pipe,
    }.items():
        yield Input(kind, target, file, "", spoil)


def table_inputs(draw: random.Random, file: str) -> Iterator[Input]:
    """Tables of results whose rows do not hold what their first line says."""

    def edited(edit: Callable[[list[str]], list[str]]) -> Callable[[Path], None]:
        def spoil(folder: Path) -> None:
            lines = (folder / file).read_text().splitlines()
            (folder / file).write_text("\n".join(edit(lines)) + "\n")

        return spoil

    place = draw.random()

    def row(lines: list[str]) -> int:
        return 1 + int(place * (len(lines) - 1))

    def cells(change: Callable[[list[str]], list[str]]) -> Callable[[list[str]], list[str]]:
        def edit(lines: list[str]) -> list[str]:
            k = row(lines)
            lines[k] = ",".join(change(lines[k].split(",")))
            return lines

        return edit

    for kind, edit in {
        "wrong columns": lambda lines: ["a,b,c", *lines[1:]],
        "row too short": cells(lambda row: row[:-2]),
        "row too long": cells(lambda row: [*row, "1", "2"]),
        "wrong type": cells(lambda row: ["word" for _ in row]),
        "no value": cells(lambda row: ["" for _ in row]),
    }.items():
        yield Input(kind, "result", file, "", edited(edit))


def _pattern(name: str) -> str:
    return rf"(?m)(^|[\s{{;]){re.escape(name)}(?=[\s{{])"


def _edit(file: str, old: str, new: str | Callable[[re.Match[str]], str]) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        path = folder / file
        text = re.sub(r"//.*", "", path.read_text())
        head, brace, body = text.partition("}")  # after FoamFile
        changed, count = re.subn(old, new, body, count=1)
        assert count == 1, f"{old} is not in {file}"
        path.write_text(head + brace + changed)

    return spoil


def _target(file: str) -> str:
    return "feed" if file == FEED else "dictionary"


def _valued(kind: str, file: str, name: str, value: str) -> Input:
    spoil = _edit(file, _pattern(name) + r"\s+[^;]+;", lambda m: f"{m[1]}{name} {value};")
    return Input(kind, _target(file), file, name, spoil)


def _renamed(kind: str, file: str, name: str, other: str) -> Input:
    spoil = _edit(file, _pattern(name), lambda m: m[1] + (other or "unknownBlock"))
    return Input(kind, _target(file), file, name, spoil)


def _removed(file: str, name: str) -> Input:
    spoil = _edit(file, _pattern(name) + r"\s+[^;]+;", lambda m: m[1])
    return Input("missing", _target(file), file, name, spoil)


def _emptied(file: str, name: str) -> Input:
    spoil = _edit(file, _pattern(name) + r"\s*\{", lambda m: f"{m[1]}{name} 5; unused {{")
    return Input("wrong type", _target(file), file, name, spoil)


def _replaced(kind: str, file: str, name: str, old: str, new: str) -> Input:
    return Input(kind, _target(file), file, name, _edit(file, old, new))


def mesh_inputs(draw: random.Random) -> Iterator[Input]:
    """Files of constant/polyMesh (ASCII) that do not fit each other or hold impossible values."""

    def replaced(name: str, old: str, new: str) -> tuple[str, Callable[[Path], None]]:
        def spoil(folder: Path) -> None:
            path = folder / "constant/polyMesh" / name
            head, brace, body = path.read_text().partition("}")
            changed, count = re.subn(old, new, body, count=1)
            assert count == 1, f"{old} is not in {name}"
            path.write_text(head + brace + changed)

        return name, spoil

    first = r"(\(\s*)[-\d]+(?=\s)"  # of a list of labels
    far = draw.choice(["999999999", "123456"])
    for kind, (name, spoil) in [
        ("out of range", replaced("owner", first, rf"\g<1>{far}")),
        ("out of range", replaced("owner", first, r"\g<1>-5")),
        ("out of range", replaced("neighbour", first, rf"\g<1>{far}")),
        ("out of range", replaced("neighbour", first, r"\g<1>-1")),
        ("out of range", replaced("faces", r"(\d+\(\d+ )\d+", rf"\g<1>{far}")),
        ("out of range", replaced("faces", r"(\d+\(\d+ )\d+", r"\g<1>-7")),
        ("out of range", replaced("points", r"(\(\s*\()[-\d.e]+", r"\g<1>nan")),
        ("out of range", replaced("points", r"(\(\s*\()[-\d.e]+", r"\g<1>1e400")),
        ("out of range", replaced("boundary", r"(nFaces\s+)\d+", rf"\g<1>{far}")),
        ("out of range", replaced("boundary", r"(startFace\s+)\d+", rf"\g<1>{far}")),
        ("out of range", replaced("boundary", r"(nFaces\s+)\d+", r"\g<1>-4")),
        ("wrong type", replaced("owner", first, r"\g<1>word")),
        ("wrong type", replaced("points", r"(\(\s*\()[-\d.e]+", r"\g<1>word")),
        ("wrong type", replaced("boundary", r"(nFaces\s+)\d+", r"\g<1>many")),
        ("misspelt", replaced("boundary", "top", "tpo")),
        ("misspelt", replaced("boundary", "nFaces", "nfaces")),
        ("missing", replaced("boundary", r"startFace\s+\d+;", "")),
        ("inconsistent", replaced("owner", r"\)\s*(//.*)?\s*$", "0\n)\n")),
        ("inconsistent", replaced("points", r"\n\d+\n", "\n7\n")),
        ("inconsistent", replaced("faces", r"\n\d+\n", "\n7\n")),
    ]:
        yield Input(kind, "mesh", f"constant/polyMesh/{name}", "", spoil)
    for name in ("boundary", "points", "faces", "owner", "neighbour"):
        yield from file_inputs(draw, f"constant/polyMesh/{name}", "mesh")
