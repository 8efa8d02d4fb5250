"""How far partition curves are off the formulas of two parameters: the prior of the misfit.

Fitted to the converged curves of the default column at two velocities, judged on the dense one: the
root-mean-square of the logit's residuals at the knots.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_expit, logit

from elutria.classification.curves import MODELS, Model
from elutria.classification.misfit import KNOTS, PRIOR
from elutria_validation.benchmarks.accuracy_error import Cut
from elutria_validation.benchmarks.accuracy_reference import kept, read
from elutria_validation.benchmarks.accuracy_runs import DENSE, FAST, SLOW
from elutria_validation.fits.constants import Constant, Fit

Array = NDArray[np.float64]


def nearest(cut: Cut) -> tuple[Model, Array]:
    """The likeliest formula of two parameters beside a curve, and its ln d50 and ln s."""
    at, share = np.log(cut.diameter), np.clip(cut.share, 1e-9, 1 - 1e-9)

    def lack(p: Array, model: Model) -> float:
        line = model.logit(at - p[0], p[1])[0]
        return -float(np.mean(share * log_expit(line) + (1 - share) * log_expit(-line)))

    found = []
    for model in MODELS:
        start = [np.log(cut.d50), model.start(-np.log(cut.sharpness))]
        best = minimize(lack, start, (model,), method="Nelder-Mead", options={"xatol": 1e-7})
        found.append((float(best.fun), model, np.asarray(best.x)))
    _, model, p = min(found, key=lambda one: one[0])
    return model, p


def residuals(cut: Cut) -> Array:
    """Of the logit, at the knots that lie where the curve is known."""
    model, p = nearest(cut)
    at = p[0] + np.array([model.log_x_at(share, float(p[1])) for share in KNOTS])
    inside = (at > np.log(cut.diameter[0])) & (at < np.log(cut.diameter[-1]))
    return np.asarray(logit(cut.at(np.exp(at[inside]))) - logit(np.array(KNOTS)[inside]))


def fit() -> Fit:
    """The prior's standard deviation."""
    table, _ = read(kept())
    known = np.concatenate([residuals(table[scene.name].cut) for scene in (SLOW, FAST)])
    other = residuals(table[DENSE.name].cut)
    prior = float(np.sqrt(np.mean(known**2)))
    return Fit(
        "Prior of the misfit",
        "misfit.py",
        (Constant("standard deviation of the logit at a knot", f"PRIOR = {PRIOR:g}", prior),),
        f"rms of the logit's residuals at {known.size} knots, over the prior",
        float(np.sqrt(np.mean(known**2))) / PRIOR,
        float(np.sqrt(np.mean(other**2))) / PRIOR,
        1.0,
        "A prior above the residuals widens intervals more than it must: that is the safe side.",
    )
