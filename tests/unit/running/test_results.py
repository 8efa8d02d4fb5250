"""What a folder holds is what it says: runs go on, other cases are refused, no row is lost."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from elutria import tables
from elutria.case.case import Case
from elutria.classification.precision import Precision
from elutria.errors import InputError
from elutria.files import read_csv, write_json
from elutria.output.results import read_results
from elutria.pages.runs import find_runs
from elutria.running.axes import grid, read_points
from elutria.running.run import run_case
from elutria.running.sweep import plan
from tests.support.sweeps import SMALL, sweep

LOADING = "system/simulationParameters:loading"
DRAIN = "system/simulationParameters:drainTime"
SEED = "system/simulationParameters:seed"


def started(starts: Path) -> list[str]:
    return starts.read_text().splitlines() if starts.exists() else []


def velocities(to: Path) -> set[float]:
    return {row["gas_velocity_m_s"] for row in read_csv(to / "summary.csv", tables.SUMMARY)}


@pytest.mark.usefixtures("fake_solver")
def test_a_velocity_more_keeps_the_rows_of_the_others(column: Path, tmp_path: Path) -> None:
    to = tmp_path / "results"
    sweep(column, to, "4,6")
    before = (to / "summary.csv").read_text().splitlines()
    sweep(column, to, "5")
    assert velocities(to) == {4, 5, 6}
    after = (to / "summary.csv").read_text().splitlines()
    assert set(before) < set(after)
    assert [row.split(",")[0] for row in after[1:]] == ["4", "4", "5", "5", "6", "6"]


def test_another_case_is_refused_and_touches_nothing(
    column: Path, fake_solver: Path, tmp_path: Path
) -> None:
    to = tmp_path / "results"
    sweep(column, to, "5")
    other, same = tmp_path / "zigzag", tmp_path / "same"
    subprocess.run(["cp", "-r", str(column), str(same)], check=True)
    subprocess.run(["cp", "-r", str(column), str(other)], check=True)
    assert sweep(same, to, "5").skipped == 1  # the same case, elsewhere and with another name
    assert sweep(column, to, "5").skipped == 1
    before = {path: path.read_bytes() for path in to.rglob("*") if path.is_file()}
    feed = other / "constant/feed"
    feed.write_text(feed.read_text().replace("2650", "2700"))
    with pytest.raises(InputError, match="results of the case 'column', not of 'zigzag'"):
        sweep(other, to, "6")
    (column / "constant/feed").write_text(feed.read_text())
    with pytest.raises(InputError, match=r"before these changed: constant/feed; choose"):
        sweep(column, to, "6")
    with pytest.raises(InputError, match=r"particles \(400, now 200\)"):
        sweep(same, to, "5", extra=[SMALL[0].replace("400", "200")])
    assert len(started(fake_solver)) == 1
    assert {path: path.read_bytes() for path in to.rglob("*") if path.is_file()} == before


@pytest.mark.usefixtures("fake_solver")
def test_a_run_is_no_folder_for_a_sweep(column: Path, tmp_path: Path) -> None:
    case = Case(column)
    run_case(case, tmp_path / "one", case.settings_for(5, SMALL))
    with pytest.raises(InputError, match="is the folder of a run"):
        sweep(column, tmp_path / "one", "5")


def test_a_killed_run_goes_on(
    column: Path, fake_solver: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    to = tmp_path / "one"
    monkeypatch.setenv("FAKE_SLEEP", "60")
    command = [sys.executable, "-m", "elutria", "run", str(column), "--velocity", "5",
               "--set", SMALL[0], "--to", str(to)]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 200
    while not (to / "0.5/seed").is_file():
        assert time.monotonic() < end
        time.sleep(0.05)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    (to / "0.5/ours").touch()
    monkeypatch.setenv("FAKE_SLEEP", "0")
    time.sleep(0.5)  # its solver ends with it
    case = Case(column)
    run_case(case, to, case.settings_for(5, SMALL), anew=False)
    assert len(started(fake_solver)) == 2
    assert (to / "0.5/ours").is_file(), "the run has been begun again"
    assert (to / "log.elutriaFoam.1").is_file()
    assert (to / "finished.json").is_file()


def test_other_inputs_are_refused_or_go_on(column: Path, fake_solver: Path, tmp_path: Path) -> None:
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL), anew=False)
    (to / "0.5/ours").touch()
    longer = case.settings_for(5, [*SMALL, f"{DRAIN}=9"])
    with pytest.raises(InputError, match=r"drainTime \(not set, now 9\).*--extend"):
        run_case(case, to, longer, anew=False)
    assert len(started(fake_solver)) == 1
    run_case(case, to, longer, anew=False, extend=True)
    run_case(case, to, longer, anew=False, extend=True)
    assert len(started(fake_solver)) == 2
    assert (to / "0.5/ours").is_file()
    assert Case(to).value(*DRAIN.split(":")) == "9"


@pytest.mark.usefixtures("fake_solver")
def test_what_the_solver_refuses_leaves_the_run_as_it_was(column: Path, tmp_path: Path) -> None:
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL))

    def inputs() -> dict[Path, bytes]:
        return {p: p.read_bytes() for p in to.rglob("*") if p.is_file() and "log" not in p.name}

    before = inputs()
    with pytest.raises(InputError, match="seed is 7"):
        run_case(case, to, case.settings_for(5, [*SMALL, f"{SEED}=7"]), extend=True)
    assert inputs() == before
    mesh = column / "system/blockMeshDict"
    mesh.write_text(mesh.read_text().replace("(10 10 49)", "(12 12 49)"))
    with pytest.raises(InputError, match="system/blockMeshDict: has changed"):
        run_case(Case(column), to, case.settings_for(5, SMALL), extend=True)
    assert inputs() == before


@pytest.mark.usefixtures("fake_solver")
@pytest.mark.parametrize(
    ("entry", "value", "said"),
    [
        ("system/scenePlan:gasTolerance", "0.2", "system/scenePlan: has changed"),
        ("system/controlDict:deltaT", "1e-5", "system/controlDict: deltaT: has changed"),
        ("system/controlDict:writeInterval", "7", ""),
    ],
)
def test_a_run_that_is_over_is_not_taken_for_one_of_other_steps(
    column: Path, tmp_path: Path, entry: str, value: str, said: str
) -> None:
    """Its past was computed as the files were then."""
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL))
    before = (to / "finished.json").read_bytes()
    other = case.settings_for(5, [*SMALL, f"{entry}={value}"])
    if not said:
        run_case(case, to, other, extend=True)
        return
    with pytest.raises(InputError, match=said):
        run_case(case, to, other, extend=True)
    assert (to / "finished.json").read_bytes() == before


def test_a_run_that_was_steered_is_no_start_of_one_that_was_not(
    column: Path, fake_solver: Path, tmp_path: Path
) -> None:
    """It went on from its end, as one of the case."""
    to, case = tmp_path / "results", Case(column)
    sweep(column, to, "5")
    for number, again in enumerate(("sweep", "run"), start=2):
        (to / "U5/system/steering").write_text("changes ((1 2 1));")
        (to / "U5/0.5/theirs").touch()
        (to / "U5/finished.json").unlink()
        if again == "sweep":
            sweep(column, to, "5")
        else:
            run_case(case, to / "U5", case.settings_for(5, SMALL), anew=False)
        assert not (to / "U5/system/steering").exists()
        assert not (to / "U5/0.5/theirs").exists()
        assert velocities(to) == {5}
        assert len(started(fake_solver)) == number


def test_a_grid_has_its_settings_as_columns(
    column: Path, fake_solver: Path, tmp_path: Path
) -> None:
    to = tmp_path / "results"
    sweep(column, to, "4,5")
    sweep(column, to, "4,5", vary=[f"{LOADING}=0.1,0.8"])
    sweep(column, to, "4", vary=[f"{LOADING}=0.2"])
    assert len(started(fake_solver)) == 6  # 0.2 is the case's own
    assert (to / "U4_loading=0.8/finished.json").is_file()
    for name, columns in (("summary", tables.SUMMARY), ("partition", tables.PARTITION),
                          ("fit", tables.FIT), ("curve", tables.CURVE)):  # fmt: skip
        rows = read_csv(to / f"{name}.csv", columns)
        head = (to / f"{name}.csv").read_text().splitlines()[0].split(",")
        assert head == [*columns, LOADING]
        assert {(row["gas_velocity_m_s"], row[LOADING]) for row in rows} == {
            (u, loading) for u in (4, 5) for loading in (0.1, 0.2, 0.8)
        }  # fmt: skip
    summary = read_csv(to / "summary.csv", tables.SUMMARY)
    cut = {(r["gas_velocity_m_s"], r[LOADING]): r["d50_m"] for r in summary}
    assert cut[4, 0.8] / cut[4, 0.2] == pytest.approx(4**0.1, rel=0.1)
    assert list(dict.fromkeys(r[LOADING] for r in summary)) == [0.1, 0.2, 0.8]
    known = json.loads((to / "sweep.json").read_text())
    assert known["varied"] == {LOADING: [0.1, 0.2, 0.8]}
    assert known["settings"] == SMALL


@pytest.mark.usefixtures("fake_solver")
def test_a_run_counts_once_and_one_that_was_steered_not(column: Path, tmp_path: Path) -> None:
    """`elutria view` of a case puts its run in the folder of a sweep of it, if no other is given:
    the events of both would be twice as many as there are."""
    to = tmp_path / "results"
    sweep(column, to, "4,5")
    before = (to / "summary.csv").read_text()
    for run, view, steered in (("U4", "view", False), ("U5", "A", True)):
        shutil.copytree(to / run, to / view)
        if steered:
            finished = json.loads((to / view / "finished.json").read_text())
            write_json(to / view / "finished.json", {**finished, "inputs": "others"})
    sweep(column, to, "4,5")
    assert (to / "summary.csv").read_text() == before
    assert [run.name for run in find_runs(to, read_results(to).settings)] == ["U4", "U5"]


@pytest.mark.usefixtures("fake_solver")
def test_points_of_a_file_are_runs(column: Path, tmp_path: Path) -> None:
    file = tmp_path / "points.csv"
    file.write_text(f"gas_velocity_m_s,{LOADING}\n4,0.2\n5,0.4\n4,0.2\n")
    points = read_points(Case(column), file)
    assert [(point.velocity, dict(point.others)) for point in points] == [
        (4, {}), (5, {LOADING: "0.4"})
    ]  # fmt: skip


@pytest.mark.usefixtures("fake_solver")
def test_points_as_a_spreadsheet_writes_them(column: Path, tmp_path: Path) -> None:
    """With a byte order mark, CRLF, and rows of empty cells, which count as lines."""
    file = tmp_path / "points.csv"
    text = f"\ufeffgas_velocity_m_s,{LOADING}\r\n4,0.2\r\n,\r\n\r\n5,0.4\r\n"
    file.write_text(text, "utf-8")
    assert [point.velocity for point in read_points(Case(column), file)] == [4, 5]
    file.write_text(text + "6,x\r\n", "utf-8")
    with pytest.raises(InputError, match="'x' in line 6"):
        read_points(Case(column), file)


@pytest.mark.parametrize(
    "axis, said",
    [
        ("system/simulationParameters:loadng=1,2", "did you mean 'loading'|loadng"),
        ("system/nothing:loading=1,2", "system/nothing: no such file"),
        (f"{LOADING}=1,x", "'1,x'; allowed: A:B:N"),
        (f"{LOADING}=1:2", "'1:2'; allowed: A:B:N"),
        (f"{LOADING}=1:2:0", "allowed: A:B:N"),
        (f"{LOADING}=nan", "not finite"),
        ("loading=1,2", "allowed: FILE:ENTRY=A:B:N"),
        ("system/simulationParameters:parcels=1:2:3", "no number"),
        ("constant/feed:materials/quartz=1,2", "is a dictionary"),
        ("system/simulationParameters:gasVelocity=1,2", "varied twice"),
    ],
)
def test_bad_axes_are_one_line(column: Path, axis: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        grid(Case(column), "5", [axis])
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text, said",
    [
        ("gas_velocity_m_s\n", "holds no points"),
        ("gas_velocity\n5\n", "column 'gas_velocity'; allowed"),
        ("gas_velocity_m_s\nx\n", "'x' in line 2"),
        (f"gas_velocity_m_s;{LOADING}\n5;0,2\n", "columns are parted by ';'; allowed: commas"),
        (f"gas_velocity_m_s,{LOADING}\n5\n", "line 2 has 1 cells"),
        ("system/simulationParameters:lodng\n5\n", "lodng"),
    ],
)
def test_bad_points_are_one_line(column: Path, tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "points.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=said):
        read_points(Case(column), file)


INCLUDE = '#include "../../common/rates"'


def with_files_elsewhere(column: Path) -> tuple[Path, Path]:
    """Give the column a variable of a file beside it, and a sieve analysis at its top."""
    common = column.parent / "common/rates"
    common.parent.mkdir()
    common.write_text("rate 1e-4;\n")
    (column / "sieves.csv").write_text("diameter_mm,retained_g\n2,0\n1,5\n0.5,5\n")
    feed = column / "constant/feed"
    text = feed.read_text().replace("#include", f"{INCLUDE}\n#include", 1)
    text = re.sub(r"\bloading\s+\$loading;", "massFlowRate $rate;", text)
    law = 'sizeDistribution { type sieve; file "sieves.csv"; }'
    feed.write_text(re.sub(r"(?s)sizeDistribution\s*\{.*?\}", law, text))
    return common, column / "sieves.csv"


@pytest.mark.usefixtures("fake_solver")
def test_files_elsewhere_are_inputs_too(column: Path, tmp_path: Path) -> None:
    """What is included from outside of the case, and a csv file at its top, is in each copy, and a
    run is one of other inputs when it changes."""
    files = with_files_elsewhere(column)
    to = tmp_path / "far/results/one"
    case = Case(column)
    copy = run_case(case, to, case.settings_for(5, SMALL), anew=False)
    assert copy.feed().mass_flow_rate == 1e-4
    assert (to / "sieves.csv").read_bytes() == files[1].read_bytes()
    for file, name in zip(files, ("../../common/rates", "sieves.csv"), strict=True):
        before = file.read_text()
        file.write_text(before + "\n")
        with pytest.raises(InputError, match=rf"run of other inputs \({re.escape(name)}\)"):
            run_case(case, to, case.settings_for(5, SMALL), anew=False)
        file.write_text(before)
    run_case(case, to, case.settings_for(5, SMALL), anew=False)


@pytest.mark.usefixtures("fake_solver")
def test_what_a_mesh_script_may_read_is_input(column: Path, tmp_path: Path) -> None:
    (column / "Allmesh").write_text("#!/bin/sh\ncp -r drawings/polyMesh constant\n")
    (column / "Allmesh").chmod(0o755)
    (column / "drawings/polyMesh").mkdir(parents=True)
    drawing = column / "drawings/tube.stl"
    drawing.write_text("solid tube")
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL), anew=False)
    (column / "README.md").write_text("a note")
    run_case(case, to, case.settings_for(5, SMALL), anew=False)
    drawing.write_text("solid bent")
    with pytest.raises(InputError, match=r"other inputs \(drawings/tube\.stl\)"):
        run_case(case, to, case.settings_for(5, SMALL), anew=False)


@pytest.mark.usefixtures("fake_solver")
def test_a_case_may_lie_below_any_name(column: Path, tmp_path: Path) -> None:
    (tmp_path / "polyMesh").mkdir()
    case = Case(column.rename(tmp_path / "polyMesh/column"))
    run_case(case, tmp_path / "one", case.settings_for(5, SMALL), anew=False)
    feed = case.path / "constant/feed"
    feed.write_text(feed.read_text().replace("2650", "2700"))
    with pytest.raises(InputError, match=r"other inputs \(constant/feed\)"):
        run_case(case, tmp_path / "one", case.settings_for(5, SMALL), anew=False)


def test_a_parameter_that_no_file_takes_is_no_label(column: Path, fake_solver: Path) -> None:
    """A loading that was written out in constant/feed, and its seed: a sweep of the parameter would
    give one result under two labels, and replicates one run twice."""
    feed = column / "constant/feed"
    text = feed.read_text().replace("$loading;", "0.5; // $loading;").replace("$seed;", "3;")
    feed.write_text(text)
    to = column.parent / "results"
    takes = r"column/system/simulationParameters: {0}: no file of the case takes \${0}, .*feed:{0}$"
    with pytest.raises(InputError, match=takes.format("loading")):
        sweep(column, to, "5", vary=[f"{LOADING}=0.1,0.2"])
    with pytest.raises(InputError, match=takes.format("loading")):
        sweep(column, to, "5", extra=[f"{LOADING}=0.1"])
    with pytest.raises(InputError, match=takes.format("seed")):
        sweep(column, to, "5", replicates=2)
    with pytest.raises(InputError, match=takes.format("seed")):
        sweep(column, to, "5", precision=Precision(0.01, 3))
    assert not to.exists()
    assert started(fake_solver) == []
    plan(Case(column), to, grid(Case(column), "5", ["constant/feed:loading=0.1,0.2"]), 1, [])


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("Allmesh", "python3 mesh.py"),
        ("system/mesh.py", "stages = parameters['stages']"),
        ("system/mesh.py", "of = read('system/simulationParameters')['sta' + 'ges']"),
        ("system/sampleDict", 'a #calc "$stages + 1";'),
        ("constant/g", '#calc #{ dict.get<label>("stages") #}'),
        ("system/simulationParameters", "feedStage ${stages};"),
    ],
)
def test_a_parameter_may_be_taken_anywhere(column: Path, file: str, text: str) -> None:
    with (column / "system/simulationParameters").open("a") as parameters:
        parameters.write("stages 3;\n")
    if file == "Allmesh":
        text = text.replace("mesh.py", "mesh.py stages")
    with (column / file).open("a") as stream:
        stream.write(f"{text}\n")
    Case(column).require_used("system/simulationParameters:stages")


def test_the_gas_velocity_is_given_once(column: Path) -> None:
    """Also where there is no --velocity: folders, rows and figures have their names by it."""
    for velocity in (6, None):
        with pytest.raises(InputError, match=r"gasVelocity=7: allowed: --velocity 7 instead"):
            Case(column).settings_for(velocity, ["system/simulationParameters:gasVelocity=7"])


def test_points_have_folders_of_their_own(column: Path, tmp_path: Path) -> None:
    case, vary = Case(column), "constant/feed:velocity"
    points = grid(case, "5", [f"{vary}=(0.4 0 0),(-0.4 0 0)"])
    assert [point.folder for point in points] == [
        "U5_constant-feed-velocity=0.4-0-0", "U5_constant-feed-velocity=-0.4-0-0"
    ]  # fmt: skip
    assert len(plan(case, tmp_path / "to", points, 1, [])) == 2
    alike = grid(case, "5", [f"{vary}=(0.4 0 0),(0.4  0 0 )"])
    with pytest.raises(InputError, match=r"--vary: .* are both U5_constant-feed-velocity=0\.4-0-0"):
        plan(case, tmp_path / "to", alike, 1, [])


def test_a_point_has_one_gas_velocity(column: Path, tmp_path: Path) -> None:
    file = tmp_path / "points.csv"
    file.write_text("gas_velocity_m_s,system/simulationParameters:gasVelocity\n5,6\n")
    with pytest.raises(InputError, match=r"points\.csv: columns .* allowed: one of both"):
        read_points(Case(column), file)


@pytest.mark.parametrize(
    "name",
    ["system/snappyHexMeshDict", "system/topoSetDict", "system/createPatchDict.inlets",
     "system/extrudeMeshDict", "system/zigzagMesh.py", "constant/triSurface/tube.stl.gz"],
)  # fmt: skip
@pytest.mark.usefixtures("fake_solver")
def test_a_run_goes_on_in_the_mesh_that_it_has(column: Path, tmp_path: Path, name: str) -> None:
    """What makes the mesh is refused when it has changed: the mesh would not."""
    (column / "constant/triSurface").mkdir()
    (column / name).write_text("a 1;\n")
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL))
    (column / name).write_text("a 2;\n")
    with pytest.raises(InputError, match=rf"^{name}: has changed"):
        run_case(Case(column), to, case.settings_for(5, SMALL), extend=True)


@pytest.mark.usefixtures("fake_solver")
def test_another_number_of_processors_is_named(column: Path, tmp_path: Path) -> None:
    case, to = Case(column), tmp_path / "one"
    run_case(case, to, case.settings_for(5, SMALL))
    with pytest.raises(InputError, match=r"other inputs \(--np 1, now 2\)"):
        run_case(case, to, case.settings_for(5, SMALL), 2, anew=False)
