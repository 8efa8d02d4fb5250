"""Runs of which the partition curve is known."""

from __future__ import annotations

import numpy as np

from elutria.classification.curves import MODELS
from elutria.classification.events import Account, Events, Run

MATERIALS = {"quartz": (2650.0, 100e-6), "magnetite": (5200.0, 70e-6)}


def synthetic(velocity: float, materials: list[str], number: int = 2_000) -> Run:
    random = np.random.default_rng(int(velocity * 10))
    name = random.choice(materials, number)
    diameter = random.lognormal(np.log(600e-6), 0.45, number)
    cut = np.array([MATERIALS[m][1] for m in name]) * velocity
    coarse = random.random(number) < MODELS[0].share(diameter / cut, 2.0)
    events = Events(
        material=name,
        outlet=np.where(coarse, "coarse", "fines"),
        diameter=diameter,
        density=np.array([MATERIALS[m][0] for m in name]),
        number=np.ones(number),
        time=np.zeros(number),
    )
    fed = (float(number), float(events.mass.sum()))
    none = (0.0, 0.0)
    account = Account(fed, {"fines": none, "coarse": fed}, none, none)
    return Run(events, {**dict.fromkeys(materials, account), "all": account})
