"""The words that stock's cloud dictionaries allow, each with what a tiny case needs to have it, and
what comes of it in stock's solver and in elutriaFoam."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from elutria_validation.harness.box import BoxCase, Contacts, cube
from elutria_validation.harness.cases import CLOUD, CONTROL, MODELS, Settings, change, times
from elutria_validation.harness.particles import (
    HEADER,
    Particles,
    read_particles,
    write_particles,
)

SIDE, STEP, END = 0.1, 1e-3, 0.02  # m, s, s
FIXED = {"type": "fixedValue", "fixedValueDistribution": {"value": 1e-3}}  # m


@dataclass(frozen=True, eq=False)
class Word:
    """A word of stock's dictionaries: where it stands, and what else the case needs for it."""

    kind: str
    name: str
    settings: Settings
    files: Mapping[str, str] = field(default_factory=dict)
    gas_velocity: float = 1.0  # m/s


def _injection(name: str, *, files: Mapping[str, str] | None = None, **entries: Any) -> Word:
    settings: dict[str, Any] = {
        "type": name, "massTotal": 1e-4, "SOI": 0, "parcelBasisType": "fixed", "nParticle": 1,
        "sizeDistribution": FIXED, **entries,
    }  # fmt: skip
    return Word("injection", name, {f"{MODELS}/injectionModels": {"one": settings}}, files or {})


ONE, UP = "constant 1", [0, 0, 0.1]
POSITIONS = (
    HEADER.format("vectorField", "constant", "places") + "((0.03 0.05 0.05)(0.07 0.05 0.05))\n"
)
TABLE = (
    HEADER.format("GlobalIOList<kinematicParcelInjectionData>", "constant", "table")
    + "( (0.05 0.05 0.05) (0 0 0.1) 1e-3 2650 1e-3 )\n"
)
TIMED: dict[str, Any] = {"duration": 1, "parcelsPerSecond": 1500, "flowRateProfile": ONE}

INJECTION = [
    _injection("patchInjection", patch="west", U0=UP, **TIMED),
    _injection("patchFlowRateInjection", patch="bottom", phi="phi.air", rho="rho.air",
               duration=1, concentration="constant 1", parcelConcentration=1e5),
    _injection("cellZoneInjection", cellZone="middle", numberDensity=1e5, U0=UP),
    _injection("coneInjection", positionAxis=[[[0.05, 0.05, 0.05], [0, 0, 1]]],
               parcelsPerInjector=10, duration=0.01, flowRateProfile=ONE, Umag="constant 0.1",
               thetaInner="constant 0", thetaOuter="constant 10"),
    _injection("coneNozzleInjection", injectionMethod="disc", flowType="constantVelocity",
               outerDiameter=0.02, innerDiameter=0, UMag=0.1, position=[0.05, 0.05, 0.05],
               direction=[0, 0, 1], thetaInner="constant 0", thetaOuter="constant 10", **TIMED),
    _injection("fieldActivatedInjection", factor=1, referenceField="mu.air",
               thresholdField="rho.air", positionsFile='"places"', parcelsPerInjector=3, U0=UP,
               files={"constant/places": POSITIONS}),
    _injection("manualInjection", positionsFile='"places"', U0=UP,
               files={"constant/places": POSITIONS}),
    _injection("kinematicLookupTableInjection", inputFile='"table"', duration=1,
               parcelsPerSecond=1000, randomise=False, files={"constant/table": TABLE}),
    _injection("inflationInjection", generationCellSet="set", inflationCellSet="set",
               duration=1, flowRateProfile="constant 1e-6", growthRate="constant 1e-3",
               selfSeed=True, dSeed=1e-4),
    _injection("injectedParticleInjection", cloud="eject", positionOffset=[0, 0, 0]),
    _injection("injectedParticleDistributionInjection", cloud="eject", positionOffset=[0, 0, 0],
               binWidth=1e-4, parcelsPerInjector=3, resampleSize=10,
               applyDistributionMassTotal=True),
    Word("injection", "none", {f"{MODELS}/injectionModels": {"one": {"type": "none"}}}),
]  # fmt: skip


def _sizes(name: str, **entries: Any) -> Word:
    sizes = {"type": name, f"{name}Distribution": entries}
    at = _injection("patchInjection", patch="west", U0=UP, **TIMED).settings
    (key,) = at
    changed = {**at[key]["one"], "sizeDistribution": sizes}
    return Word("size distribution", name, {key: {"one": changed}})


BETWEEN = {"minValue": 5e-4, "maxValue": 1.5e-3}
SIZES = [
    _sizes("fixedValue", value=1e-3),
    _sizes("uniform", **BETWEEN),
    _sizes("normal", **BETWEEN, expectation=1e-3, variance=1e-4),
    _sizes("multiNormal", **BETWEEN, expectation=[8e-4, 1.2e-3], variance=[1e-4, 1e-4],
           strength=[1, 1]),
    _sizes("exponential", **BETWEEN, **{"lambda": 1e3}),
    _sizes("RosinRammler", **BETWEEN, d=1e-3, n=3),
    _sizes("massRosinRammler", **BETWEEN, d=1e-3, n=3),
    _sizes("general", distribution=[[5e-4, 1], [1e-3, 2], [1.5e-3, 1]]),
    _sizes("binned", distribution=[[5e-4, 0.3], [1e-3, 1]]),
]  # fmt: skip

VOID = {"alphac": "alpha.air"}


def _force(name: str, **entries: Any) -> Word:
    drag = {} if "Drag" in name else {"sphereDrag": {}}
    files = {}
    if name == "SRF":
        files["constant/SRFProperties"] = HEADER.format(
            "dictionary", "constant", "SRFProperties"
        ) + ("SRFModel rpm; origin (0 0 0); axis (0 0 1); rpmCoeffs { rpm 10; }\n")
    settings: dict[str, Any] = {f"{MODELS}/particleForces": {**drag, name: entries}}
    for needed in ("DUcDt", "curlUcDt"):
        settings[f"{CLOUD}:solution/interpolationSchemes/{needed}"] = "cell"
    return Word("force", name, settings, files)


FORCES = [
    _force("sphereDrag"),
    _force("nonSphereDrag", phi=0.8),
    _force("distortedSphereDrag"),
    _force("WenYuDrag", **VOID),
    _force("ErgunWenYuDrag", **VOID),
    _force("PlessisMasliyahDrag", **VOID),
    _force("gravity"),
    _force("pressureGradient", U="U.air"),
    _force("virtualMass", Cvm=0.5, U="U.air"),
    _force("SaffmanMeiLiftForce", U="U.air"),
    _force("TomiyamaLift", U="U.air", sigma=0.07),
    _force("nonInertialFrame"),
    _force("SRF"),
    _force("paramagnetic", HdotGradH="U.air", magneticSusceptibility=1e-3),
    _force("interface", alpha="alpha.air", C=1e-3),
    _force("BrownianMotion", **{"lambda": 1e-7, "turbulence": False}),
]

DISPERSION = [
    Word("dispersion", name, {f"{MODELS}/dispersionModel": name})
    for name in ("none", "gradientDispersionRAS", "stochasticDispersionRAS")
]


def _interaction(name: str, kind: str = "", **entries: Any) -> Word:
    settings: dict[str, Any] = {f"{MODELS}/patchInteractionModel": name}
    if entries:
        settings[f"{MODELS}/{name}Coeffs"] = entries
    # downwards onto the walls
    return Word("patch interaction", f"{name}: {kind}" if kind else name, settings, gas_velocity=0)


INTERACTIONS = [
    _interaction("none"),
    _interaction("rebound", UFactor=0.5),
    *(_interaction("standardWallInteraction", kind, type=kind, e=0.5, mu=0)
      for kind in ("rebound", "stick", "escape")),
    *(_interaction("localInteraction", kind,
                   patches=[('".*"', {"type": kind, "e": 0.5, "mu": 0})])
      for kind in ("rebound", "stick", "escape")),
    _interaction("multiInteraction", oneInteractionOnly=True,
                 model1={"patchInteractionModel": "standardWallInteraction",
                         "standardWallInteractionCoeffs": {"type": "stick"}}),
]  # fmt: skip


def _function(name: str, **entries: Any) -> Word:
    settings = {f"{CLOUD}:cloudFunctions": {"one": {"type": name, **entries}}}
    return Word("cloud function", name, settings, gas_velocity=0)


RESET: dict[str, Any] = {"resetOnWrite": False, "log": False}
SQUARE = [[0.0, 0.0, 0.04], [0.1, 0.0, 0.04], [0.1, 0.1, 0.04], [0.0, 0.1, 0.04]]
FUNCTIONS = [
    _function("facePostProcessing", surfaceFormat="none", faceZones=[], **RESET),
    _function("particleCollector", mode="polygon", polygons=[SQUARE], normal=[0, 0, 1],
              surfaceFormat="none", removeCollected=False, negateParcelsOppositeNormal=False,
              **RESET),
    _function("particleErosion", p=1e9, psi=2, K=2, patches=["west"]),
    _function("particleTracks", trackInterval=1, maxSamples=100, resetOnWrite=False),
    _function("particleTrap", alpha="alpha.air", threshold=0.5),
    _function("patchCollisionDensity", minSpeed=0),
    _function("patchPostProcessing", maxStoredParcels=100, patches=["west"]),
    _function("voidFraction"),
]  # fmt: skip

COLLISIONS = [
    Word("collision", "none", {f"{MODELS}/collisionModel": "none"}),
    *(Word("collision", f"pairCollision: {wall}", {
        f"{MODELS}/collisionModel": "pairCollision",
        f"{MODELS}/pairCollisionCoeffs": {
            "maxInteractionDistance": 2e-3, "writeReferredParticleCloud": False,
            "pairModel": "pairSpringSliderDashpot",
            "pairSpringSliderDashpotCoeffs": {
                "useEquivalentSize": False, "alpha": 0.1, "b": 1.5, "mu": 0.1,
                "cohesionEnergyDensity": 0, "collisionResolutionSteps": 12},
            "wallModel": wall, f"{wall}Coeffs": coeffs,
            "U": "U.air"}})
      for wall, coeffs in {
          "wallSpringSliderDashpot": {
              "useEquivalentSize": False, "youngsModulus": 1e7, "poissonsRatio": 0.25,
              "alpha": 0.1, "b": 1.5, "mu": 0.1, "cohesionEnergyDensity": 0,
              "collisionResolutionSteps": 12},
          "wallLocalSpringSliderDashpot": {
              "useEquivalentSize": False, "collisionResolutionSteps": 12,
              '"wall|inflow|outflow|.*"': {
                  "youngsModulus": 1e7, "poissonsRatio": 0.25, "alpha": 0.1, "b": 1.5, "mu": 0.1,
                  "cohesionEnergyDensity": 0}},
      }.items()),
]  # fmt: skip

WORDS = [*INJECTION, *SIZES, *FORCES, *DISPERSION, *INTERACTIONS, *FUNCTIONS, *COLLISIONS]


def as_text(value: Any) -> str:
    """A value as a dictionary has it, with what ends it."""
    inner = _inside(value)
    return inner if isinstance(value, Mapping) else f"{inner};"


def _inside(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + " ".join(f"{name} {as_text(item)}" for name, item in value.items()) + " }"
    if isinstance(value, tuple):  # a name and its dictionary
        return " ".join(map(_inside, value))
    if isinstance(value, list):
        return f"({' '.join(map(_inside, value))})"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)


def make(word: Word, folder: Path, *, contacts: bool) -> Path:
    """A box of 5 x 5 x 5 cells with a lattice of particles near the west wall, thrown at it."""
    case = BoxCase(
        gas_velocity=word.gas_velocity, step=STEP, end=END,
        forces={} if word.kind == "force" else {"sphereDrag": {}},
        contacts=Contacts() if contacts else None, **cube(SIDE, 5),
    ).make(folder)  # fmt: skip
    places = np.array([[2e-3, y, z] for y in (0.03, 0.05, 0.07) for z in (0.03, 0.05, 0.07)])
    velocity = np.tile([-1.0, 0, -0.5], (len(places), 1))
    if not word.kind.startswith(("injection", "size")):
        write_particles(case, Particles.of(places, velocity=velocity, diameter=1e-3, density=2650))
    for name, text in word.files.items():
        (case / name).write_text(text)
    if "cellZoneInjection" in word.name or "inflation" in word.name:
        from elutria_validation.harness.cases import add_zone

        add_zone(case, "middle", (0.02, 0.02, 0.02), (0.08, 0.08, 0.08))
    with (case / CLOUD).open("a") as file:  # OpenFOAM merges dictionaries that are there twice
        for entry, value in word.settings.items():
            *above, last = entry.partition(":")[2].split("/")
            file.write(" { ".join([*above, f"{last} {as_text(value)}"]) + " }" * len(above) + "\n")
    change(case, {f"{CONTROL}:libs": ["libelutriaCollision.so"]})
    return case


@dataclass(frozen=True)
class Result:
    """How a solver ended: its exit code and last line; the parcels at the end and the names of the
    files that the cloud has written."""

    code: int
    said: str
    parcels: Particles
    files: frozenset[str]


def run(case: Path, solver: str) -> Result:
    """Run a solver on a case that has not run."""
    try:
        done = subprocess.run(
            [solver], cwd=case, capture_output=True, text=True, errors="replace", check=False,
            timeout=LONGEST,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return Result(ENDLESS, "took too long", read_particles(case, "none"), frozenset())
    text = done.stdout + done.stderr
    failed = re.findall(r"elutria: failed: (.*)", text)
    fatal = re.findall(r"FOAM FATAL[^\n]*\n+((?:.+\n)+)", text)
    said = failed[-1] if failed else " ".join(fatal[0].split()) if fatal else text[-200:]
    written = {path.name for path in case.rglob("*") if "kinematicCloud" in path.parts[:-1]}
    functions = {path.name for path in (case / times(case)[-1]).glob("kinematicCloud*")}
    last = times(case)[-1] if done.returncode == 0 else "none"
    return Result(done.returncode, said, read_particles(case, last), frozenset(written | functions))


@dataclass(frozen=True)
class Outcome:
    """What comes of a word: in stock's solver, in ours without contacts, and with them."""

    stock: Result
    ours: Result
    contacts: Result | None  # None: the word is a collision model itself
    word: Word

    def _names(self, result: Result) -> bool:
        """Is it refused by a line that names it?"""
        name = self.word.name.rpartition(" ")[2]
        return result.code == 2 and name.lower() in result.said.lower()

    @property
    def as_stock(self) -> bool:
        """The same files, and the same parcels near the same places; where they are random, about
        as many, of about the same sizes."""
        one, other = self.stock.parcels, self.ours.parcels
        if self.ours.code != 0 or self.stock.files - self.ours.files:
            return False
        if self.word.kind in RANDOM:
            return all(
                np.isclose(mine, theirs, rtol=0.35)
                for mine, theirs in zip(_summary(one), _summary(other), strict=True)
            )
        if len(one.diameter) != len(other.diameter):
            return False
        return bool(np.all(np.abs(one.position - other.position) < NEAR))

    @property
    def endless(self) -> bool:
        """Does stock's solver not end with it?"""
        return self.stock.code == ENDLESS

    @property
    def sound(self) -> bool:
        """Nothing is taken and then not done."""
        if self.endless:
            return self.ours.code == 0
        if self.stock.code != 0:
            return self.ours.code == 2
        with_contacts = self.contacts is None or self.contacts.code == 0
        good = with_contacts or (self.contacts is not None and self._names(self.contacts))
        return (self.as_stock or self._names(self.ours)) and good

    def cells(self) -> tuple[str, str]:
        """Of the page's table."""
        if self.endless:
            return "works (stock does not end)", "works"
        if self.stock.code != 0:
            return "refused, as by stock", "refused"
        ours = "as stock" if self.as_stock else "refused"
        if self.contacts is None:
            return ours, ""
        return ours, "works" if self.contacts.code == 0 else "refused"

    def __str__(self) -> str:
        parts = {"stock": self.stock, "none": self.ours, "cellList": self.contacts}
        return (
            "; ".join(
                f"{name}: {part.code}, {len(part.parcels.diameter)} parcels, {part.said[-200:]!r}"
                for name, part in parts.items()
                if part
            )
            + f"; lacks {sorted(self.stock.files - self.ours.files)}"
        )


ENDLESS = -1
LONGEST = 60
"""s that a solver may take, of about one."""
NEAR = 2e-3
"""m; of 20 mm: stock takes drag of a step's start, we the mean of both ends."""
RANDOM = ("injection", "size distribution", "dispersion")
"""Kinds of words whose parcels stock draws."""


def _summary(parcels: Particles) -> tuple[float, float]:
    """How many there are, and their mean diameter, m."""
    d = parcels.diameter
    return float(len(d)), float(d.mean()) if len(d) else 0.0


def tried(word: Word, folder: Path) -> Outcome:
    """Run the word in the three ways."""
    folder.mkdir()
    stock = run(make(word, folder / "stock", contacts=False), "DPMFoam")
    ours = run(make(word, folder / "none", contacts=False), "elutriaFoam")
    contacts = None
    if word.kind != "collision":
        contacts = run(make(word, folder / "contacts", contacts=True), "elutriaFoam")
    return Outcome(stock, ours, contacts, word)


PAGE = Path(__file__).resolve().parents[2] / "docs/user/stock-words.md"
HEAD = """# Stock's words

Each word that OpenFOAM's dictionaries allow for a colliding cloud (v1912), tried once in a box of
5 x 5 x 5 cells over 20 steps, in DPMFoam and in elutriaFoam, by
`pytest --slow tests/cases/test_stock_words.py`. `as stock`: the same files of the cloud, and the
same parcels within 2 mm of the same places; where they are drawn at random, as many within 35 %,
of a mean size within 35 %. `refused`: one line that names it, exit code 2. With
`collisionModel cellList` it is only told whether a word works, since contacts are not stock's. A
word that stock itself does not take in such a case is refused by both.

| kind | word | collisionModel none | collisionModel cellList |
| --- | --- | --- | --- |
"""


def row(word: Word) -> str:
    """The beginning of the word's row."""
    return f"{word.kind} | `{word.name}`"


def page(outcomes: Mapping[Word, Outcome]) -> str:
    """The page of the manual that tells the outcomes."""
    rows = [f"| {row(word)} | {' | '.join(it.cells())} |\n" for word, it in outcomes.items()]
    return HEAD + "".join(rows)


if __name__ == "__main__":
    import sys
    import tempfile

    with tempfile.TemporaryDirectory() as place:
        wanted = [word for word in WORDS if re.search(sys.argv[1], row(word))]
        found = {}
        for number, one in enumerate(wanted):
            found[one] = tried(one, Path(place) / str(number))
            print("" if found[one].sound else "WRONG ", row(one), found[one].cells(), flush=True)
            if not found[one].sound or len(sys.argv) > 2:
                print("     ", found[one], flush=True)
    lines = (PAGE.read_text() if PAGE.is_file() else page({})).splitlines()
    told = page(found).splitlines()[len(HEAD.splitlines()) :]
    for line in told:  # in their places, where only some words were tried
        same = [k for k, old in enumerate(lines) if old.split("|")[:3] == line.split("|")[:3]]
        if same:
            lines[same[0]] = line
        else:
            lines.append(line)
    PAGE.write_text("\n".join(lines) + "\n")
