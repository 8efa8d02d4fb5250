"""What the solver recorded: a row per parcel that left or is still inside, and the ledger.

`particles.csv` of all `postProcessing/outlets/TIME`, `postProcessing/inside.csv` and
`postProcessing/ledger.json` must agree; a file that ends within a row, a repeated parcel or a
count that differs from the ledger's is refused, so that half a run is never taken for a whole one.
"""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elutria.errors import InputError, one_line
from elutria.files import read_json, read_text

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

COLUMNS = (
    "time_s", "outlet", "material", "id", "diameter_m", "density_kg_m3", "n_particle",
    "ux_m_s", "uy_m_s", "uz_m_s", "residence_time_s",
)  # fmt: skip
_DTYPE = [
    (name, "U64" if name in ("outlet", "material") else "i8" if name == "id" else "f8")
    for name in COLUMNS
]
PRODUCTS = ("fines", "coarse")


@dataclass(frozen=True)
class Events:
    """Parcels as arrays of one length: material and outlet by name, SI units.

    `outlet` is ``fines``, ``coarse`` or ``inside``; `number` is how many particles a parcel is.
    """

    material: NDArray[np.str_]
    outlet: NDArray[np.str_]
    diameter: Array
    density: Array
    number: Array
    time: Array

    @property
    def mass(self) -> Array:
        """Mass of each parcel, kg."""
        return self.number * self.density * pi / 6 * self.diameter**3

    @property
    def has_left(self) -> Flags:
        """Whether each parcel left (is not inside)."""
        return np.asarray(self.outlet != "inside")

    @property
    def is_coarse(self) -> Flags:
        """Whether each parcel left with the coarse product."""
        return np.asarray(self.outlet == "coarse")

    def __len__(self) -> int:
        return int(self.diameter.size)

    def select(self, flags: Flags) -> Events:
        """The parcels where `flags` is true."""
        return Events(**{name: values[flags] for name, values in vars(self).items()})

    def of_material(self, name: str) -> Events:
        """The parcels of a material; all of them for ``all``."""
        return self if name == "all" else self.select(self.material == name)


@dataclass(frozen=True)
class Account:
    """Number of particles and mass (kg) of one kind: injected, outlets, inside, lost."""

    injected: tuple[float, float]
    outlets: dict[str, tuple[float, float]]
    inside: tuple[float, float]
    lost: tuple[float, float]

    @property
    def mass_closure_error(self) -> float:
        """(fed - left - inside - lost)/fed by mass; 0 when nothing was fed."""
        left = sum(mass for _, mass in self.outlets.values())
        fed = self.injected[1]
        return (fed - left - self.inside[1] - self.lost[1]) / fed if fed > 0 else 0.0


@dataclass(frozen=True)
class Run:
    """A finished run's events and its accounts by material, with ``all``."""

    events: Events
    accounts: dict[str, Account]


def join(runs: list[Run]) -> Run:
    """Replicates of one velocity, taken together."""
    events = Events(
        **{
            name: np.concatenate([getattr(run.events, name) for run in runs])
            for name in vars(runs[0].events)
        }
    )
    names = [name for name in runs[0].accounts if all(name in run.accounts for run in runs)]
    return Run(events, {name: _sum([run.accounts[name] for run in runs]) for name in names})


def _sum(accounts: list[Account]) -> Account:
    def total(pairs: list[tuple[float, float]]) -> tuple[float, float]:
        return sum(pair[0] for pair in pairs), sum(pair[1] for pair in pairs)

    return Account(
        total([account.injected for account in accounts]),
        {
            product: total([account.outlets.get(product, (0.0, 0.0)) for account in accounts])
            for product in accounts[0].outlets
        },
        total([account.inside for account in accounts]),
        total([account.lost for account in accounts]),
    )


def read_run(case: Path) -> Run:
    """Events and ledger of CASE/postProcessing. Raises InputError for what is not whole."""
    folder = case / "postProcessing"
    ledger_file = folder / "ledger.json"
    if not ledger_file.is_file():
        raise InputError(f"{ledger_file}: file not found; allowed: a finished run of elutriaFoam")
    ledger = read_json(ledger_file)
    tables = [_read_rows(path) for path in _outlet_files(folder)]
    inside = folder / "inside.csv"
    if inside.is_file():
        tables.append(_read_rows(inside))
    rows = np.concatenate(tables) if tables else np.zeros(0, dtype=_DTYPE)
    _check_rows(rows, folder)
    events = Events(
        material=rows["material"],
        outlet=rows["outlet"],
        diameter=rows["diameter_m"],
        density=rows["density_kg_m3"],
        number=rows["n_particle"],
        time=rows["time_s"],
    )
    accounts = _read_accounts(ledger, ledger_file)
    _compare(events, accounts["all"], _section(ledger, "total", ledger_file), folder)
    return Run(events, accounts)


def _outlet_files(folder: Path) -> list[Path]:
    found = []
    for path in (folder / "outlets").glob("*/particles.csv"):
        try:
            found.append((float(path.parent.name), path))
        except ValueError:
            raise InputError(f"{path}: folder must be named after a time") from None
    return [path for _, path in sorted(found)]


def _read_rows(path: Path) -> NDArray[Any]:
    text = read_text(path, limit=2_000_000_000)
    head, _, body = text.partition("\n")
    if head.strip() != ",".join(COLUMNS):
        raise InputError(f"{path}: first line must be {','.join(COLUMNS)}")
    if not text.endswith("\n"):
        raise InputError(f"{path}: ends within a row, the run was cut off while writing")
    if not body:
        return np.zeros(0, dtype=_DTYPE)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return np.loadtxt(
                io.StringIO(body), delimiter=",", dtype=_DTYPE, comments=None, ndmin=1
            )
    except (ValueError, UserWarning, OverflowError) as error:
        raise InputError(f"{path}: {one_line(error)}") from error


def _check_rows(rows: NDArray[Any], folder: Path) -> None:
    for name in ("diameter_m", "density_kg_m3", "n_particle"):
        wrong = ~(np.isfinite(rows[name]) & (rows[name] > 0))
        if np.any(wrong):
            value = rows[name][wrong][0]
            raise InputError(f"{folder}: {name} is {value:g} in a row; allowed: a number > 0")
    known = np.isin(rows["outlet"], (*PRODUCTS, "inside"))
    if not np.all(known):
        name = one_line(rows["outlet"][~known][0], 40)
        raise InputError(f"{folder}: outlet is '{name}' in a row; allowed: fines, coarse, inside")
    ids, counts = np.unique(rows["id"], return_counts=True)
    if np.any(counts > 1):
        raise InputError(f"{folder}: parcel {ids[counts > 1][0]} has more than one row")


def _section(ledger: dict[str, Any], name: str, file: Path) -> dict[str, Any]:
    section = ledger.get(name)
    if not isinstance(section, dict):
        raise InputError(f"{file}: {name}: must be an object")
    return section


def _read_accounts(ledger: dict[str, Any], file: Path) -> dict[str, Account]:
    materials = _section(ledger, "materials", file)
    accounts = {name: _account(_section(materials, name, file), file, name) for name in materials}
    return {**accounts, "all": _account(_section(ledger, "total", file), file, "total")}


def _account(section: dict[str, Any], file: Path, name: str) -> Account:
    def pair(entry: Any) -> tuple[float, float]:
        return float(entry["number"]), float(entry["mass_kg"])

    try:
        account = Account(
            pair(section["injected"]),
            {product: pair(entry) for product, entry in section["outlets"].items()},
            pair(section["inside"]),
            pair(section["lost"]),
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"{file}: {name}: {one_line(error)}; allowed: injected, outlets, inside and lost, "
            "each with number and mass_kg"
        ) from error
    values = [account.injected, account.inside, account.lost, *account.outlets.values()]
    if not np.all(np.isfinite(values)):
        raise InputError(f"{file}: {name}: holds a number that is not finite")
    return account


def _compare(events: Events, account: Account, total: dict[str, Any], folder: Path) -> None:
    """Refuse tables that do not hold what the ledger says."""
    places = {**account.outlets, "inside": account.inside}
    entries = {**total["outlets"], "inside": total["inside"]}
    for place, (_, mass) in places.items():
        chosen = events.outlet == place
        rows = int(np.sum(chosen))
        parcels = entries[place].get("parcels", rows)
        if rows != parcels:
            raise InputError(
                f"{folder}: {rows} rows of {place}, but ledger.json counts {parcels} parcels: "
                "the tables are not whole"
            )
        found = float(np.sum(events.mass[chosen]))
        if abs(found - mass) > 1e-6 * max(mass, 1e-300):
            raise InputError(
                f"{folder}: {found:.9g} kg in the rows of {place}, but ledger.json says "
                f"{mass:.9g} kg: the tables are not whole"
            )
