"""`elutria check` says what the solver decides: its plan is that of the case's run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from elutria.case.case import PARAMETERS, Case
from elutria.cli import main
from elutria.errors import InputError
from elutria.openfoam.dictionary import set_entry
from elutria.running.run import ask_plan, read_plan, run_case
from tests.unit.test_imports import heavy, modules

BRIEF = {"particles": "5", "feedTime": "0.01", "drainTime": "0.001"}

TWO_MATERIALS = """
    quartz
    {
        density 2650; sphericity 1; massFraction 0.7;
        sizeDistribution { type logNormal; d50 700e-6; sigma 1.5; min 200e-6; max 2e-3; }
    }
    ore
    {
        density 4500; massFraction 0.3;
        sizeDistribution
        {
            type table; diameters (1e-4 3e-4 8e-4); cumulative (0 0.4 1); weighting number;
        }
    }
}
"""


SCATTERED = """
    ore
    {
        densityDistribution { type uniform; min 3500; max 4500; }
        sizeDistribution { type uniform; min 200e-6; max 2e-3; }
    }
}
"""


def test_check_shows_a_rate_over_time_and_a_density_that_scatters(
    column: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    feed = column / "constant/feed"
    text = re.sub(
        r"\bloading\s+\$loading;", "massFlowRate table ((0 1e-4) (1 3e-4));", feed.read_text()
    )
    start = text.index("{", text.index("\nmaterials"))
    feed.write_text(text[: start + 1] + SCATTERED)
    main(["check", str(column)])
    said = " ".join(capsys.readouterr().out.split())
    # cells are folded: what stands in the next column may come between
    assert re.search(r"0\.2 g/s on average, by.*table.*of 2.*times.*up to.*0\.3 g/s", said)
    assert re.search(r"4000.*3500\.\..*4500", said)


def test_check_counts_the_parcels_that_the_feeds_duration_holds(
    column: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of particles of 0.01 g at 1 g/s, 0.1 s has 9; 500 are asked for."""
    feed = column / "constant/feed"
    text = re.sub(r"\bloading\s+\$loading;", "massFlowRate 1e-3;", feed.read_text())
    text = re.sub(r"(?s)sizeDistribution\s*\{.*?\}",
                  "sizeDistribution { type fixedValue; value 2e-3; }", text)  # fmt: skip
    feed.write_text(text)
    for entry, value in {"parcels": "particles", "particles": "500", "feedTime": "0.1"}.items():
        set_entry(column / PARAMETERS, entry, value, column)
    main(["check", str(column)])
    said = " ".join(capsys.readouterr().out.split())
    assert "parcels 9 (fewer than the 500 asked constant/feed for: duration ends before)" in said


@pytest.mark.parametrize(
    ("end", "start", "fed"), [("0.5", "0", "2500"), ("2", "5", "0")], ids=["amid", "before"]
)
def test_a_run_that_ends_before_its_feed_says_so(
    column: Path, end: str, start: str, fed: str
) -> None:
    set_entry(column / "system/controlDict", "endTime", end, column)
    set_entry(column / "constant/feed", "start", start, column)
    cut = "the run ends before its feed is over"
    (said,) = [w for w in ask_plan(Case(column))["warnings"] if cut in w]
    assert f"{cut}: {fed} of 5000 parcels enter by endTime, {end} s; raise endTime" in said
    set_entry(column / "system/controlDict", "endTime", str(float(start) + 1.1), column)
    assert not [w for w in ask_plan(Case(column))["warnings"] if cut in w]


def changed(column: Path, name: str) -> Case:
    """One of five cases made of the default column."""
    parameters = dict(BRIEF)
    feed, blocks = column / "constant/feed", column / "system/blockMeshDict"
    if name == "4 m/s":
        parameters["gasVelocity"] = "4"
    elif name == "loading 5":
        parameters["loading"] = "5"
    elif name == "two materials":
        text = feed.read_text()
        start = text.index("{", text.index("\nmaterials"))
        feed.write_text(text[: start + 1] + TWO_MATERIALS)
    elif name == "cell zone":
        text = re.sub(r"\bpatch\s+feedSlot;", "zone entrance;", feed.read_text())
        feed.write_text(text)
        text, found = re.subn(
            r"(hex \([\d ]+\))\s+(\(10 10 2\))", r"\1 entrance \2", blocks.read_text()
        )
        assert found == 1
        blocks.write_text(text)
    for entry, value in parameters.items():
        set_entry(column / PARAMETERS, entry, value, column)
    return Case(column)


@pytest.fixture(
    params=["default", "4 m/s", "loading 5", "two materials", "cell zone"],
)
def case(request: pytest.FixtureRequest, column: Path) -> Case:
    return changed(column, request.param)


def test_check_foresees_the_plan_of_the_run(
    case: Case, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(case.path.rglob("*"))
    foreseen = ask_plan(case)
    assert sorted(case.path.rglob("*")) == before

    run_case(case, tmp_path / "run", [])
    planned = read_plan(tmp_path / "run")

    # what the gas has no part in is the same, to the last digit
    for part in ("mesh", "feed", "drag", "gravity_m_s2"):
        assert foreseen[part] == planned[part]
    assert foreseen["gas"]["basis"] == "inlet"
    assert planned["gas"]["basis"] == "settled"

    # of the gas, its profile comes with the settling: its speed, and all that goes with it
    speeds = planned["gas"]["speed_m_s"] / foreseen["gas"]["speed_m_s"]
    assert 1 <= speeds < 1.1
    for name, power in {
        "loading": 0, "inside_kg": 0, "solid_fraction": 0, "collisions": 1, "gas_change": -1,
    }.items():  # fmt: skip
        before_it, after_it = foreseen["expected"][name], planned["expected"][name]
        assert after_it == pytest.approx(before_it * speeds**power, rel=1e-6), name

    # what the run's log says is what stands in its plan, and check prints what it was told
    log = " ".join((tmp_path / "run/log.elutriaFoam").read_text().split())
    for row in planned["decisions"]:
        assert " ".join(" ".join(row).split()) in log
    main(["check", str(case.path)])
    printed = " ".join(capsys.readouterr().out.split())
    for number in numbers_of(foreseen):
        assert number in printed


def numbers_of(plan: dict[str, Any]) -> list[str]:
    """As `check` shows them."""
    expected = plan["expected"]
    return [
        f"{expected['collisions']:.3g}",
        f"{100 * expected['gas_change']:.2g} %",
        f"{expected['solid_fraction']:.3g}",
        f"{expected['loading']:.3g} kg",
    ]


def test_a_feed_that_crowds_is_foreseen_with_the_parcels_that_are_added(column: Path) -> None:
    plan = ask_plan(changed(column, "loading 5"))
    assert plan["feed"]["parcels"] == 10 * plan["feed"]["parcels_asked"] == 50
    assert any("more than asked for" in row[1] for row in plan["decisions"])


def test_estimates_of_the_default_column(column: Path) -> None:
    """Sums by hand: 50 x 50 mm, 6 m/s, 0.2 kg of solids per kg of air of 1.2 kg/m3."""
    plan = ask_plan(Case(column))
    rate = 0.2 * 1.2 * 6 * 0.05**2
    assert plan["feed"]["rate_kg_s"] == pytest.approx(rate)
    assert plan["expected"]["loading"] == pytest.approx(0.2)
    assert plan["gas"]["through_time_s"] == pytest.approx(plan["mesh"]["size_m"][2] / 6)
    assert plan["gas"]["speed_m_s"] == pytest.approx(6)
    inside = rate * plan["gas"]["through_time_s"]
    assert plan["expected"]["solid_fraction"] == pytest.approx(
        inside / 2650 / plan["mesh"]["volume_m3"]
    )
    assert 5_000 < plan["feed"]["particles_per_s"] < 20_000


def test_a_thin_feed_meets_nobody_and_leaves_the_gas_alone(column: Path) -> None:
    before = ask_plan(Case(column))
    set_entry(column / PARAMETERS, "loading", "0.0002", column)
    thin = ask_plan(Case(column))
    for name in ("collisions", "gas_change", "solid_fraction", "particles_inside"):
        assert thin["expected"][name] == pytest.approx(before["expected"][name] / 1000, rel=1e-6)
    assert thin["decisions"][0][1] == "one-way until it matters"


def test_the_shape_of_a_law_of_openfoam_is_known(column: Path) -> None:
    """nonSphereDrag's own phi, not the materials' sphericity."""
    cloud = column / "constant/kinematicCloudProperties"
    text = cloud.read_text()
    assert "SchillerNaumannDrag" in text
    cuts = []
    for phi in (1.0, 0.6):
        force = f"nonSphereDrag {{ phi {phi}; }} //"
        cloud.write_text(re.sub(r"SchillerNaumannDrag", force, text))
        plan = ask_plan(Case(column))
        assert plan["drag"] == {"forces": ["nonSphereDrag"], "law": "Haider-Levenspiel"}
        cuts.append(plan["feed"]["materials"][0]["cut_m"])
    assert cuts[1] > 1.3 * cuts[0]


@pytest.mark.parametrize(
    "law, shape, refused",
    [
        ("SchillerNaumannDrag", "sphericity 0.8;", "sphericity 0.8"),
        ("SchillerNaumannDrag", "sphericity 1;", ""),
        ("HaiderLevenspielDrag", "sphericity 0.8;", ""),
        ("nonSphereDrag { phi 0.8; } //", "sphericity 0.8;", ""),
        ("SchillerNaumannDrag", "flatness 0.5; elongation 0.8;", "flatness 0.5 and elongation 0.8"),
    ],
)
def test_a_shape_that_the_drag_does_not_know_is_refused(
    column: Path, law: str, shape: str, refused: str
) -> None:
    for file, old, new in (
        ("constant/kinematicCloudProperties", "SchillerNaumannDrag", law),
        ("constant/feed", "sphericity      1;", shape),
    ):
        text = (column / file).read_text()
        assert old in text
        (column / file).write_text(text.replace(old, new))
    if refused:
        line = (
            f"{refused}, which SchillerNaumannDrag does not take, allowed: .*HaiderLevenspielDrag"
        )
        with pytest.raises(InputError, match=line):
            ask_plan(Case(column))
    else:
        ask_plan(Case(column))


def test_what_the_solver_refuses_is_one_line_of_bad_input(
    column: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A word that only the solver knows to be wrong."""
    cloud = column / "constant/kinematicCloudProperties"
    cloud.write_text(cloud.read_text().replace("SchillerNaumannDrag", "SchilerNaumanDrag"))
    with pytest.raises(SystemExit) as end:
        main(["check", str(column)])
    said = capsys.readouterr().err.strip()
    assert end.value.code == 2
    assert "\n" not in said
    assert "SchilerNaumanDrag" in said
    assert str(column) in said or "kinematicCloudProperties" in said


def test_a_check_loads_little_and_of_a_known_case_less(
    column: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ELUTRIA_CACHE", str(tmp_path / "cache"))
    assert heavy(modules("check", str(column))) <= {"numpy", "foamlib"}
    again = modules("check", str(column))
    assert heavy(again) == set()
    assert len(again) < 450
