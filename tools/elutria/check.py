"""What a case says and what follows from it, before anything is run."""

from __future__ import annotations

from math import inf, pi

from rich.table import Table

from elutria.case import Case
from elutria.drag import Gas, plug_flow_cut_size, terminal_velocity
from elutria.errors import InputError
from elutria.feed import Feed, Material


def report(case: Case) -> list[Table]:
    """Tables for the terminal. Raises InputError for the first thing that is not allowed."""
    velocity, feed, gas = case.velocity(), case.feed(), case.gas()
    return [
        _setting(case, velocity, gas, feed),
        _materials(case, velocity, gas, feed),
        _limits(case, velocity, gas, feed),
    ]


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left")
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
    until = [] if feed.duration == inf else [f"{feed.duration:g} s"]
    until += [] if feed.particles is None else [f"{feed.particles} particles"]
    table.add_row("fed until", " or ".join(until), "constant/feed")
    table.add_row("seed", str(feed.seed), "constant/feed")
    return table


def _materials(case: Case, velocity: float, gas: Gas, feed: Feed) -> Table:
    table = _table(
        "Materials", "material", "density kg/m3", "sphericity", "mass share", "sizes um",
        "d10, d50, d90 um", "cut by theory um",
    )  # fmt: skip
    law = case.theory_law()
    for material in feed.materials:
        sizes = material.sizes
        quantiles = sizes.mass_quantile([0.1, 0.5, 0.9]) * 1e6
        cut = _theory(material, velocity, gas, law, case.gravity())
        table.add_row(
            material.name,
            f"{material.density:g}",
            f"{material.sphericity:g}",
            f"{material.mass_fraction:g}",
            f"{sizes.smallest * 1e6:.4g} .. {sizes.largest * 1e6:.4g} ({sizes.name})",
            ", ".join(f"{size:.4g}" for size in quantiles),
            cut,
        )
    return table


def _theory(material: Material, velocity: float, gas: Gas, law: str, gravity: float) -> str:
    if material.density <= gas.density:
        return "none: lighter than the gas"
    size = plug_flow_cut_size(velocity, material.density, gas, law, material.sphericity, gravity)
    text = f"{size * 1e6:.4g} ({law})"
    if not material.sizes.smallest < size < material.sizes.largest:
        text += ", outside the feed"
    return text


def _limits(case: Case, velocity: float, gas: Gas, feed: Feed) -> Table:
    table = _table("Limits", "what", "number", "what follows")
    smallest = min(feed.materials, key=lambda m: m.density * m.sizes.smallest**2)
    relaxation = smallest.density * smallest.sizes.smallest**2 / (18 * gas.viscosity)
    table.add_row(
        "shortest relaxation time", f"{relaxation:.3g} s", "drag is implicit: no limit to the step"
    )
    law, gravity = case.theory_law(), case.gravity()
    heaviest = max(feed.materials, key=lambda m: m.density * m.sizes.largest)
    if heaviest.density > gas.density:
        fall = terminal_velocity(
            heaviest.sizes.largest, heaviest.density, gas, law, heaviest.sphericity, gravity
        )
        table.add_row("fastest settling", f"{fall:.3g} m/s", f"the gas: {velocity:g} m/s")
    try:
        step = case.dictionary("system/controlDict", with_included=True).number("deltaT", above=0)
        table.add_row("first time step", f"{step:g} s", f"gas moves {step * velocity * 1e3:.3g} mm")
    except InputError:
        pass
    if feed.loading is not None:
        mean_density = 1 / sum(m.mass_fraction / m.density for m in feed.materials)
        share = feed.loading * gas.density / mean_density
        table.add_row(
            "solids by volume in the feed's gas", f"{share:.3g}",
            "contacts are rare" if share < 1e-3 else "contacts matter",
        )  # fmt: skip
        table.add_row(
            "loading", f"{feed.loading:g} kg/kg",
            "gas hardly feels the particles" if feed.loading < 0.02 else "gas feels the particles",
        )  # fmt: skip
    mean = feed.mean_particle_mass()
    diameter = (6 * mean / pi / feed.materials[0].density) ** (1 / 3)
    table.add_row(
        "mean particle", f"{mean:.3g} kg", f"as {feed.materials[0].name}: {diameter * 1e6:.3g} um"
    )
    return table
