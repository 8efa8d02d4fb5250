"""`elutria find`: the runs that a search asks for, as members of a sweep's folder."""

from __future__ import annotations

from math import isclose
from pathlib import Path

from elutria import tables
from elutria.case.case import VELOCITY, Case
from elutria.classification.classify import Classification, Row
from elutria.errors import ElutriaError, InputError
from elutria.files import read_csv
from elutria.running.axes import Point, number_or_word, own_value, same_value
from elutria.running.engine import local_executor
from elutria.running.find import Asked, Cut, floats_at, interval, parse_range, search
from elutria.running.results import Results
from elutria.running.sweep import Watcher, plan, run_sweep


def answer(
    case: Case,
    folder: Path,
    wanted: tuple[float, str, str | None, int],
    extra: list[str],
    np: int,
    watcher: Watcher,
) -> tuple[list[str], Classification]:
    """Lines that tell the answer to `wanted` (d50 in m, material, the setting's range, most runs),
    and the tables of the folder. Raises InputError before anything runs, ElutriaError where there
    is no answer."""
    asked = _asked(case, *wanted)
    results = Results(case, folder, extra)
    plan(case, folder, [_point(case, asked.name, asked.low)], 1, extra)
    made = Classification()

    def run(value: float) -> Cut:
        nonlocal made
        point = _point(case, asked.name, value)
        with local_executor(1) as executor:
            done = run_sweep(results, plan(case, folder, [point], 1, extra), executor, np, watcher)
        if done.failures:
            raise ElutriaError("; ".join(f"{k}: {v}" for k, v in done.failures.items()))
        made = done.tables
        rows = [row for row in made.summary if _is(_value(row, asked, case), value)]
        return next(_cut(row, value) for row in rows if row["material"] == asked.material)

    known = _known(folder, asked, case) if results.before else []
    best, cuts = search(asked, known, run, case)
    if not made.summary:
        made, *_ = results.write_tables({})
    value, low, high = interval(asked, cuts, best, case)
    unit = "m/s" if asked.name == VELOCITY else asked.name
    return [
        f"d50 {asked.d50 * 1e6:.4g} um at {value:.4g} {unit} (95 %: {low:.4g} to {high:.4g}); "
        f"{len(cuts) - len(known)} runs were made, {len(known)} were there",
    ], made


def _asked(case: Case, d50: float, material: str, vary: str | None, most_runs: int) -> Asked:
    materials = [m.name for m in case.feed().materials]
    if material not in (*materials, "all"):
        raise InputError(f"--material {material}; allowed: all, {', '.join(materials)}")
    if vary is not None:
        return Asked(d50, *parse_range(case, vary), material, most_runs=most_runs)
    checked = Asked(d50, VELOCITY, 1, 2, material, most_runs=most_runs)
    near = floats_at(case, checked.d50, material)
    return Asked(d50, VELOCITY, near / 5, near * 5, material, most_runs=most_runs)


def _point(case: Case, name: str, value: float) -> Point:
    if name == VELOCITY:
        return Point(float(f"{value:.12g}"))
    text = f"{value:.12g}"
    same = same_value(text, own_value(case, name))
    return Point(case.velocity(), () if same else ((name, text),))


def _value(row: Row, asked: Asked, case: Case) -> float | str | None:
    """The value of the asked setting in a row; None where another setting is not the case's."""
    for name in tables.axes([row]):
        if name != asked.name and row[name] != number_or_word(own_value(case, name)):
            return None
    if asked.name == VELOCITY:
        return float(row[tables.VELOCITY])
    if row[tables.VELOCITY] != case.velocity():
        return None
    own = number_or_word(own_value(case, asked.name))
    value: float | str = row.get(asked.name, own)
    return value


def _is(found: float | str | None, value: float) -> bool:
    """Whether a table's value is this one, in the digits that a table has."""
    return isinstance(found, float) and isclose(found, value, rel_tol=1e-8)


def _cut(row: Row, value: float) -> Cut:
    return Cut(value, row["d50_m"], row["d50_low_m"], row["d50_high_m"])


def _known(folder: Path, asked: Asked, case: Case) -> list[Cut]:
    """Runs of the folder that answer too."""
    file = folder / "summary.csv"
    rows = read_csv(file, tables.FIRST) if file.is_file() else []
    found = [(row, _value(row, asked, case)) for row in rows if row["material"] == asked.material]
    return [
        _cut(row, value)
        for row, value in found
        if isinstance(value, float) and asked.low <= value <= asked.high
    ]
