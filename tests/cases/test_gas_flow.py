"""Loading, label and tables follow the gas as it is solved, not what a field's file says."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria.case.case import PARAMETERS, Case, Setting
from elutria.cli import main
from elutria.errors import InputError
from elutria.files import read_csv
from elutria.running.gas import gas_warnings, mean_gas, require_acting_velocity
from elutria.running.run import ask_plan
from elutria.tables import PATCH_FLOWS
from elutria_validation.harness.box import BoxCase
from elutria_validation.harness.cases import (
    CONTROL,
    add_feed,
    change,
    solve,
    times,
    uniform,
)

LOADING, SIDE, DENSITY, GRAVITY = 0.1, 0.1, 1.2, 9.80665
INLET = "0/U.air:boundaryField/inflow"


def box(folder: Path, inlet: dict[str, Any], speed: float, **fields: Any) -> Path:
    """A frictionless duct of 0.1 m with a little feed, its inlet's velocity as given."""
    case = BoxCase(
        gas_velocity=speed, cells=(2, 2, 4), solve_gas="auto", converge_gas="auto", coupled=True,
        step=1e-3, end=4e-3, **fields,
    ).make(folder)  # fmt: skip
    change(case, {INLET: inlet})
    solid = uniform(2e3, 1e-4, 2e-4)
    add_feed(case, {"loading": LOADING, "particles": 2, "drainTime": 0, "materials": solid})
    return case


def plan_of(case: Path) -> dict[str, Any]:
    solve(case)
    plan: dict[str, Any] = json.loads((case / "postProcessing/plan.json").read_text())
    return plan


def test_a_flow_rate_decides_and_not_its_placeholder(tmp_path: Path) -> None:
    kind = "flowRateInletVelocity"
    inlet = {"type": kind, "volumetricFlowRate": 0.02, "value": [0, 0, 0]}
    case = box(tmp_path / "case", inlet, 2)
    plan = plan_of(case)
    assert plan["feed"]["rate_kg_s"] == pytest.approx(LOADING * DENSITY * 0.02, rel=1e-9)
    assert plan["gas"]["superficial_m_s"] == pytest.approx(0.02 / SIDE**2, rel=1e-9)
    rows = {row["patch"]: row for row in mean_gas(case)}
    for patch, sign in (("bottom", 1), ("top", -1), ("all", 1)):
        assert rows[patch]["volume_flow_m3_s"] == pytest.approx(sign * 0.02, rel=1e-4), patch
    assert rows["bottom"]["asked_volume_flow_m3_s"] == pytest.approx(0.02, rel=1e-9)
    assert np.isnan(rows["top"]["asked_volume_flow_m3_s"])
    assert rows["all"]["velocity_m_s"] == pytest.approx(2, rel=1e-4)
    assert rows["bottom"]["mass_flow_kg_s"] == pytest.approx(DENSITY * 0.02, rel=1e-4)


def test_a_total_pressure_drives_the_gas_and_the_feed_follows(tmp_path: Path) -> None:
    """Bernoulli without friction: p0 = g h + U2/2."""
    speed = 3.0
    inlet = {"type": "pressureInletOutletVelocity", "phi": "phi.air", "value": [0, 0, 0]}
    case = box(tmp_path / "case", inlet, 0)
    total = GRAVITY * SIDE + speed**2 / 2
    change(case, {"0/p:boundaryField/inflow": {
        "type": "totalPressure", "p0": total, "U": "U.air", "phi": "phi.air",
        "rho": "none", "psi": "none", "gamma": 1, "value": total}})  # fmt: skip
    plan = plan_of(case)
    assert not plan["gas"]["inflow_is_fixed"]
    found = plan["gas"]["superficial_m_s"]
    assert found == pytest.approx(speed, rel=0.02)
    flow = read_csv(next(case.glob("postProcessing/gas/*/gas.csv")), PATCH_FLOWS, ("patch",))
    entered = next(row["mass_flow_kg_s"] for row in flow if row["patch"] == "bottom")
    assert plan["feed"]["rate_kg_s"] == pytest.approx(LOADING * entered, rel=1e-5)
    # a restart feeds as it began
    state = (case / times(case)[-1] / "uniform/feedGas").read_text()
    told = float(state.split("massFlow")[1].split(";")[0])
    assert told == pytest.approx(entered, rel=1e-5)


@pytest.mark.parametrize("later", [2.0, 4.0])
def test_gas_that_changes_on_the_way_is_told_of(tmp_path: Path, later: float) -> None:
    """The feed and the label are those of the gas at first, 2 m/s."""
    table = f"((0 (0 0 2)) (0.009 (0 0 2)) (0.01 (0 0 {later})) (9 (0 0 {later})))"
    case = box(tmp_path / "case", {"type": "fixedValue", "value": [0, 0, 2]}, 2)
    field = case / "0/U.air"
    text = field.read_text()
    assert "fixedValue" in text
    kind = f"type uniformFixedValue; uniformValue table {table}; value uniform (0 0 2);"
    field.write_text(re.sub(r"(inflow\s*\{)[^}]*\}", rf"\1 {kind} }}", text))
    more = {"constant/feed:parcels": "evenSizes", "constant/feed:duration": 0.02}
    change(case, {f"{CONTROL}:endTime": 0.02, f"{CONTROL}:writeInterval": 0.005, **more})
    plan = plan_of(case)
    assert plan["gas"]["superficial_m_s"] == pytest.approx(2)
    told = gas_warnings(case, 2.0)
    assert [warned.name for warned in told] == (["gasChanges"] if later > 2 else [])
    if told:
        assert "2 m/s at first, 3" in told[0].how_much
        assert "(2 to 4)" in told[0].how_much
        fed = json.loads((case / "postProcessing/ledger.json").read_text())["total"]["injected"]
        assert fed["mass_kg"] == pytest.approx(LOADING * DENSITY * 0.02 * 0.02, rel=1e-9)


@pytest.fixture
def written_out(column: Path) -> Path:
    """The column with its inlet's velocity written out."""
    field = column / "0.orig/U.air"
    text = field.read_text()
    assert text.count("value           uniform (0 0 $gasVelocity)") == 1
    old = "value           uniform (0 0 $gasVelocity)"
    field.write_text(text.replace(old, "value           uniform (0 0 6)"))
    return column


def test_a_velocity_that_does_not_act_stops_the_sweep(
    written_out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    to = tmp_path / "results"
    with pytest.raises(SystemExit) as end:
        main(["sweep", str(written_out), "--velocity", "4,6,8", "--to", str(to)])
    assert end.value.code == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "system/simulationParameters: gasVelocity is 4 m/s" in said
    assert "6 m/s at bottom" in said
    assert not list(to.glob("U*"))


def test_a_velocity_that_the_gas_has_is_taken(written_out: Path) -> None:
    require_acting_velocity(Case(written_out), [(6.0, [])])
    with pytest.raises(InputError, match=r"gasVelocity is 6\.1 m/s"):
        require_acting_velocity(
            Case(written_out), [(6.1, [Setting.parse(f"{PARAMETERS}:gasVelocity=6.1")])]
        )


def test_an_open_feed_slot_is_refused_and_flows_when_named(column: Path) -> None:
    """A split inflow: the plan has both inlets, and the loading is of both."""
    plan = column / "system/blockMeshDict"
    head, rest = plan.read_text().split("    feedSlot", 1)
    plan.write_text(head + "    feedSlot" + rest.replace("type wall", "type patch", 1))
    for name in ("U.air", "p", "k.air", "epsilon.air", "nut.air"):
        field = column / "0.orig" / name
        text = field.read_text().replace('"walls|feedSlot"', "walls")
        kind = {"U.air": "fixedValue", "p": "fixedFluxPressure", "nut.air": "calculated"}
        value = "uniform (2 0 0)" if name == "U.air" else "$internalField"
        entry = (
            f"    feedSlot\n    {{\n        type {kind.get(name, 'fixedValue')};\n"
            f"        value {value};\n    }}\n"
        )
        place = text.index("{", text.index("boundaryField")) + 2
        field.write_text(text[:place] + entry + text[place:])
    with pytest.raises(InputError, match="the open patch feedSlot belongs to no product"):
        ask_plan(Case(column))
    text = (column / "constant/feed").read_text()
    coarse = "coarse          (bottom);"
    named = text.replace(coarse, coarse + "\n    other (feedSlot);")
    (column / "constant/feed").write_text(named)
    found = ask_plan(Case(column))
    flow = 6 * 0.05**2 + 2 * 0.05 * 0.01
    loading = 0.2
    assert found["feed"]["rate_kg_s"] == pytest.approx(loading * 1.2 * flow, rel=1e-6)
    speeds = {inlet["patch"]: inlet["velocity_m_s"] for inlet in found["gas"]["inlets"]}
    assert speeds == pytest.approx({"bottom": 6.0, "feedSlot": 2.0})
