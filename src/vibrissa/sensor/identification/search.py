"""One fit of set-up and contact points to all recorded channels, with tolerances as priors.

The parameters p minimise χ²(p) + Σ (p/σ)², where σ are the tolerances. For each p every period has
its best u(p), where u is x0 in the last sample of the period (variable projection: Golub and
Pereyra, 1973). The steps are those of Gauss and Newton. Derivatives by p need further rods solved,
so that several steps use the same ones: they are computed anew where such steps have settled.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from vibrissa.errors import NoResponseError
from vibrissa.sensor.identification.fit import Fit
from vibrissa.sensor.identification.fitted_set_up import FittedSetUp
from vibrissa.sensor.identification.forward import forward_models
from vibrissa.sensor.identification.linearisation import Linearisation

# Number of Gauss-Newton steps by which u is fitted, from its first-order change.
CONTACT_STEPS = 2
# Relative fall of the sum at which the fit ends.
SETTLED = 1e-5
# Largest number of steps.
MOST_STEPS = 20
# Number of lengths that are tried for a step, each half of the one before.
HALVINGS = 6
# Change of χ² that is rounding: readings without noise fit as well as that.
ROUNDED_CHI2 = 1e-10
# If less than this part of the periods does not fit, these are left out of the fit.
MOST_ALONE = 0.5


def fit_set_up(start: Fit) -> FittedSetUp:
    """Fit the set-up; leave out periods that do not fit by themselves, if fewer than half.

    Raises
    ------
    NoResponseError
        If a rod near to the given one has no response.
    """
    line = Linearisation.of(start)
    fitted = _searched(line)
    alone = ~fitted.fits_alone
    if not alone.any() or alone.mean() >= MOST_ALONE:
        return fitted
    return _searched(line.keeping(~alone))


def _searched(start: Linearisation) -> FittedSetUp:
    """Fit the set-up; return the given set-up if the steps do not settle."""
    best = start.at
    line = start
    fresh = True
    if not best.task.free.any():
        return FittedSetUp(fit=best, line=line, settled=True)
    for _ in range(MOST_STEPS):
        before = line.total(best)
        better = _better(best, line)
        small = better is None or before - line.total(better) < SETTLED * before + ROUNDED_CHI2
        if better is not None:
            best = better
        if small and fresh:
            if better is None:
                break
            return FittedSetUp(fit=best, line=line, settled=True)
        fresh = small
        if small:
            try:
                line = Linearisation.of(best)
            except NoResponseError:
                break
    return FittedSetUp(fit=start.at, line=start, settled=False)


def _better(fit: Fit, line: Linearisation) -> Fit | None:
    """Take a Gauss-Newton step within the bounds, or a part of it, that does not raise the sum.

    Return None if there is no such step. (`scipy.optimize.least_squares` zigzags along bounds such
    as c ≥ 0.)
    """
    low, high = fit.bounds
    root = np.linalg.cholesky(line.normal).T
    aim = -np.linalg.solve(root.T, line.gradient(fit))
    within = (low - fit.scores, high - fit.scores)
    step = lsq_linear(root, aim, within, method="bvls").x
    free = fit.task.free
    sigma = fit.task.sigma
    most = line.total(fit) * (1.0 + SETTLED) + ROUNDED_CHI2
    for part in 0.5 ** np.arange(HALVINGS):
        p = fit.p.copy()
        p[free] = sigma[free] * np.clip(fit.scores + part * step, low, high)
        try:
            (model,) = forward_models(fit.task, fit.model.given, p)
        except NoResponseError:
            continue
        u = fit.u + line.u @ (p - fit.p)
        other = replace(fit, model=model, u=u).with_contacts(CONTACT_STEPS)
        if line.total(other) <= most:
            return other
    return None
