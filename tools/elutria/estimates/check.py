"""What the solver understood of a case, expects of it and plans for it, as tables.

The solver reads the case and decides (`elutriaFoam -plan`); here its answer is shown. Of the text
only spelling and ranges are looked at before, which the user is told of sooner and with a hint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

if TYPE_CHECKING:
    from elutria.case.case import Case

BASES = {
    "inlet": "what flows in",
    "settled": "the gas, settled without particles",
    "start": "the fields that the run starts from",
}
"""Where the gas velocity of the estimates is from, by the plan's `gas/basis`."""


def check_text(case: Case) -> None:
    """Raise InputError for the first entry of the case's files that cannot be right."""
    case.check_mesh()
    case.velocity()
    case.feed()
    case.gas()
    case.gravity()
    case.cloud().sub("subModels").sub("particleForces")
    control = case.dictionary("system/controlDict", with_included=True)
    control.number("deltaT", above=0, at_most=1e6, unit="s")
    control.number("writeInterval", 1.0, above=0)  # OpenFOAM's programs divide by it


def report(name: str, velocity: float, plan: dict[str, Any], keeps_mesh: bool) -> list[Table]:
    """Tables for the terminal, of the solver's plan of a case with a gas velocity (m/s)."""
    return [
        _setting(name, velocity, plan, keeps_mesh),
        _materials(plan),
        _limits(plan),
        _expected(plan),
        _decisions(plan),
    ]


def _table(title: str, *columns: str) -> Table:
    table = Table(
        title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False, collapse_padding=True
    )
    for column in columns:
        table.add_column(column, overflow="fold")
    return table


def _round(value: float) -> str:
    """A number to three digits, in full where it is one that people read so."""
    return f"{float(f'{value:.3g}'):.15g}" if 1e3 <= value < 1e7 else f"{value:.3g}"


def _known(value: float | None, text: str) -> str:
    """`text` with the value in it, or that it is not known."""
    return "known when the gas flows" if value is None else text.format(value)


def _setting(name: str, velocity: float, plan: dict[str, Any], keeps_mesh: bool) -> Table:
    table = _table(f"{name}: what was understood", "what", "value", "from")
    gas, feed = plan["gas"], plan["feed"]
    table.add_row("gas velocity", f"{velocity:g} m/s", "system/simulationParameters")
    table.add_row(
        "gas", f"{gas['density_kg_m3']:g} kg/m3, {gas['viscosity_pa_s']:.3g} Pa s",
        "constant/transportProperties",
    )  # fmt: skip
    table.add_row("gravity", f"{plan['gravity_m_s2']:g} m/s2", "constant/g")
    forces = ", ".join(plan["drag"]["forces"]) or "none"
    table.add_row("drag", forces, "the cloud's particleForces")
    table.add_row("fed through", feed["through"], "constant/feed")
    for outlet in feed["outlets"]:
        patches = ", ".join(outlet["patches"])
        table.add_row(f"{outlet['product']} leave through", patches, "constant/feed")
    patches = ", ".join(f"{patch['name']} ({patch['type']})" for patch in plan["mesh"]["patches"])
    origin = "constant/polyMesh, as it is" if keeps_mesh else "the mesh"
    table.add_row("patches", patches, origin)
    rate = feed["rate_kg_s"]
    grams = _known(None if rate is None else 1e3 * rate, "{:.3g} g/s")
    if feed["rate_times"] is not None:
        peak = 1e3 * feed["peak_rate_kg_s"]
        grams += f" on average, by a table of {feed['rate_times']:.0f} times, up to {peak:.3g} g/s"
    table.add_row("feed", grams, "constant/feed")
    if rate is not None:
        table.add_row(
            "", f"{_round(feed['particles_per_s'])} particles per s, "
            f"{feed['particles_per_parcel']:.3g} a parcel on average", "",
        )  # fmt: skip
    until = "" if feed["end_s"] is None else f" to {feed['end_s']:g} s"
    table.add_row("fed", f"from {feed['start_s']:g} s{until}", "constant/feed")
    if feed["parcels"] is not None:
        fed, asked = feed["parcels"], feed["parcels_asked"]
        follows = ""
        if asked is None:
            follows = " (as many as the duration has)"
        elif fed > asked:
            follows = " (more than asked for, to collide as particles do)"
        elif fed < asked:
            follows = f" (fewer than the {asked:.0f} asked for: duration ends before)"
        table.add_row("parcels", f"{fed:.0f}{follows}", "constant/feed")
    table.add_row("seed", f"{feed['seed']:.0f}", "constant/feed")
    return table


def _materials(plan: dict[str, Any]) -> Table:
    table = _table(
        f"Materials, and the cut where terminal velocity = gas velocity ({plan['drag']['law']})",
        "material", "kg/m3", "sphericity", "mass share", "sizes um", "d10 d50 d90 um", "cut um",
    )  # fmt: skip
    for material in plan["feed"]["materials"]:
        um = {name: material[f"{name}_m"] for name in ("smallest", "largest", "cut")}
        um = {name: None if size is None else size * 1e6 for name, size in um.items()}
        quantiles = [material[f"{name}_m"] * 1e6 for name in ("d10", "d50", "d90")]
        table.add_row(
            material["name"],
            _density(material),
            f"{material['sphericity']:g}",
            f"{material['mass_fraction']:g}",
            f"{um['smallest']:.4g}..{um['largest']:.4g}",
            " ".join(f"{size:.4g}" for size in quantiles),
            _cut(um["cut"], um["smallest"] or 0.0, um["largest"] or 0.0),
        )
    return table


def _density(material: dict[str, Any]) -> str:
    """The density, and below it its range where it scatters."""
    mean, least, largest = (
        f"{material[f'{kind}density_kg_m3']:.5g}" for kind in ("", "least_", "largest_")
    )
    return mean if least == largest else f"{mean}\n{least}..\n{largest}"


def _cut(size: float | None, smallest: float, largest: float) -> str:
    if size is None:
        return "none"
    return f"{size:.4g}" + ("" if smallest < size < largest else ", outside the feed")


def _limits(plan: dict[str, Any]) -> Table:
    table = _table("Limits", "what", "number", "what follows")
    mesh, step, expected = plan["mesh"], plan["step"], plan["expected"]
    small, large = mesh["smallest_cell_m"], mesh["largest_cell_m"]
    ends = dict.fromkeys(f"{size * 1e3:.3g}" for size in (small, large))
    table.add_row("cells", f"{mesh['cells']:.0f}", f"{' .. '.join(ends)} mm")
    share = max(material["largest_m"] for material in plan["feed"]["materials"]) / small
    follows = "void fraction is spread over a kernel" if share > 0.3 else "a cell holds several"
    table.add_row("largest particle over cell", f"{share:.2g}", follows)
    adapts = step["largest_courant"]
    courant = f"Courant {step['courant']:.2g}"
    courant += "" if adapts is None else f", adapted to {adapts:g} (maxCo)"
    table.add_row("first time step", f"{step['first_s']:g} s", courant)
    shortest, longest = expected["shortest_relaxation_s"], expected["longest_relaxation_s"]
    table.add_row(
        "relaxation times", f"{shortest:.2g} .. {longest:.2g} s",
        "drag is integrated exactly: no limit to the step",
    )  # fmt: skip
    table.add_row(
        "fastest settling", f"{expected['fastest_settling_m_s']:.3g} m/s",
        "the gas: " + _known(plan["gas"]["superficial_m_s"], "{:.3g} m/s"),
    )  # fmt: skip
    return table


def _expected(plan: dict[str, Any]) -> Table:
    """Orders of magnitude, and what each of them decides."""
    gas, expected = plan["gas"], plan["expected"]
    table = _table(
        f"Expected (estimates from {BASES[gas['basis']]})", "what", "number", "what follows"
    )
    table.add_row(
        "loading", _known(expected["loading"], "{:.3g} kg solids per kg gas"), "",
    )  # fmt: skip
    inside = expected["particles_inside"]
    number = "" if inside is None else _round(inside)
    time = _known(gas["through_time_s"], "{:.2g} s each")
    table.add_row("particles inside", _known(inside, number), time)
    solids = expected["solid_fraction"]
    dense = solids is not None and solids >= 1e-3
    table.add_row(
        "solids by volume", _known(solids, "{:.3g}"),
        "drag feels the neighbours" if dense else "drag of single particles",
    )  # fmt: skip
    table.add_row(
        "collisions of a particle", _known(expected["collisions"], "{:.3g}"),
        "flights are exact between them; steps of a contact only where it lasts",
    )  # fmt: skip
    change, tolerance = expected["gas_change"], gas["changes_at"]
    rests = change is not None and change < tolerance
    table.add_row(
        "particles slow the gas by", _known(None if change is None else 100 * change, "{:.2g} %"),
        "gas rests after it has settled (one-way)" if rests
        else f"gas is solved again after each change of {100 * tolerance:g} %",
    )  # fmt: skip
    return table


def _decisions(plan: dict[str, Any]) -> Table:
    table = _table("The solver's plan", "what", "decision", "why")
    for row in plan["decisions"]:
        table.add_row(*row)
    for warning in plan["warnings"]:
        table.add_row("warning", "", warning)
    return table
