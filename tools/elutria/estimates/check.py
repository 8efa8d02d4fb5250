"""What a case says and what follows from it, before anything is run."""

from __future__ import annotations

from math import inf, isfinite

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from elutria.case.case import Case
from elutria.case.feed import Feed, Material
from elutria.estimates.scene import Box, Scene, block_mesh_box, expect
from elutria.physics.drag import Gas, plug_flow_cut_size


def report(case: Case) -> list[Table]:
    """Tables for the terminal. Raises InputError for the first thing that is not allowed."""
    case.check_mesh()
    velocity, feed, gas = case.velocity(), case.feed(), case.gas()
    return [
        _setting(case, velocity, gas, feed),
        _materials(case, velocity, gas, feed),
        *_limits(case, velocity, gas, feed),
    ]


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        table.add_column(column, overflow="fold")
    return table


def _setting(case: Case, velocity: float, gas: Gas, feed: Feed) -> Table:
    table = _table(f"{case.name}: what was understood", "what", "value", "from")
    source, patches = case.patches()
    table.add_row("gas velocity", f"{velocity:g} m/s", "system/simulationParameters")
    table.add_row(
        "gas", f"{gas.density:g} kg/m3, {gas.viscosity:.3g} Pa s", "constant/transportProperties"
    )
    table.add_row("gravity", f"{case.gravity():g} m/s2", "constant/g")
    table.add_row("drag", ", ".join(case.drag_laws()) or "none", "the cloud's particleForces")
    place = f"{'patch' if feed.place_is_patch else 'zone'} {feed.place}"
    table.add_row("fed through", place, "constant/feed")
    for product, names in feed.outlets.items():
        table.add_row(f"{product} leave through", ", ".join(names), "constant/feed")
    table.add_row("patches", ", ".join(patches) or "known after meshing", source or "the mesh")
    if feed.loading is not None:
        table.add_row("loading", f"{feed.loading:g} kg solids per kg gas", "constant/feed")
    else:
        table.add_row("feed rate", f"{feed.mass_flow_rate:g} kg/s", "constant/feed")
    focus = "" if feed.focus == "none" else f", half of them around the cut ({feed.focus})"
    table.add_row("parcels", feed.parcels + focus, "constant/feed")
    until = [] if feed.duration == inf else [f"{feed.duration:g} s"]
    until += [] if feed.particles is None else [f"{feed.particles} parcels"]
    table.add_row("fed until", (" and " if feed.spread else " or ").join(until), "constant/feed")
    table.add_row("seed", str(feed.seed), "constant/feed")
    return table


def _materials(case: Case, velocity: float, gas: Gas, feed: Feed) -> Table:
    law = case.theory_law()
    table = _table(
        f"Materials, and the cut where terminal velocity = gas velocity ({law})",
        "material", "kg/m3", "sphericity", "mass share", "sizes um", "d10 d50 d90 um", "cut um",
    )  # fmt: skip
    for material in feed.materials:
        sizes = material.sizes
        quantiles = sizes.mass_quantile(np.array([0.1, 0.5, 0.9])) * 1e6
        table.add_row(
            material.name,
            f"{material.density:g}",
            f"{material.sphericity:g}",
            f"{material.mass_fraction:g}",
            f"{sizes.name} {sizes.smallest * 1e6:.4g}..{sizes.largest * 1e6:.4g}",
            " ".join(f"{size:.4g}" for size in quantiles),
            _theory(material, velocity, gas, law, case.gravity()),
        )
    return table


def _theory(material: Material, velocity: float, gas: Gas, law: str, gravity: float) -> str:
    if material.density <= gas.density:
        return "none: lighter than the gas"
    size = plug_flow_cut_size(velocity, material.density, gas, law, material.sphericity, gravity)
    within = material.sizes.smallest < size < material.sizes.largest
    return f"{size * 1e6:.4g}" + ("" if within else ", outside the feed")


def _limits(case: Case, velocity: float, gas: Gas, feed: Feed) -> list[Table]:
    box = block_mesh_box(case)
    scene = expect(case, velocity, gas, feed, box)
    return [_steps_and_cells(case, velocity, feed, box, scene), _expected(case, feed, scene)]


def _steps_and_cells(
    case: Case, velocity: float, feed: Feed, box: Box | None, scene: Scene
) -> Table:
    table = _table("Limits", "what", "number", "what follows")
    control = case.dictionary("system/controlDict", with_included=True)
    step = control.number("deltaT", above=0, at_most=1e6, unit="s")
    table.add_row("first time step", f"{step:g} s", f"gas moves {step * velocity * 1e3:.3g} mm")
    courant = control.number("maxCo", None, above=0)
    if box is not None:
        cells = f"{box.smallest_cell * 1e3:.3g} .. {box.largest_cell * 1e3:.3g} mm"
        table.add_row("cells", cells, f"Courant {step * velocity / box.smallest_cell:.2g}")
        share = feed.largest / box.smallest_cell
        follows = "void fraction is spread over a kernel" if share > 0.3 else "a cell holds several"
        table.add_row("largest particle over cell", f"{share:.2g}", follows)
    if courant is not None:
        table.add_row("maxCo", f"{courant:g}", "the gas step adapts to it")
    shortest, longest = scene.shortest_relaxation, scene.longest_relaxation
    table.add_row(
        "relaxation times", f"{shortest:.2g} .. {longest:.2g} s",
        "drag is integrated exactly: no limit to the step",
    )  # fmt: skip
    slip = f"the gas: {velocity:g} m/s"
    table.add_row("fastest settling", f"{scene.fastest_fall:.3g} m/s", slip)
    return table


def _expected(case: Case, feed: Feed, scene: Scene) -> Table:
    """Orders of magnitude, and which part of the work each of them decides."""
    table = _table("Expected (estimates), and what is skipped", "what", "number", "what follows")
    plan = case.path / "system/scenePlan"
    tolerance = 0.01
    if plan.is_file():
        tolerance = case.dictionary("system/scenePlan").number("gasTolerance", tolerance, above=0)
    rates = f"{scene.feed_rate * 1e3:.3g} g/s, {scene.particle_rate:.3g} per s"
    table.add_row("feed", _known(scene.feed_rate, rates), "")
    if feed.particles is not None and scene.parcels is not None:
        if scene.parcels > feed.particles:
            table.add_row(
                "parcels fed", str(scene.parcels), "more than asked for, to collide as particles do"
            )
        seconds = feed.duration if feed.spread else feed.particles / scene.particle_rate
        table.add_row("time to feed all", _known(seconds, f"{seconds:.3g} s"), "of process time")
    inside = f"{scene.inside:.3g} after {scene.residence:.2g} s each"
    table.add_row("particles inside", _known(scene.inside, inside), "")
    table.add_row(
        "solids by volume", _known(scene.solids_fraction, f"{scene.solids_fraction:.2g}"),
        "drag of single particles" if scene.solids_fraction < 1e-3 else "drag feels the neighbours",
    )  # fmt: skip
    table.add_row(
        "collisions of a particle", _known(scene.collisions, f"{scene.collisions:.2g}"),
        "flights are exact between them; steps of a contact only where it lasts",
    )  # fmt: skip
    table.add_row(
        "particles slow the gas by", _known(scene.gas_change, f"{100 * scene.gas_change:.2g} %"),
        "gas rests after it has settled (one-way)" if scene.gas_change < tolerance
        else f"gas is solved again after each change of {100 * tolerance:g} %",
    )  # fmt: skip
    return table


def _known(value: float, text: str) -> str:
    return text if isfinite(value) else "known after meshing"
