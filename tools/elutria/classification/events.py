"""What the solver recorded: a row per parcel that left or is still inside, and the ledger.

`particles.csv` of all `postProcessing/outlets/TIME`, `postProcessing/inside.csv` and
`postProcessing/ledger.json` must agree; a file that ends within a row, a repeated parcel or a
count that differs from the ledger's is refused: an incomplete run is never taken for complete.
"""

from __future__ import annotations

import csv
import warnings
from dataclasses import dataclass, replace
from math import inf, pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pandas.api.types import union_categoricals

from elutria import tables
from elutria.errors import InputError, one_line
from elutria.files import read_json, reading

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

INSIDE = "inside"
"""The place of what has not left, beside the products."""
OTHER = "other"
"""A product that the curve leaves out, unless it is the one that it is of."""
PLACES = ("fines", "coarse", INSIDE)
"""Where no others are named."""
_TYPES: dict[str, Any] = {
    **dict.fromkeys(tables.EVENTS, "float64"),
    "outlet": "category",
    "material": "category",
    "id": "int64",
}
_COLUMNS = ("material", "outlet", "diameter", "density", "number", "time")


@dataclass(frozen=True)
class Events:
    """Parcels as columns of one length (n,), SI units; 34 bytes a parcel.

    `material` and `outlet` are categories, given as such or as an array of names. `outlet` is a
    product, in the order of the feed, or ``inside``; `number` is how many particles a parcel stands
    for; `time` is when it entered, of joined runs one after the other. `partition_to` is the
    product whose share the partition curve is.
    """

    material: pd.Categorical
    outlet: pd.Categorical
    diameter: Array
    density: Array
    number: Array
    time: Array
    partition_to: str = "coarse"

    def __post_init__(self) -> None:
        for name, categories in (("material", None), ("outlet", list(PLACES))):
            given = getattr(self, name)
            if not isinstance(given, pd.Categorical):
                object.__setattr__(self, name, pd.Categorical(given, categories))

    @property
    def nbytes(self) -> int:
        """Memory of all columns, bytes."""
        return sum(int(getattr(self, name).nbytes) for name in _COLUMNS)

    @property
    def mass(self) -> Array:
        """Mass of each parcel, kg."""
        return self.number * self.density * pi / 6 * self.diameter**3

    @property
    def products(self) -> list[str]:
        """The products, in the order of the feed."""
        return [str(name) for name in self.outlet.categories if name != INSIDE]

    @property
    def has_left(self) -> Flags:
        """Whether each parcel left with a product that the curve counts: not with `other`."""
        counted = self.is_out & np.asarray(self.outlet != OTHER)
        return np.asarray(counted | self.is_coarse)

    @property
    def is_out(self) -> Flags:
        """Whether each parcel left, with whatever product."""
        return np.asarray(self.outlet != INSIDE)

    @property
    def is_inside(self) -> Flags:
        """Whether each parcel is inside."""
        return np.asarray(self.outlet == INSIDE)

    @property
    def is_coarse(self) -> Flags:
        """Whether each parcel left with the product whose share the partition curve is."""
        return np.asarray(self.outlet == self.partition_to)

    def __len__(self) -> int:
        return int(self.diameter.size)

    def select(self, flags: Flags) -> Events:
        """The parcels where `flags` is true."""
        return replace(self, **{name: getattr(self, name)[flags] for name in _COLUMNS})

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
        """|fed - left - inside|/fed by mass, as the ledger has it; 0 when nothing was fed."""
        left = sum(mass for _, mass in self.outlets.values())
        fed = self.injected[1]
        return abs(fed - left - self.inside[1]) / fed if fed > 0 else 0.0


DRAIN_TIME, END_TIME = "drainTime of constant/feed", "endTime of system/controlDict"


@dataclass(frozen=True)
class Run:
    """A finished run's events and its accounts by material, with ``all``; `ended_by` is the entry
    that ended it where something is inside."""

    events: Events
    accounts: dict[str, Account]
    ended_by: str = DRAIN_TIME


def join(runs: list[Run]) -> Run:
    """Replicates of one velocity, taken together."""
    parts = {name: [getattr(run.events, name) for run in runs] for name in _COLUMNS}
    parts["time"] = _one_after_the_other(parts["time"])
    first = runs[0].events
    events = replace(first, **{name: _concatenate(columns) for name, columns in parts.items()})
    names = [name for name in runs[0].accounts if all(name in run.accounts for run in runs)]
    accounts = {name: _sum([run.accounts[name] for run in runs]) for name in names}
    return Run(events, accounts, runs[0].ended_by)


def _concatenate(columns: list[Any]) -> Any:
    columns = [column for column in columns if len(column)] or columns[:1]
    if isinstance(columns[0], pd.Categorical):
        return union_categoricals(columns)
    return np.concatenate(columns)


def _one_after_the_other(times: list[Array]) -> list[Array]:
    """Times of runs, each beginning where the one before ended."""
    moved, end = [], 0.0
    for time in times:
        moved.append(time - time.min(initial=inf) + end if time.size else time)
        end = moved[-1].max(initial=end)
    return moved


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
    """Events and ledger of CASE/postProcessing. Raises InputError for what is incomplete."""
    folder = case / "postProcessing"
    ledger_file = folder / "ledger.json"
    if not ledger_file.is_file():
        raise InputError(f"{ledger_file}: file not found; allowed: a finished run of elutriaFoam")
    ledger = read_json(ledger_file)
    files = _outlet_files(folder)
    if (folder / "inside.csv").is_file():
        files.append(folder / "inside.csv")
    rows = _read_all(files)
    accounts = _read_accounts(ledger, ledger_file)
    places = [*accounts["all"].outlets, INSIDE]
    _check_rows(rows, places, folder)
    events = Events(
        material=rows["material"],
        outlet=rows["outlet"].set_categories(places),
        diameter=rows["diameter_m"],
        density=rows["density_kg_m3"],
        number=rows["n_particle"],
        time=rows["time_s"] - rows["residence_time_s"],
        partition_to=_partition_to(ledger, places[:-1], ledger_file),
    )
    _compare(events, accounts["all"], _section(ledger, "total", ledger_file), folder)
    return Run(events, accounts, _ended_by(folder, ledger))


def _ended_by(folder: Path, ledger: dict[str, Any]) -> str:
    """The drain time, or the end of the clock where that came before."""
    try:
        over = read_json(folder / "plan.json")["feed"]["run_ends_s"]
        return END_TIME if over is None or ledger["time_s"] < over * (1 - 1e-6) else DRAIN_TIME
    except (InputError, KeyError, TypeError):  # without a plan, as runs of earlier versions
        return DRAIN_TIME


def _outlet_files(folder: Path) -> list[Path]:
    found = []
    for path in (folder / "outlets").glob("*/particles.csv"):
        try:
            found.append((float(path.parent.name), path))
        except ValueError:
            raise InputError(f"{path}: folder must be named after a time") from None
    return [path for _, path in sorted(found)]


def _read_all(files: list[Path]) -> dict[str, Any]:
    """The columns that are used, of all files together, by name."""
    used = ("material", "outlet", "diameter_m", "density_kg_m3", "n_particle", "time_s", "id",
            "residence_time_s")  # fmt: skip
    empty = pd.DataFrame({name: pd.Series(dtype=_TYPES[name]) for name in tables.EVENTS})
    frames = [_read_rows(path) for path in files] or [empty]
    return {name: _concatenate([frame[name].values for frame in frames]) for name in used}


def _read_rows(path: Path) -> pd.DataFrame:
    with reading(path, limit=2_000_000_000):
        with path.open("rb") as file:
            head = file.readline(1000).decode()
            if head.strip() != ",".join(tables.EVENTS):
                raise InputError(f"{path}: first line must be {','.join(tables.EVENTS)}")
            file.seek(-1, 2)
            if file.read(1) != b"\n":
                raise InputError(f"{path}: ends within a row, the run was cut off while writing")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")  # such as a row that is too long
                return pd.read_csv(
                    path, dtype=_TYPES, index_col=False, quoting=csv.QUOTE_NONE,
                    na_filter=False, skip_blank_lines=False,
                )  # fmt: skip
        except (ValueError, Warning, OverflowError) as error:
            raise InputError(f"{path}: {one_line(error)}") from error


def _partition_to(ledger: dict[str, Any], products: list[str], file: Path) -> str:
    """The product whose share the curve is; ledgers of older runs do not say it: the last one."""
    if not products:
        raise InputError(f"{file}: total: outlets: has none; allowed: at least one product")
    named = ledger.get("partition_to", products[-1])
    if named not in products:
        raise InputError(
            f"{file}: partition_to: {one_line(named, 40)}; allowed: {', '.join(products)}"
        )
    return str(named)


def _check_rows(rows: dict[str, Any], places: list[str], folder: Path) -> None:
    for name in ("diameter_m", "density_kg_m3", "n_particle"):
        wrong = ~(np.isfinite(rows[name]) & (rows[name] > 0))
        if np.any(wrong):
            value = rows[name][wrong][0]
            raise InputError(f"{folder}: {name} is {value:g} in a row; allowed: a number > 0")
    for name in sorted(set(rows["outlet"].categories) - set(places)):
        raise InputError(
            f"{folder}: outlet is '{one_line(name, 40)}' in a row; allowed: {', '.join(places)}"
        )
    twice = pd.Index(rows["id"]).duplicated()
    if np.any(twice):
        raise InputError(f"{folder}: parcel {rows['id'][twice][0]} has more than one row")


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
                "the tables are incomplete"
            )
        found = float(np.sum(events.mass[chosen]))
        if abs(found - mass) > 1e-6 * max(mass, 1e-300):
            raise InputError(
                f"{folder}: {found:.9g} kg in the rows of {place}, but ledger.json says "
                f"{mass:.9g} kg: the tables are incomplete"
            )
