"""The tool reads what the solver reads: included entries, defaults, #eval, #ifeq, other clouds, old
meshes."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from elutria.case.case import PARAMETERS, Case, Setting
from elutria.cli import main
from elutria.errors import InputError
from elutria.openfoam.asked import ask
from elutria.openfoam.dictionary import set_entry
from elutria.running.run import ask_plan, plans, run_case
from elutria_validation.harness.programs import project_root

FEED, BLOCKS = "constant/feed", "system/blockMeshDict"


def edit(case: Path, file: str, old: str, new: str) -> None:
    text, count = re.subn(old, new, (case / file).read_text())
    assert count, f"{old} is not in {file}"
    (case / file).write_text(text)


def brief(case: Path) -> None:
    for entry, value in {"particles": "5", "feedTime": "0.01", "drainTime": "0.001"}.items():
        set_entry(case / PARAMETERS, entry, value, case)


def test_a_mass_flow_rate_of_an_included_file(column: Path) -> None:
    edit(column, PARAMETERS, r"(?m)^loading .*$", "massFlowRate 3e-4;")
    edit(column, FEED, r"loading\s+\$loading;", "")
    assert Case(column).feed().mass_flow_rate == 3e-4
    assert ask_plan(Case(column))["feed"]["rate_kg_s"] == 3e-4


def test_a_mass_flow_rate_beside_an_included_variable_loading(column: Path) -> None:
    edit(column, FEED, r"loading\s+\$loading;", "massFlowRate 2e-4;")
    assert Case(column).feed().loading is None
    assert ask_plan(Case(column))["feed"]["rate_kg_s"] == 2e-4


def test_a_mass_fraction_left_out(column: Path) -> None:
    edit(column, FEED, r"massFraction\s+1;", "")
    (material,) = Case(column).feed().materials
    assert material.mass_fraction == 1
    assert ask_plan(Case(column))["feed"]["materials"][0]["mass_fraction"] == 1


def test_eval_and_ifeq_in_feed_and_parameters(column: Path) -> None:
    edit(column, PARAMETERS, r"(?m)^gasVelocity.*$",
         "fast yes;\n#ifeq $fast yes\ngasVelocity 6;\n#else\ngasVelocity 3;\n#endif")  # fmt: skip
    edit(column, FEED, r"velocity\s+\(0.5 0 0\);", "velocity (#eval{ 0.25 * 2 } 0 0);")
    edit(column, FEED, r"d63\s+900e-6;", "d63 #eval{ 0.3*3e-3 };")
    case = Case(column)
    assert case.velocity() == 6
    assert case.feed().velocity == (0.5, 0, 0)
    assert case.value(FEED, "materials/quartz/sizeDistribution/d63") == "0.0009"
    plan = ask_plan(case)
    assert plan["gas"]["speed_m_s"] == pytest.approx(6)


def test_eval_in_the_plan_of_the_mesh(column: Path) -> None:
    edit(column, BLOCKS, r"scale\s+0.001;", "scale 0.001;\nH 500;\nhalf #eval{ 0.49*$H };")
    edit(column, BLOCKS, r"\((\d+ +\d+) +245\)", r"(\1 $half)")
    (name, patches) = Case(column).patches()
    assert name == BLOCKS
    assert set(patches) == {"bottom", "top", "feedSlot", "walls"}
    assert ask_plan(Case(column))["mesh"]["cells"] == 10_000


def test_what_would_be_executed_is_not(column: Path) -> None:
    """The value of #calc and #codeStream is refused where it is asked for, and nowhere else."""
    made = column / "executed"
    edit(column, PARAMETERS, r"(?m)^seed .*$",
         f'seed #calc "system(\\"touch {made}\\")";')  # fmt: skip
    case = Case(column)
    assert case.velocity() > 0
    with pytest.raises(InputError, match="#calc is not evaluated"):
        case.value(PARAMETERS, "seed")
    assert not made.exists()


def test_another_cloud_beside_the_runs(column: Path) -> None:
    """coarseCloudProperties comes first by name, but no run reads it."""
    shutil.copy(
        column / "constant/kinematicCloudProperties", column / "constant/coarseCloudProperties"
    )
    edit(column, "constant/coarseCloudProperties", "SchillerNaumannDrag;", "sphereDrag;")
    assert Case(column).drag_laws() == ["SchillerNaumannDrag"]
    plan = ask_plan(Case(column))
    assert plan["drag"]["forces"][0] == "SchillerNaumannDrag"
    assert ["not used", "constant/coarseCloudProperties"] in [r[:2] for r in plan["decisions"]]


def mesh(case: Path) -> None:
    subprocess.run(["blockMesh"], cwd=case, check=True, capture_output=True)


def test_an_old_mesh_is_made_again(column: Path) -> None:
    """Its blockMeshDict has been edited since: another name of a patch."""
    mesh(column)
    edit(column, BLOCKS, r"bottom\b", "airInlet")
    edit(column, FEED, r"coarse(\s+)\(bottom\)", r"coarse\1(airInlet)")
    for field in (column / "0.orig").iterdir():
        field.write_text(re.sub(r"\bbottom\b", "airInlet", field.read_text()))
    later = (column / BLOCKS).stat().st_mtime + 5
    os.utime(column / BLOCKS, (later, later))
    assert "airInlet" in Case(column).patches()[1]
    patches = [patch["name"] for patch in ask_plan(Case(column))["mesh"]["patches"]]
    assert patches == ["airInlet", "top", "feedSlot", "walls"]


def narrowed(case: Path) -> None:
    """A mesh of the case's own beside its blockMeshDict: half as high."""
    text = (case / BLOCKS).read_text()
    edit(case, BLOCKS, r"scale\s+0.001;", "scale 0.0005;")
    mesh(case)
    (case / BLOCKS).write_text(text)
    made = (case / "constant/polyMesh/faces").stat().st_mtime
    os.utime(case / BLOCKS, (made - 10, made - 10))


def test_an_own_mesh_beside_a_block_mesh_dict_is_kept(
    column: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    narrowed(column)
    case = Case(column)
    assert case.keeps_mesh
    height = 0.5 * 0.005
    assert ask_plan(case)["mesh"]["smallest_cell_m"] == pytest.approx(height)
    main(["check", str(column)])
    assert "constant/polyMesh, as it is" in " ".join(capsys.readouterr().out.split())
    brief(column)
    run_case(Case(column), tmp_path / "run", [])
    plan = json.loads((tmp_path / "run/postProcessing/plan.json").read_text())
    assert plan["mesh"]["smallest_cell_m"] == pytest.approx(height)


def test_what_block_mesh_left_is_no_mesh_of_the_cases_own(column: Path) -> None:
    before = Case(column).fingerprint([])
    mesh(column)
    assert not Case(column).keeps_mesh
    assert Case(column).fingerprint([]) == before


def test_a_mesh_that_may_be_old_is_refused(column: Path) -> None:
    """It is not what blockMesh makes, and a file that the blockMeshDict includes is newer."""
    edit(column, BLOCKS, r"scale\s+0.001;", '#include "simulationParameters"\nscale 0.001;')
    narrowed(column)
    later = (column / "constant/polyMesh/faces").stat().st_mtime + 10
    os.utime(column / PARAMETERS, (later, later))
    with pytest.raises(InputError, match="is not what system/blockMeshDict makes"):
        ask_plan(Case(column))


def test_a_mesh_of_a_time_to_come_is_refused(column: Path) -> None:
    """The clock was set back: a blockMeshDict that was changed since looks older than the mesh."""
    narrowed(column)
    later = time.time() + 3600
    for file in (column / "constant/polyMesh").iterdir():
        os.utime(file, (later, later))
    with pytest.raises(InputError, match="of a time yet to come"):
        ask_plan(Case(column))


def test_a_copy_that_has_lost_which_is_newer_is_refused(column: Path) -> None:
    """`cp -r` takes constant before system: the blockMeshDict is as if it was changed since."""
    narrowed(column)
    made = (column / "constant/polyMesh/faces").stat().st_mtime
    for file in (column / "system").iterdir():
        os.utime(file, (made, made))
    os.utime(column / BLOCKS, (made + 0.01, made + 0.01))
    with pytest.raises(InputError, match="a copy of the case has lost which of both is newer"):
        ask_plan(Case(column))
    mesh(column)  # one that blockMesh makes is no question
    os.utime(column / BLOCKS, (made + 100, made + 100))
    assert not Case(column).keeps_mesh


@pytest.mark.parametrize("kept", [True, False])
def test_settings_of_a_mesh_that_is_not_made_are_refused(column: Path, kept: bool) -> None:
    scale, cells = f"{BLOCKS}:scale", "system/topoSetDict:cells"
    (column / "system/topoSetDict").write_text("cells 1; scale $cellSize;\n")
    with (column / PARAMETERS).open("a") as file:
        file.write("cellSize 0.001;\n")
    if kept:
        narrowed(column)
    case = Case(column)
    for name in [scale] * kept + [cells, f"{PARAMETERS}:cellSize"]:
        with pytest.raises(InputError, match="changes nothing"):
            case.settings_for(None, [f"{name}=2"])
    if not kept:
        case.settings_for(None, [f"{scale}=2"])
    (column / "Allmesh").write_text("blockMesh && topoSet\n")
    case.settings_for(None, [f"{name}=2" for name in (scale, cells, f"{PARAMETERS}:cellSize")])


def test_a_setting_of_0_orig_acts_on_0(column: Path, tmp_path: Path) -> None:
    name = "0.orig/k.air:boundaryField/bottom/intensity"
    case = Case(column)
    settings = case.settings_for(None, [f"{name}=0.5"])
    case.check_settings(settings)
    copy = case.copy_to(tmp_path / "copy", settings)
    assert [copy.value(f"{zero}/k.air", name.partition(":")[2]) for zero in ("0", "0.orig")] == [
        "0.5", "0.5",
    ]  # fmt: skip
    assert case.value("0.orig/k.air", name.partition(":")[2]) == "0.05"


def test_a_setting_of_a_file_that_is_not_used_is_refused(column: Path) -> None:
    """A field that the turbulence model does not read: another value of it is no other run."""
    shutil.copy(column / "0.orig/epsilon.air", column / "0.orig/omega.air")
    edit(column, "0.orig/omega.air", r"epsilon\.air", "omega.air")
    edit(column, "0.orig/omega.air", r"2 -3 ", "0 -1 ")
    case = Case(column)
    settings = case.settings_for(None, ["0.orig/omega.air:internalField=uniform 9"])
    with pytest.raises(InputError, match=r"0\.orig/omega\.air: internalField: is not used \("):
        plans(case, [settings])


@pytest.mark.parametrize(
    "file, entry, value, last",
    [
        (FEED, "seed", "2", "seed 9;"),
        (FEED, "velocity", "(1 0 0)", "velocity (0 0 1);"),
        (PARAMETERS, "loading", "0.5", "loading 0.3;"),
        ("0.orig/p", "internalField", "uniform 1", "internalField uniform 2;"),
    ],
)
def test_a_setting_that_what_is_behind_it_replaces_is_refused(
    column: Path, file: str, entry: str, value: str, last: str
) -> None:
    """Two values of it would give one result under two labels."""
    (column / "system/ours").write_text(f"{last}\n")
    with (column / file).open("a") as opened:
        opened.write('#include "../system/ours"\n')
    case = Case(column)
    with pytest.raises(InputError, match=rf"{file}: {entry}: stays .*has the last word"):
        case.check_settings(case.settings_for(None, [f"{file}:{entry}={value}"]))
    there = last.removeprefix(entry).strip(" ;")
    case.check_settings(case.settings_for(None, [f"{file}:{entry}={there}"]))


def test_variables_of_the_environment_are_inputs(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those that a dictionary takes, and the files that it names by them."""
    edit(column, FEED, r"density .*;", "density $GRAIN;")
    edit(column, PARAMETERS, r"seed ", '#include "$PLANT/ours"\nseed ')
    (tmp_path / "ours").write_text("other 1;\n")
    hashes = []
    for grain, text in (("2650", "1"), ("3000", "1"), ("3000", "2")):
        monkeypatch.setenv("GRAIN", grain)
        monkeypatch.setenv("PLANT", str(tmp_path))
        (tmp_path / "ours").write_text(f"other {text};\n")
        hashes.append(Case(column).fingerprint([]))
    assert len(set(hashes)) == 3
    monkeypatch.setenv("UNRELATED", "1")
    assert Case(column).fingerprint([]) == hashes[-1]
    assert {"$GRAIN", "$PLANT"} < set(Case(column).file_hashes())


def test_the_solver_prints_what_it_reads(column: Path) -> None:
    (column / "constant/values").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object values; }\n"
        '#includeIfPresent "nothing"\nn 3; half 0.5; word a; text "b c"; list (1 (2 3) d);\n'
        "nu nu [0 2 -1 0 0 0 0] 1.5e-05; deep { again $n; switch on; again 5; }\n"
        "#ifeq $word a\nbranch 1;\n#else\nbranch 2;\n#endif\n"
        "boundary ( top { type patch; faces ((0 1)); } ); big 123456789.125; n 4;\n"
    )
    read = ask(column, "constant/values")
    assert read is not None
    assert read.entries == {
        "n": 4, "half": 0.5, "word": "a", "text": '"b c"', "list": [1, [2, 3], "d"],
        "nu": 1.5e-5, "deep": {"again": 5, "switch": True}, "branch": 1,
        "boundary": [("top", {"type": "patch", "faces": [[0, 1]]})], "big": 123456789.125,
    }  # fmt: skip
    assert read.repeated == ["deep/again", "n"]
    assert read.included == ["nothing"]
    (column / "constant/values").write_text("n $nowhere;\n")
    with pytest.raises(InputError, match=r"constant/values.*nowhere"):
        ask(column, "constant/values")


def test_the_solver_is_asked_once_about_runs_and_copies_of_the_same_contents(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a sweep checks before it begins is what its runs read, and what a second call reads."""
    solver, place = shutil.which("elutriaFoam"), tmp_path / "counted/bin"
    place.mkdir(parents=True)
    counted = place / "elutriaFoam"
    counted.write_text(f'#!/bin/sh\necho "$@" >> "{tmp_path}/starts"\nexec "{solver}" "$@"\n')
    counted.chmod(0o755)
    monkeypatch.setenv("PATH", str(place), prepend=":")
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    case = Case(column)
    wanted = [case.settings_for(velocity, []) for velocity in (4.0, 6.0)]
    case.check_settings(*wanted)
    runs = [case.copy_to(tmp_path / f"run{k}", chosen) for k, chosen in enumerate(wanted)]
    assert [run.velocity() for run in runs] == [4.0, 6.0]
    assert [run.theory_law() for run in runs] == 2 * ["Schiller-Naumann"]
    case.check_settings(*wanted)
    assert (tmp_path / "starts").read_text().split() == 2 * ["-dictionaries"]


@pytest.mark.parametrize(("model", "acts"), [("resolved", False), ("porous", True)])
def test_a_parameter_of_a_branch_that_is_not_read_is_refused(model: str, acts: bool) -> None:
    """Two values of it gave one result under two labels."""
    case = Case(project_root() / "cases/grating")
    settings = [Setting.parse(f"{PARAMETERS}:{entry}") for entry in
                (f"gratingModel={model}", "gratingLoss=5")]  # fmt: skip
    if acts:
        case.check_settings(settings)
        return
    with pytest.raises(
        InputError, match="gratingLoss: constant/fvOptions takes it where it is not"
    ):
        case.check_settings(settings)
