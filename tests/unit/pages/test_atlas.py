"""The atlas: what it keeps is what was run; what it answers between runs is known, and no more."""

from __future__ import annotations

import json
import re
import shutil
from math import exp, log
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elutria import tables
from elutria.classification.classify import Classification, classify
from elutria.classification.curves import MODELS
from elutria.classification.events import Account, Events, Run, read_run
from elutria.errors import ElutriaError, InputError
from elutria.files import read_csv
from elutria.output.results import read_results
from elutria.pages import atlas
from elutria.pages.atlas import content, write_atlas
from elutria.pages.browser import find_browser, run_browser
from elutria.pages.runs import find_runs

ASK = """<pre id="asked"></pre><script>
const states = STATES;
const found = states.map((state) => {
  const start = performance.now(), one = answer(state);
  const materials = {};
  Object.entries(one.materials).forEach(([name, own]) => {
    materials[name] = Object.assign({}, own);
    if (own.curve) materials[name].at = (state.sizes || []).map((d) =>
      ["share", "low", "high"].map((which) => own.curve[which](Math.log(d))));
  });
  return { beyond: one.beyond, products: one.products, materials: materials, runs: one.runs,
           ms: performance.now() - start };
});
document.getElementById("asked").textContent = JSON.stringify(found);
</script></body>"""


def ask(file: Path, states: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What the page answers, in a browser."""
    program = find_browser()
    if program is None:
        pytest.skip("no Chromium on PATH; on Debian: apt-get install chromium")
    asking = file.with_name("asking.html")
    asked = ASK.replace("STATES", json.dumps(states))
    asking.write_text(file.read_text().replace("</body>", asked))
    shown = run_browser(program, ["--dump-dom", asking.as_uri()])
    text = re.search(r'<pre id="asked">(.*?)</pre>', shown.stdout, re.S)
    assert text, shown.stderr
    made: list[dict[str, Any]] = json.loads(text[1].replace("&gt;", ">").replace("&amp;", "&"))
    return made


def state(velocity: float, **law: float) -> dict[str, Any]:
    fed = {"share": 1, "law": law or None}
    return {"at": {"gas_velocity_m_s": velocity}, "feed": {"quartz": fed}}


def kept(folder: Path) -> dict[str, Any]:
    results = read_results(folder)
    return content(results, find_runs(folder, results.settings))


def test_each_node_is_its_run(made: Path) -> None:
    data = kept(made)
    summary = {row["gas_velocity_m_s"]: row for row in read_csv(made / "summary.csv", ["d50_m"])}
    curve = read_csv(made / "curve.csv", tables.CURVE)
    assert [node["runs"] for node in data["nodes"]] == [["U5"], ["U6"], ["U7"]]
    for node in data["nodes"]:
        velocity = node["at"][0]
        own = node["curves"]["quartz"]
        d50 = exp(own["cut"] + np.interp(log(velocity), *data["theory"]["quartz"]))
        assert d50 == pytest.approx(summary[velocity]["d50_m"], rel=1e-5)
        rows = [r for r in curve if r["gas_velocity_m_s"] == velocity and r["material"] == "quartz"]
        for row in rows[::40]:
            logit = np.interp(log(row["diameter_m"] / d50), data["grid"], own["t"])
            assert 1 / (1 + exp(-logit)) == pytest.approx(row["partition_to_coarse"], abs=0.01)
        assert sum(own["parcels"]) == 796  # of 800, 4 are still inside
        # plan: 0.2 kg/kg slows the gas by 0.16/U; 5 % are too much
        assert node["sparse"] == pytest.approx(0.2 * 0.05 * velocity / 0.16, rel=1e-5)


def test_what_interpolation_is_off_by_comes_from_leaving_out() -> None:
    at = np.log(np.array([2.0, 3.0, 5.0, 6.0]))
    parabola = [float(0.7 * y**2 + 2 * y) for y in at]
    for k in range(4):
        assert atlas._bend(at, list(parabola), k) == pytest.approx(0.7, rel=1e-3)
    assert atlas._bend(at, [None, *parabola[1:]], 0) == pytest.approx(0.7, rel=1e-3)
    # with two nodes nothing is known of what is between: as much as they differ by
    assert atlas._bend(at[:2], [1.0, 2.0], 0) == pytest.approx(1 / np.log(1.5) ** 2)


def test_the_answer_at_a_run_is_the_run(made: Path, tmp_path: Path) -> None:
    file = write_atlas(made, tmp_path / "atlas.html")
    coarser = {"d63": 1.1e-3, "n": 4.0}
    at_run, between, beyond, other, absent = ask(
        file,
        [state(6.0), state(5.5), state(8.0), state(6.0, **coarser), state(6.0, d63=1e-4, n=3.0)],
    )
    (row,) = [r for r in read_csv(made / "summary.csv", ["d50_m"])
              if r["gas_velocity_m_s"] == 6 and r["material"] == "quartz"]  # fmt: skip
    own = at_run["materials"]["quartz"]
    for name in ("d25", "d50", "d75", "d50_low", "d50_high"):
        assert own[name] == pytest.approx(row[f"{name}_m"], rel=3e-3), name
    assert at_run["beyond"] == between["beyond"] == []
    assert at_run["runs"] == [{"runs": ["U6"], "weight": 1}]
    assert sorted(one["runs"][0] for one in between["runs"]) == ["U5", "U6"]
    assert own["off"] == 0 < between["materials"]["quartz"]["off"]
    assert "beyond those that were run" in beyond["beyond"][0]
    assert "beyond the sizes that were run" in absent["beyond"][0]
    assert max(one["ms"] for one in (at_run, between, other)) < 100
    # another feed: the run's own parcels, weighted by hand to the law's mass in narrow classes
    events = read_run(made / "U6").events
    left = events.select(events.has_left)
    limits = np.geomspace(left.diameter.min(), left.diameter.max() * 1.0001, 40)
    place = np.searchsorted(limits, left.diameter, side="right") - 1
    law = -np.expm1(-((limits / coarser["d63"]) ** coarser["n"]))
    fed = np.bincount(place, left.mass, 39)
    weighted = left.mass * (np.diff(law) / np.maximum(fed, 1e-300))[place]
    recovery = weighted[left.is_coarse].sum() / weighted.sum()
    (coarse,) = [one for one in other["products"] if one["product"] == "coarse"]
    assert coarse["recovery"]["low"] < recovery < coarse["recovery"]["high"]
    assert coarse["recovery"]["value"] == pytest.approx(recovery, abs=0.02)
    (before,) = [one for one in at_run["products"] if one["product"] == "coarse"]
    assert coarse["recovery"]["value"] > before["recovery"]["value"] + 0.05


LOADING = "system/simulationParameters:loading"


def with_loading(results: Path, other: float, factor: float) -> None:
    """To runs at 0.2 kg/kg, those at another loading, whose cut sizes are larger by a factor."""
    for run in list(results.glob("U*")):
        twin = shutil.copytree(run, results / f"{run.name}_loading={other:g}")
        parameters = twin / "system/simulationParameters"
        text = re.sub(r"(?m)^loading.*$", f"loading {other:g};", parameters.read_text())
        parameters.write_text(text)
    for name in ("summary", "partition", "curve"):
        head, *rows = (results / f"{name}.csv").read_text().splitlines()
        columns = head.split(",")
        lines = [f"{head},{LOADING}", *(f"{row},0.2" for row in rows)]
        for row in rows:
            cells = row.split(",")
            for k, column in enumerate(columns):
                if name != "partition" and column[0] == "d" and column.endswith("_m"):
                    cells[k] = f"{float(cells[k]) * factor:.9g}"
            lines.append(",".join([*cells, f"{other:g}"]))
        (results / f"{name}.csv").write_text("\n".join(lines) + "\n")


def test_two_settings_are_interpolated_in_both(results: Path) -> None:
    with_loading(results, 0.8, 1.21)
    file = write_atlas(results, results / "atlas.html")
    asked = [state(5.0), state(5.0), state(5.0), state(5.5)]
    for one, loading in zip(asked, (0.2, 0.4, 0.8, 0.4), strict=True):
        one["at"][LOADING] = loading
    low, middle, high, between = ask(file, asked)
    cuts = [one["materials"]["quartz"]["d50"] for one in (low, middle, high)]
    assert cuts[2] / cuts[0] == pytest.approx(1.21, rel=1e-3)
    assert cuts[1] / cuts[0] == pytest.approx(1.1, rel=1e-3)  # halfway in the logarithm
    assert {name for one in between["runs"] for name in one["runs"]} == {
        "U5", "U6", "U5_loading=0.8", "U6_loading=0.8",
    }  # fmt: skip
    assert between["beyond"] == []
    shutil.rmtree(results / "U6_loading=0.8")
    found = ask(write_atlas(results, results / "atlas.html"), asked[3:])[0]
    assert found["beyond"] == ["a setting beside this point was not run"]


def test_a_sweep_that_leaves_nothing_between_is_refused(results: Path) -> None:
    for run in ("U5", "U7"):
        shutil.rmtree(results / run)
    with pytest.raises(InputError, match="two settings or more"):
        write_atlas(results, results / "atlas.html")


def test_a_page_that_is_too_large_is_refused(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(atlas, "LARGEST", 10_000)
    with pytest.raises(ElutriaError, match=r"MB; allowed: 0\.01 MB"):
        write_atlas(made, tmp_path / "atlas.html")
    assert not (tmp_path / "atlas.html").exists()


def true_cut(velocity: float) -> float:
    """A cut size that no interpolation in the logarithms gives exactly, m."""
    return 100e-6 * velocity**1.2 * (1 + 0.06 * np.sin(1.5 * velocity))


@pytest.mark.slow
def test_forty_seven_of_fifty_points_between_lie_within_the_band(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs with a known cut at 3, 4 ... 10 m/s; asked at velocities that were not run."""
    random = np.random.default_rng(5)
    tables_made, runs = Classification(), {}
    velocities = [3.0, 4, 5, 6, 7, 8, 9, 10]
    for velocity in velocities:
        number = 12_000
        size = np.exp(random.uniform(log(250e-6), log(2e-3), number))
        coarse = random.random(number) < MODELS[0].share(size / true_cut(velocity), 3.0)
        events = Events(
            material=np.full(number, "quartz"), outlet=np.where(coarse, "coarse", "fines"),
            diameter=size, density=np.full(number, 2650.0), number=np.ones(number),
            time=np.zeros(number),
        )  # fmt: skip
        whole = (float(number), float(events.mass.sum()))
        none = (0.0, 0.0)
        account = Account(whole, {"fines": none, "coarse": whole}, none, none)
        runs[f"U{velocity:g}"] = Run(events, {"quartz": account, "all": account})
        tables_made.extend(classify(runs[f"U{velocity:g}"], velocity, 1.0))
        shutil.copytree(made / "U6", tmp_path / f"U{velocity:g}")
        parameters = tmp_path / f"U{velocity:g}/system/simulationParameters"
        text = re.sub(r"(?m)^gasVelocity.*$", f"gasVelocity {velocity:g};", parameters.read_text())
        parameters.write_text(text)
    tables_made.write(tmp_path)
    monkeypatch.setattr(atlas, "read_run", lambda path: runs[path.name])
    file = write_atlas(tmp_path, tmp_path / "atlas.html")
    points = random.uniform(3, 10, 50)
    states = [{**state(float(u)), "sizes": [true_cut(float(u)) * x for x in (0.8, 1, 1.25)]}
              for u in points]  # fmt: skip
    inside = {"d50": 0, "T": 0}
    for u, found in zip(points, ask(file, states), strict=True):
        own = found["materials"]["quartz"]
        assert found["beyond"] == []
        inside["d50"] += own["d50_low"] <= true_cut(float(u)) <= own["d50_high"]
        truth = MODELS[0].share(np.array([0.8, 1, 1.25]), 3.0)
        band = np.array(own["at"])
        inside["T"] += bool(np.all((band[:, 1] <= truth) & (truth <= band[:, 2])))
        assert own["d50_high"] / own["d50_low"] < 1.25  # a band that says something
    assert min(inside.values()) >= 47, inside
