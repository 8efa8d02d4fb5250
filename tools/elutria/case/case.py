"""An Elutria case on disk: what it says, a copy of it with other settings, its fingerprint.

Nothing in a case is executed here.
"""

from __future__ import annotations

import codecs
import hashlib
import math
import os
import posixpath
import re
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elutria.case.feed import ENTRIES, Feed, Material, read_feed
from elutria.errors import InputError, one_line, suggestion
from elutria.files import writing_to
from elutria.openfoam.dictionary import (
    Dictionary,
    in_words,
    read_dictionary,
    read_list,
    set_entry,
)
from elutria.openfoam.elsewhere import (
    FOLDERS,
    LARGEST_DICTIONARY,
    dictionaries,
    name_the_same,
    named_elsewhere,
    named_environment,
)
from elutria.openfoam.mesh import check_mesh
from elutria.openfoam.own_mesh import MESH, OF_THE_MESH, PLAN, is_stale, keeps_mesh
from elutria.openfoam.text import without_comments
from elutria.physics.drag import Gas
from elutria.physics.laws import Grain, drag_title

PARAMETERS = "system/simulationParameters"
VELOCITY = f"{PARAMETERS}:gasVelocity"
SEED = f"{PARAMETERS}:seed"
CLOUD = "constant/kinematicCloudProperties"
"""Of the cloud that the solver takes unless it is told another's name."""
MESH_SCRIPTS = ("Allmesh", "Allrun.pre")
"""What makes a case's mesh otherwise than blockMesh alone; the first that is there."""

# what a run leaves behind, not part of the case
_LEFT_BEHIND = ("processor*", "postProcessing", "log.*", "log", "*.foam", "*.logfile", "PyFoam*",
                "*.png", "*.svg", "*.pdf", "*.csv", "*.vtu", "*.pvd", "elutria.json",
                "finished.json", "report.html", "atlas.html", "warnings.json", "VTK",
                "progress.txt", "dynamicCode", "settledGas", "__pycache__", ".git*")  # fmt: skip


@dataclass(frozen=True)
class Setting:
    """`FILE:ENTRY=VALUE`: give an entry of a case's file another value."""

    file: str
    entry: str
    value: str

    @classmethod
    def parse(cls, text: str) -> Setting:
        """From the command line. Raises InputError when a part is missing."""
        file, colon, rest = text.partition(":")
        entry, equals, value = rest.partition("=")
        if not (colon and equals and file.strip() and entry.strip() and value.strip()):
            raise InputError(
                f"--set '{one_line(text, 60)}'; allowed: FILE:ENTRY=VALUE, such as "
                "constant/feed:materials/quartz/density=2700"
            )
        return cls(file.strip(), entry.strip(), value.strip())

    def __str__(self) -> str:
        return f"{self.file}:{self.entry}={self.value}"


class Case:
    """A case folder. Raises InputError when it is none."""

    def __init__(self, path: Path):
        self.path = path
        if not path.is_dir():
            raise InputError(f"{path}: no such folder; allowed: an OpenFOAM case")
        for needed in ("system/controlDict", PARAMETERS, "constant/feed"):
            if not (path / needed).is_file():
                raise InputError(f"{path / needed}: file not found; every Elutria case has it")
        for file in dictionaries(path):
            with file.open("rb") as opened:
                if opened.read(3) == codecs.BOM_UTF8:
                    raise InputError(
                        f"{file}: begins with a byte order mark, which OpenFOAM takes for a part "
                        "of the first word; allowed: plain text (UTF-8 without BOM)"
                    )

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.path.resolve().name

    def dictionary(self, name: str, *, with_included: bool = False) -> Dictionary:
        """A dictionary of the case, includes and macros resolved."""
        return read_dictionary(self.path / name, self.path, with_included=with_included)

    def feed(self) -> Feed:
        """constant/feed, checked, its patches too where the mesh's patches are known."""
        feed = read_feed(self.path)
        source, patches = self.patches()
        shown = self.dictionary("constant/feed").file
        named = [(f"outlets/{k}", patch) for k, names in feed.outlets.items() for patch in names]
        if feed.place_is_patch:
            named.append(("patch", feed.place))
        for entry, patch in named:
            if patches and patch not in patches:
                raise InputError(
                    f"{shown}: {entry}: no patch '{patch}' in {source}"
                    f"{suggestion(patch, patches)}; allowed: {', '.join(patches)}"
                )
        return feed

    def velocity(self) -> float:
        """Gas velocity (m/s) of system/simulationParameters: finite, above 0."""
        parameters = self.dictionary(PARAMETERS, with_included=True)
        return parameters.number("gasVelocity", above=0, at_most=1000, unit="m/s")

    def velocity_of_run(self) -> float:
        """Gas velocity (m/s) with which the solver came to the last time that it wrote, from its
        record; of a case that has not run, or has no record, that of its files."""
        parts = [part for part in (self.path, self.path / "processor0") if part.is_dir()]
        times = [time for part in parts for time in part.iterdir() if _is_time(time.name)]
        written = [time for time in times if (time / "uniform/feed").is_file()]
        if not written:
            return self.velocity()
        last = max(written, key=lambda time: float(time.name))
        parameters = read_dictionary(last / "uniform/feed", self.path)
        for part in ("files", *PARAMETERS.split("/")):
            parameters = parameters.sub(part)
        return parameters.number("gasVelocity", above=0, at_most=1000, unit="m/s")

    def gravity(self) -> float:
        """Magnitude of constant/g, m/s2."""
        entries = self.dictionary("constant/g", with_included=True)
        size = math.hypot(*entries.numbers("value", 3))
        if not 0 < size <= 1e4:
            raise entries.refuse("value", "a vector of 0 to 1e4 m/s2")
        return size

    def gas(self) -> Gas:
        """Density and viscosity of the gas, from constant/transportProperties."""
        entries = self.dictionary("constant/transportProperties", with_included=True)
        phase = next((entries.word(k) for k in ("continuousPhase", "continuousPhaseName")
                      if k in entries), "air")  # fmt: skip
        name = next((k for k in (f"rho.{phase}", "rho", "rhoInf") if k in entries), f"rho.{phase}")
        density = entries.number(name, at_least=1e-3, at_most=1e4, unit="kg/m3")
        model = entries.sub(phase) if "nu" not in entries and phase in entries else entries
        return Gas(density, density * model.number("nu", at_least=1e-9, at_most=1, unit="m2/s"))

    def drag_laws(self) -> list[str]:
        """The drag forces of the cloud, as its dictionary names them."""
        forces = self.cloud().sub("subModels").sub("particleForces")
        return [name for name in forces.entries if "Drag" in name]

    def theory_law(self) -> str:
        """The case's drag law, by its title: the first of which the formula is known."""
        titles = [drag_title(name) for name in self.drag_laws()]
        return next((title for title in titles if title), "Schiller-Naumann")

    def drag_sphericity(self) -> float | None:
        """Sphericity that OpenFOAM's nonSphereDrag gives all particles; None: their own."""
        forces = self.cloud().sub("subModels").sub("particleForces")
        if "nonSphereDrag" not in forces:
            return None
        return forces.sub("nonSphereDrag").number("phi", above=0, at_most=1)

    def grain(self, material: Material) -> Grain:
        """A material's grains as the case's drag takes them."""
        shape = self.drag_sphericity()
        return material.grain if shape is None else Grain(material.grain.density, shape)

    def cloud(self) -> Dictionary:
        """The properties of the cloud that a run has, whatever others are there."""
        return self.dictionary(CLOUD, with_included=True)

    def patches(self) -> tuple[str, dict[str, str]]:
        """The file that names the mesh's patches, and each with its type; none when not known
        yet."""
        mesh, plan = "constant/polyMesh/boundary", "system/blockMeshDict"
        if (self.path / mesh).is_file() and (self.mesh_script or not is_stale(self.path)):
            source, entries = mesh, read_list(self.path / mesh, self.path)
        elif (
            (self.path / plan).exists() or (self.path / plan).is_symlink()
        ) and not self.mesh_script:
            source = plan
            entries = self.dictionary(plan, with_included=True).raw("boundary", [])
        else:
            return "", {}
        return source, {str(e[0]): _patch_type(e[1]) for e in entries if isinstance(e, tuple)}

    @property
    def mesh_script(self) -> str:
        """The case's own script that makes the mesh; empty without one."""
        found = [name for name in MESH_SCRIPTS if (self.path / name).is_file()]
        return found[0] if found else ""

    @property
    def keeps_mesh(self) -> bool:
        """Whether a run takes constant/polyMesh as it is. Raises InputError where it is not clear
        whether the mesh is the case's own or an old one."""
        return not self.mesh_script and keeps_mesh(self.path)

    def check_mesh(self) -> None:
        """Raise InputError unless there is a plan of the mesh, or a complete mesh."""
        if self.mesh_script:
            return
        plan, mesh = self.path / "system/blockMeshDict", self.path / "constant/polyMesh"
        if plan.is_symlink() or plan.exists():
            entries = self.dictionary("system/blockMeshDict", with_included=True)
            for name in ("vertices", "blocks"):
                if name not in entries:
                    entries.raw(name, allowed="a list ( ... )")
        elif mesh.is_dir():
            check_mesh(mesh, f"{self.name}/constant/polyMesh")
        else:
            raise InputError(
                f"{plan}: file not found; allowed: it, an Allmesh or a mesh in constant/polyMesh"
            )

    def refuse_other_files(self, files: Iterable[str], option: str = "--set") -> None:
        """Raise InputError for the first of `files` that is none within the case."""
        root = self.path.resolve()
        for file in files:
            if (plain := posixpath.normpath(file)) != file:
                raise InputError(f"{option} {file}: is another name of {plain}; allowed: that")
            target = (self.path / file).resolve()
            if not target.is_relative_to(root) or not target.is_file():
                known = [str(p.relative_to(self.path)) for p in _files(self.path)]
                raise InputError(
                    f"{option} {file}: no such file in {self.path}{suggestion(file, known)}"
                )

    def settings_for(self, velocity: float | None, extra: Iterable[str]) -> list[Setting]:
        """The settings of one run, checked to lie within the case."""
        settings = [Setting.parse(text) for text in extra]
        names = [f"{setting.file}:{setting.entry}" for setting in settings]
        if VELOCITY in names:  # of which folders, rows and figures have their names
            given = settings[names.index(VELOCITY)].value
            raise InputError(f"--set {VELOCITY}={given}: allowed: --velocity {given} instead")
        self.refuse_other_files([setting.file for setting in settings])
        for name in names:
            self.require_used(name)
        if velocity is not None:
            settings.append(Setting.parse(f"{VELOCITY}={velocity:.12g}"))
        return settings

    def require_used(self, name: str) -> None:
        """Raise InputError where FILE:ENTRY is of a file of a mesh that is not made, or of the file
        of parameters and no file of the case takes it: another value would change nothing but the
        label of a result."""
        file, _, entry = name.partition(":")
        if why := self._not_read(file):
            raise InputError(
                f"{self.name}/{file}: {entry}: {why}, so that its value changes nothing; allowed: "
                "an entry that acts, or an Allmesh that makes the mesh"
            )
        if file != PARAMETERS or name == VELOCITY or "/" in entry:
            return  # the gas velocity is compared with the solved gas
        if self._takers(entry) or entry not in self.dictionary(PARAMETERS).entries:
            return  # set_entry says what there is
        raise InputError(
            f"{self.name}/{PARAMETERS}: {entry}: no file of the case takes ${entry}, so that its "
            f"value changes nothing; allowed: an entry that acts, such as constant/feed:{entry}"
        )

    def _takers(self, entry: str) -> list[str]:
        """The files whose text takes an entry of the file of parameters."""
        by_name = re.compile(rf"\$\{{?[:.]*{re.escape(entry)}(?!\w)|\"{re.escape(entry)}\"")
        as_word, files = re.compile(rf"(?<!\w){re.escape(entry)}(?!\w)"), Path(PARAMETERS).name
        found, perhaps = [], []
        for within, path in _inputs(self.path):
            if path.stat().st_size > LARGEST_DICTIONARY or self._not_read(within):
                continue
            text, program = path.read_text("latin-1"), _is_program(path.name)
            if (program and as_word.search(text)) or by_name.search(without_comments(text)):
                found.append(within)
            elif program and files in text:
                perhaps.append(within)
        # a program may put the name together; what feeds is constant/feed's alone
        return found if found or entry in ENTRIES else perhaps

    def _not_read(self, file: str) -> str:
        """Why no program of a run reads a file of the mesh; empty where one may."""
        if self.mesh_script or not OF_THE_MESH.fullmatch(file) or _is_program(file):
            return ""
        if self.keeps_mesh:
            return f"{MESH} is kept as it is"
        plan = self.path / PLAN
        if file == PLAN or (plan.is_file() and Path(file).name in plan.read_text("latin-1")):
            return ""
        return f"the mesh is made from {PLAN} alone"

    def copy_to(self, folder: Path, settings: Iterable[Setting]) -> Case:
        """Copy the case to a new `folder` with `settings` applied; results are left behind."""
        keep_zero = not (self.path / "0.orig").is_dir()
        named = set(named_elsewhere(self.path))

        def skip(where: str, names: list[str]) -> set[str]:
            skipped = set(shutil.ignore_patterns(*_LEFT_BEHIND)(where, names))
            if Path(where) != self.path:  # tables of a result lie at the top, others are input
                skipped -= {name for name in names if name.endswith(".csv")}
            else:
                skipped -= named
                skipped |= {n for n in names if _is_time(n) and not (keep_zero and n == "0")}
            return skipped

        with writing_to(folder):
            folder.parent.mkdir(parents=True, exist_ok=True)
            try:
                shutil.copytree(self.path, folder, ignore=skip)
                if not keep_zero:
                    shutil.copytree(folder / "0.orig", folder / "0")
            except shutil.Error as error:
                raise InputError(
                    f"{self.path}: cannot be copied: {one_line(error.args[0][0][2])}"
                ) from error
        copy = Case(folder)
        with writing_to(folder):
            name_the_same(self.path, folder)
        copy._apply(settings)
        return copy

    def _apply(self, settings: Iterable[Setting]) -> None:
        """Give entries their values; those of 0.orig in 0 too, which a run starts from."""
        for setting in settings:
            for file in _with_start(setting.file):
                if (self.path / file).is_file():
                    set_entry(self.path / file, setting.entry, setting.value, self.path)

    def check_settings(self, *runs: Iterable[Setting]) -> None:
        """Raise InputError when the case, with the settings of one of `runs` applied, is not one
        that can be run, or does not have them then."""
        with tempfile.TemporaryDirectory() as folder:
            copy = self.copy_to(Path(folder) / self.name, [])
            for settings in runs:
                settings = list(settings)
                before = [copy._read(setting) for setting in settings]
                files = {copy.path / file for one in settings for file in _with_start(one.file)}
                kept = {file: file.read_bytes() for file in files if file.is_file()}
                for setting in settings:
                    copy._require_taken(setting, settings)
                copy._apply(settings)
                copy.check_mesh()
                copy.velocity()
                copy.feed()
                for setting, was in zip(settings, before, strict=True):
                    copy._require_acts(setting, was)
                for file, content in kept.items():  # as it was, for the next
                    file.write_bytes(content)

    def _read(self, setting: Setting) -> str | None:
        """What is read for the entry of a setting; None where that cannot be told, or where the gas
        tells."""
        if f"{setting.file}:{setting.entry}" == VELOCITY:
            return None
        try:
            return self.value(setting.file, setting.entry)
        except InputError:
            return None

    def _require_taken(self, setting: Setting, settings: Iterable[Setting]) -> None:
        """Raise InputError where a parameter's value, beside the other `settings` of a run, leaves
        all dictionaries as they are read without it: what takes it stands in a branch of `#ifeq`
        or `#if` that is not read."""
        name = f"{setting.file}:{setting.entry}"
        takers = self._takers(setting.entry) if setting.file == PARAMETERS else []
        known = takers and all(map(_IN_ANSWER.fullmatch, takers)) and PARAMETERS not in takers
        if name == VELOCITY or not known:
            return
        others = [other for other in settings if other is not setting]
        files = [self.path / file for one in settings for file in _with_start(one.file)]
        kept = {file: file.read_bytes() for file in files if file.is_file()}
        self._apply(others)
        was, before = self._read(setting), self._resolved(takers)
        self._apply([setting])
        now, after = self._read(setting), self._resolved(takers)
        for file, content in kept.items():
            file.write_bytes(content)
        if before is not None and before == after and was != now:
            raise InputError(
                f"{self.name}/{PARAMETERS}: {setting.entry}: {', '.join(takers)} takes it where it "
                "is not read as the case is set, so that its value changes nothing; allowed: an "
                "entry that acts"
            )

    def _resolved(self, files: Iterable[str]) -> list[dict[str, Any]] | None:
        """What is read in dictionaries, but for the parameters themselves; None where one is
        refused."""
        try:
            parameters = self.dictionary(PARAMETERS).own
            read = [self.dictionary(file, with_included=True) for file in files]
        except InputError:
            return None
        return [
            {name: value for name, value in one.entries.items()
             if name in one.own or name not in parameters}
            for one in read
        ]  # fmt: skip

    def _require_acts(self, setting: Setting, before: str | None) -> None:
        """Raise InputError where an entry is read as `before` though it was given another value:
        what comes after it in the file, such as an include, has the last word."""
        read = self._read(setting)
        if read is None or read != before:
            return
        asked, found = _tokens(setting.value), _tokens(read)
        if asked[-len(found) :] != found:
            raise InputError(
                f"{self.name}/{setting.file}: {setting.entry}: stays {one_line(read, 40)} with "
                f"--set {setting}, since what stands or is included behind it has the last word; "
                "allowed: the entry that acts"
            )

    def file_hashes(self) -> dict[str, str]:
        """SHA-256 of each of the case's inputs: a file by its path within the case, a variable of
        the environment as `$NAME`."""
        return {name: hashlib.sha256(content).hexdigest() for name, content in self._contents()}

    def _contents(self) -> Iterator[tuple[str, bytes]]:
        for name, path in _inputs(self.path):
            yield name, path.read_bytes()
        for name, value in named_environment(self.path).items():
            yield f"${name}", os.fsencode(value)

    def value(self, file: str, entry: str) -> str:
        """What an entry (`a/b/c` for nested ones) has for a value, on one line.

        Raises InputError where there is none.
        """
        *outer, name = entry.split("/")
        entries = self.dictionary(file, with_included=True)
        for part in outer:
            entries = entries.sub(part)
        found = entries.raw(name)
        if isinstance(found, Mapping):
            raise InputError(f"{entries.where(name)}: is a dictionary; allowed: one value")
        return in_words(getattr(found, "value", found))

    def fingerprint(self, settings: Iterable[Setting], np: int = 1) -> str:
        """Hash of all that decides a run: the case's inputs, the settings, the processors."""
        digest = hashlib.sha256()
        for name, content in self._contents():
            digest.update(name.encode() + b"\0")
            digest.update(content + b"\0")
        settings = list(settings)
        # runs of an elutria that did not set these in 0 are others
        started = [one.file for one in settings if len(_with_start(one.file)) > 1]
        digest.update(repr([*settings, *started, np]).encode())
        return digest.hexdigest()


def _patch_type(patch: object) -> str:
    """What a mesh's file says of a patch; empty where it says nothing."""
    return str(patch.get("type", "")) if isinstance(patch, Mapping) else ""


def _is_program(file: str) -> bool:
    return file in MESH_SCRIPTS or Path(file).suffix in (".py", ".sh")


def _with_start(file: str) -> list[str]:
    """A file of a case, and with a field of 0.orig the one in 0 that is made of it."""
    folder, _, name = file.partition("/")
    return [file, f"0/{name}"] if folder == "0.orig" else [file]


def _tokens(value: str) -> list[float | str]:
    """The numbers and words of a value, without its dimensions: alike where it says the same."""
    words = re.sub(r"\[[^\]]*\]|[()\"]|\buniform\b", " ", value).split()
    return [_number_or_word(_SWITCHES.get(word, word)) for word in words]


_IN_ANSWER = re.compile(r"(constant|system)/[^/]+")
"""Dictionaries that the solver is asked for."""

_SWITCHES = {"on": "yes", "true": "yes", "off": "no", "false": "no"}


def _number_or_word(word: str) -> float | str:
    try:
        return float(f"{float(word):.11g}")
    except ValueError:
        return word


def _is_time(name: str) -> bool:
    try:
        return math.isfinite(float(name))
    except ValueError:
        return False


def _inputs(case: Path) -> Iterator[tuple[str, Path]]:
    """The files that decide a run, and their names: the case's own, and those elsewhere that its
    dictionaries name."""
    for path in _files(case):
        yield path.relative_to(case).as_posix(), path
    yield from named_elsewhere(case).items()


def _files(case: Path) -> Iterator[Path]:
    """The input files of a case, in a fixed order; the mesh only when nothing makes it, and all
    that lies in the case where a script of its own does, which may read any."""
    folders = ["0.orig" if (case / "0.orig").is_dir() else "0", "constant", "system"]
    scripts = [case / name for name in MESH_SCRIPTS if (case / name).is_file()]
    kept = not scripts and keeps_mesh(case)
    paths: list[Any] = [*scripts]
    for folder in folders:
        paths += sorted((case / folder).rglob("*"))
    if scripts:
        paths += _for_scripts(case)
    for path in paths:
        if path.is_file() and (kept or "polyMesh" not in path.relative_to(case).parts):
            yield path


def _for_scripts(case: Path) -> Iterator[Path]:
    """Files of a case beside its dictionaries, its programs to run it and what a run left."""
    others = shutil.ignore_patterns(
        *_LEFT_BEHIND,
        "All*",
        "*.md",
        *FOLDERS,
        *(p.name for p in case.iterdir() if _is_time(p.name)),
    )
    names = [path.name for path in case.iterdir()]
    for name in sorted({*names} - others(str(case), names)):
        yield from [case / name] if (case / name).is_file() else sorted((case / name).rglob("*"))
