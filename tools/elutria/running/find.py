"""One setting for one cut size: the inverse question, with as few runs as it takes.

The first guess is the theory's (a gas velocity: that at which the size just floats); a second
scales with it. From two runs on, a power law through those nearest to the answer tells where to go
on, kept within the bracket once there is one. It ends when the asked size lies within the 95 %
interval of a run's d50, or is met to `within`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from math import exp, isfinite, log, sqrt

from elutria.case.case import VELOCITY, Case
from elutria.errors import ElutriaError, InputError, one_line
from elutria.physics.drag import terminal_velocity
from elutria.running.axes import own_value

MOST_RUNS = 12


@dataclass(frozen=True)
class Asked:
    """The cut size (m) that is asked for, and the setting (FILE:ENTRY) with its limits, > 0."""

    d50: float
    name: str
    low: float
    high: float
    material: str = "all"
    within: float = 0.002
    most_runs: int = MOST_RUNS

    def __post_init__(self) -> None:
        if not (isfinite(self.d50) and 1e-7 < self.d50 < 1):
            raise InputError(f"--d50 {self.d50:g}; allowed: a size in m, such as 500e-6")
        if self.most_runs < 1:
            raise InputError(f"--most-runs {self.most_runs}; allowed: a whole number >= 1")


@dataclass(frozen=True)
class Cut:
    """A run's value of the setting, and its cut size with the 95 % interval (m)."""

    value: float
    d50: float
    low: float
    high: float

    def meets(self, asked: Asked) -> bool:
        """Whether the asked size is this run's, as far as it knows."""
        return self.low <= asked.d50 <= self.high or abs(self.d50 / asked.d50 - 1) <= asked.within


def parse_range(case: Case, text: str) -> tuple[str, float, float]:
    """FILE:ENTRY and its limits from `FILE:ENTRY=A:B`, A and B numbers with 0 < A < B."""
    name, _, limits = text.partition("=")
    try:
        low, high = (float(part) for part in limits.split(":"))
        if not (0 < low < high and isfinite(high)):
            raise ValueError
    except ValueError:
        raise InputError(
            f"--vary '{one_line(text, 80)}'; allowed: FILE:ENTRY=A:B with 0 < A < B, such as "
            f"{VELOCITY}=3:9"
        ) from None
    own = own_value(case, name.strip())
    try:
        float(own)
    except ValueError:
        raise InputError(f"--vary {name}: is '{own}'; allowed: an entry that is a number") from None
    return name.strip(), low, high


def floats_at(case: Case, size: float, material: str) -> float:
    """Gas velocity (m/s) at which a particle of `size` (m) floats: of `material`, or the first."""
    gas, law, gravity = case.gas(), case.theory_law(), case.gravity()
    materials = case.feed().materials
    one = next((m for m in materials if m.name == material), materials[0])
    if one.grain.density <= gas.density:
        raise InputError(f"constant/feed: materials/{one.name} is not denser than the gas")
    return terminal_velocity(size, case.grain(one), gas, law, gravity)


def search(
    asked: Asked, known: Iterable[Cut], run: Callable[[float], Cut], case: Case
) -> tuple[Cut, list[Cut]]:
    """The run that meets what is asked, and all of them. `known` runs are not run again.

    Raises ElutriaError where no value within the limits does.
    """
    cuts = sorted(known, key=lambda cut: cut.value)
    for runs in range(asked.most_runs + 1):
        met = [cut for cut in cuts if cut.meets(asked)]
        if met:
            return min(met, key=lambda cut: abs(log(cut.d50 / asked.d50))), cuts
        tries = [_next(asked, cuts, case), asked.low, asked.high]
        value = next((v for v in tries if all(abs(v / c.value - 1) > 1e-4 for c in cuts)), None)
        if value is None or runs == asked.most_runs:
            break
        cuts = sorted([*cuts, run(value)], key=lambda cut: cut.value)
    told = ", ".join(f"{cut.value:g}: {cut.d50 * 1e6:.4g} um" for cut in cuts)
    raise ElutriaError(
        f"no value of {asked.name} from {asked.low:g} to {asked.high:g} was found with a d50 of "
        f"{asked.d50 * 1e6:g} um ({told})"
    )


def _next(asked: Asked, cuts: list[Cut], case: Case) -> float:
    """Where to run next."""
    good = [cut for cut in cuts if isfinite(cut.d50)]
    if not good:
        guess = sqrt(asked.low * asked.high)
        if asked.name == VELOCITY and not cuts:
            guess = floats_at(case, asked.d50, asked.material)
        return _kept(guess, asked.low, asked.high)
    if len(good) == 1:
        return _kept(_second(asked, good[0], case), asked.low, asked.high)
    for one, other in pairwise(good):
        if (one.d50 - asked.d50) * (other.d50 - asked.d50) < 0:
            inner = (other.value / one.value) ** 0.05
            return _kept(_between(asked, one, other), one.value * inner, other.value / inner)
    nearest = sorted(good, key=lambda cut: abs(log(cut.d50 / asked.d50)))[:2]
    return _kept(_between(asked, *nearest), asked.low, asked.high)


def _second(asked: Asked, only: Cut, case: Case) -> float:
    """From one run: as the theory scales, or towards the farther limit."""
    if asked.name == VELOCITY:
        ratio = floats_at(case, asked.d50, asked.material)
        return only.value * ratio / floats_at(case, only.d50, asked.material)
    low_is_farther = only.value / asked.low > asked.high / only.value
    return sqrt(only.value * (asked.low if low_is_farther else asked.high))


def _between(asked: Asked, one: Cut, other: Cut) -> float:
    """On the power law through two runs."""
    slope = log(other.value / one.value) / (log(other.d50 / one.d50) or 1e-12)
    step = slope * log(asked.d50 / one.d50)
    return one.value * exp(min(max(step, -3.0), 3.0))


def _kept(value: float, low: float, high: float) -> float:
    """Within limits, in as many digits as a setting has."""
    return min(max(float(f"{value:.4g}"), low), high)


def interval(asked: Asked, cuts: list[Cut], answer: Cut, case: Case) -> tuple[float, float, float]:
    """The setting that has the asked size, and its 95 % interval: that of the run's d50 along the
    power law through the two runs nearest to it (of a single one, along the theory's)."""
    slope = _slope(asked, cuts, answer, case)
    value, low, high = (
        answer.value * (asked.d50 / size) ** slope if isfinite(size) and size > 0 else float("nan")
        for size in (answer.d50, answer.low, answer.high)
    )
    return value, min(low, high), max(low, high)


def _slope(asked: Asked, cuts: list[Cut], answer: Cut, case: Case) -> float:
    """How the setting goes with the cut size: the power of the one that the other is."""
    others = [cut for cut in cuts if cut is not answer and isfinite(cut.d50)]
    if others:
        near = min(others, key=lambda cut: abs(log(cut.value / answer.value)))
        return log(near.value / answer.value) / (log(near.d50 / answer.d50) or 1e-12)
    if asked.name == VELOCITY:
        one, other = (floats_at(case, size * asked.d50, asked.material) for size in (0.99, 1.01))
        return log(other / one) / log(1.01 / 0.99)
    return 0.0  # one run of another setting: that it met the size is all that is known
