"""The solver's own laws by libelutriaLaws.so (solver/coupling/laws, elutriaLaws.h): written once.

The library is loaded at the first call, not at import: results can be read and drawn without it.
SI units.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, Structure, byref, c_char_p, c_double, c_int, c_void_p
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elutria.errors import InputError

Array = NDArray[np.float64]

LIBRARY = "libelutriaLaws.so"
_NUMBERS = POINTER(c_double)


class _Grain(Structure):
    """elutriaGrain of elutriaLaws.h."""

    _fields_ = (
        ("density", c_double), ("sphericity", c_double), ("flatness", c_double),
        ("elongation", c_double), ("velocities", c_char_p), ("gas_density", c_double),
        ("gas_viscosity", c_double),
    )  # fmt: skip


_SIGNATURES: dict[str, tuple[Any, list[Any]]] = {
    "elutriaDragLaws": (c_char_p, []),
    "elutriaDragTitle": (c_char_p, [c_char_p]),
    "elutriaSizeLaws": (c_char_p, []),
    "elutriaSizeParameters": (c_char_p, [c_char_p]),
    "elutriaCdRe": (c_char_p, [c_char_p, *[_NUMBERS] * 4, c_int]),
    "elutriaTerminalVelocity": (
        c_char_p,
        [c_char_p, POINTER(_Grain), _NUMBERS, c_double, _NUMBERS, _NUMBERS, c_int],
    ),
    "elutriaSettlingSize": (
        c_char_p,
        [c_char_p, POINTER(_Grain), _NUMBERS, c_double, _NUMBERS, _NUMBERS, _NUMBERS, c_int],
    ),
    "elutriaEllipsoidSphericity": (c_double, [c_double, c_double]),
    "elutriaLawSizes": (
        c_char_p,
        [c_char_p, _NUMBERS, _NUMBERS, c_double, c_int, POINTER(c_void_p)],
    ),
    "elutriaSievedSizes": (
        c_char_p,
        [_NUMBERS, _NUMBERS, c_int, c_char_p, c_double, c_int, POINTER(c_void_p)],
    ),
    "elutriaSieveTable": (c_char_p, [c_char_p, c_double, c_int, POINTER(c_void_p)]),
    "elutriaMixedSizes": (
        c_char_p,
        [POINTER(c_void_p), _NUMBERS, c_int, c_int, POINTER(c_void_p)],
    ),
    "elutriaSingleSize": (c_char_p, [c_double, POINTER(c_void_p)]),
    "elutriaSizePoints": (c_int, [c_void_p]),
    "elutriaMeanCube": (c_double, [c_void_p]),
    "elutriaSizeCurves": (None, [c_void_p, *[_NUMBERS] * 3]),
    "elutriaFreeSizes": (None, [c_void_p]),
}
"""Result and arguments of each function of elutriaLaws.h."""


class LawsNotBuilt(InputError):
    """The library is not there, or not of this version."""


@cache
def _library() -> ctypes.CDLL:
    """The library of the environment, or of the clone that this package lies in."""
    clone = Path(__file__).resolve().parents[3] / "build/lib" / LIBRARY
    for place in (LIBRARY, str(clone)):
        try:
            library = ctypes.CDLL(place)
        except OSError:
            continue
        try:
            for name, (result, arguments) in _SIGNATURES.items():
                function = getattr(library, name)
                function.restype, function.argtypes = result, arguments
        except AttributeError as error:
            raise LawsNotBuilt(
                f"{LIBRARY}: is of another version ({error}); build it again: solver/Allwmake"
            ) from error
        return library
    raise LawsNotBuilt(
        f"{LIBRARY}: not found on LD_LIBRARY_PATH or in {clone.parent}; "
        "allowed: after solver/Allwmake and 'source etc/bashrc'"
    )


def _array(values: ArrayLike) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _numbers(values: Array) -> Any:
    return values.ctypes.data_as(_NUMBERS)


def _check(complaint: bytes | None) -> None:
    if complaint is not None:
        raise ValueError(complaint.decode())


def least_density() -> float:
    """Density (kg/m3) below which a material of the feed is refused."""
    return _constant("elutriaLeastDensity")


def largest_density() -> float:
    """Density (kg/m3) above which a material of the feed is refused."""
    return _constant("elutriaLargestDensity")


def largest_size() -> float:
    """Size (m) above which a feed is refused."""
    return _constant("elutriaLargestSize")


def _constant(name: str) -> float:
    return float(c_double.in_dll(_library(), name).value)


def particle_columns() -> tuple[str, ...]:
    """Columns of particles.csv and inside.csv."""
    text = c_char_p.in_dll(_library(), "elutriaParticleColumns").value
    return tuple((text or b"").decode().split(","))


def drag_laws() -> list[str]:
    """Names of the drag laws, as a case's particleForces name them."""
    names: bytes = _library().elutriaDragLaws()
    return names.decode().split()


def drag_title(force: str) -> str | None:
    """What a person calls the law of a particle force; None where no law is known."""
    title: bytes | None = _library().elutriaDragTitle(force.encode())
    return None if title is None else title.decode()


@dataclass(frozen=True)
class Grain:
    """What decides how a grain of a size falls: its density (kg/m3), and its shape, as sphericity
    or by its axes S <= I <= L (flatness S/I, elongation I/L); or its measured terminal velocities,
    the text of a csv (diameter_mm, velocity_m_s) in a gas of a density (kg/m3) and viscosity
    (Pa s).
    """

    density: float
    sphericity: float = 1.0
    flatness: float = 1.0
    elongation: float = 1.0
    velocities: str | None = None
    measured_in: tuple[float, float] = (1.2, 1.8e-5)

    def _as_argument(self) -> Any:
        text = None if self.velocities is None else self.velocities.encode()
        return byref(_Grain(self.density, self.sphericity, self.flatness, self.elongation, text,
                            *self.measured_in))  # fmt: skip


def ellipsoid_sphericity(flatness: float, elongation: float) -> float:
    """Of an ellipsoid of these axes, each above 0 and up to 1."""
    return float(_library().elutriaEllipsoidSphericity(flatness, elongation))


def drag_coefficient(
    law: str,
    reynolds: ArrayLike,
    void: ArrayLike = 1.0,
    sphericity: ArrayLike = 1.0,
    flatness: ArrayLike = 1.0,
    elongation: ArrayLike = 1.0,
    density_ratio: ArrayLike = 1000.0,
    over_mean: ArrayLike = 1.0,
) -> Array:
    """Cd at a particle Re of the interstitial slip, void fraction, shape, density over the gas, and
    size over the Sauter mean around: arrays of one shape, or numbers. Raises ValueError for a law
    that is not known."""
    given = (reynolds, void, sphericity, flatness, elongation, density_ratio, over_mean)
    shape = np.broadcast_shapes(*(np.shape(values) for values in given))
    re, alpha, *form = (
        np.ascontiguousarray(values)
        for values in np.broadcast_arrays(*(_array(values) for values in given))
    )
    forms, product = np.ascontiguousarray(np.stack(form, axis=-1)), np.empty_like(re)
    _check(
        _library().elutriaCdRe(
            law.encode(),
            *(_numbers(values) for values in (re, alpha, forms, product)),
            product.size,
        )
    )
    return np.asarray(product / re).reshape(shape)


def terminal_velocities(
    law: str, diameters: Array, grain: Grain, gas: tuple[float, float], gravity: float
) -> Array:
    """m/s, of grains of these sizes (m) in a gas (density, viscosity Pa s); 0: lighter."""
    diameters = _array(diameters)
    found = np.empty_like(diameters)
    _check(
        _library().elutriaTerminalVelocity(
            law.encode(), grain._as_argument(), _numbers(_array(gas)), gravity,
            _numbers(diameters), _numbers(found), found.size,
        )
    )  # fmt: skip
    return found


def settling_sizes(
    law: str,
    velocities: Array,
    grain: Grain,
    gas: tuple[float, float],
    gravity: float,
    limits: tuple[float, float],
) -> Array:
    """Sizes (m) between two limits whose terminal velocities these are; 0: there is none."""
    velocities = _array(velocities)
    found = np.empty_like(velocities)
    _check(
        _library().elutriaSettlingSize(
            law.encode(), grain._as_argument(), _numbers(_array(gas)), gravity,
            _numbers(_array(limits)), _numbers(velocities), _numbers(found), found.size,
        )
    )  # fmt: skip
    return found


def size_laws() -> dict[str, tuple[str, ...]]:
    """The size laws by name, and their parameters."""
    library = _library()
    names: bytes = library.elutriaSizeLaws()
    return {
        name: tuple(library.elutriaSizeParameters(name.encode()).decode().split())
        for name in names.decode().split()
    }


class Sizes:
    """A size distribution of the library; freed with this."""

    def __init__(self, make: str, *arguments: Any):
        """`make` names the function. Raises ValueError that says what is allowed."""
        self._pointer = c_void_p()
        _check(getattr(_library(), make)(*arguments, byref(self._pointer)))

    def __del__(self) -> None:
        if self._pointer:
            _library().elutriaFreeSizes(self._pointer)

    def curves(self) -> tuple[Array, Array, Array, float]:
        """Diameters (m), cumulative shares of mass and of number, number mean of d^3 (m3)."""
        library = _library()
        points = library.elutriaSizePoints(self._pointer)
        diameters, mass, number = (np.empty(points) for _ in range(3))
        library.elutriaSizeCurves(
            self._pointer, _numbers(diameters), _numbers(mass), _numbers(number)
        )
        return diameters, mass, number, float(library.elutriaMeanCube(self._pointer))

    @classmethod
    def mixed(cls, parts: list[Sizes], shares: list[float], weighting: str) -> Sizes:
        """Several at once, each with its share."""
        pointers = (c_void_p * len(parts))(*(part._pointer for part in parts))
        own = _array(shares)
        return cls("elutriaMixedSizes", pointers, _numbers(own), own.size, _by(weighting))


def law_sizes(
    law: str, parameters: list[float], low: float, high: float, weighting: str,
    most: float | None = None,
) -> Sizes:  # fmt: skip
    """Of a law between two limits, none above `most`, by default the largest size. Raises
    ValueError that says what is allowed."""
    most = largest_size() if most is None else most
    limits = _numbers(_array([low, high]))
    return Sizes(
        "elutriaLawSizes", law.encode(), _numbers(_array(parameters)), limits, most, _by(weighting)
    )


def sieved_sizes(
    diameters: list[float], finer: list[float], weighting: str, most: float | None = None,
    named: str = "diameters",
) -> Sizes:  # fmt: skip
    """Of a sieve analysis, none above `most`, by default the largest size. Raises ValueError that
    says what is allowed of what messages call `named`."""
    most = largest_size() if most is None else most
    if len(diameters) != len(finer):
        raise ValueError(f"{named}, cumulative: allowed: lists of the same length")
    at, shares = _array(diameters), _array(finer)
    return Sizes(
        "elutriaSievedSizes", _numbers(at), _numbers(shares), at.size, named.encode(), most,
        _by(weighting),
    )  # fmt: skip


def sieve_table(text: str, low: float, weighting: str) -> Sizes:
    """Of a sieve analysis as the text of a csv. Raises ValueError that says what is allowed."""
    return Sizes("elutriaSieveTable", text.encode(), low, _by(weighting))


def single_size(diameter: float) -> Sizes:
    """Of one size. Raises ValueError that says what is allowed."""
    return Sizes("elutriaSingleSize", diameter)


def _by(weighting: str) -> int:
    return int(weighting == "number")
