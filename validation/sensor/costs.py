"""Effect of each tolerance on the uncertainty of μ0, before and after adjustment to a recording.

A steel rod of 0.8 mm x 100 mm, θ = 2 at 85 mm, scans 60 mm of a surface of friction 0.30 in steps
of 20 µm; the noise is 3 mN and 10 µN·m. With the default tolerances,

- before: the error of μ0 for an error of one standard deviation, without adjustment;
- after: the square root of the amount by which the variance that all periods share would fall if
  the parameter were known exactly.
"""

import argparse
from dataclasses import dataclass

import numpy as np

from validation.records import write_record
from vibrissa.scanning import surfaces
from vibrissa.sensor import Recording, Setup, identify, scan
from vibrissa.sensor.tolerances import assumed_tolerances, displayed
from vibrissa.wording import markdown_table

NOISE = "3 mN, 3 mN, 10 uN*m"
STEEL = {"modulus": "210 GPa", "diameter": "0.8 mm", "length": "100 mm"}
ROD = {"theta": 2, "eta": "85 mm", "noise": NOISE, **STEEL}
WHISKER = Setup.read(**ROD).whisker
# Smaller effects are shown as a dash.
LEAST = 1e-5


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Effect of a tolerance on μ0.

    Attributes
    ----------
    before, after : float
        Standard deviations of μ0, as the module's docstring defines them.
    """

    before: float
    after: float


def recording():
    """Simulate readings without noise, which are evaluated as if they had noise."""
    signals = scan(
        WHISKER,
        surfaces.constant(0.3),
        step="20 um",
        to=["60 mm"],
        law="kinetic",
        kinetic_ratio=0.8,
    )
    truth = signals.truth
    return Recording(clamp=truth.clamp, readings=truth.reactions, line=np.arange(len(truth)) + 2)


def costs(readings, stated=None):
    """Return the effect of each tolerance, and of all together; `stated` replaces defaults."""
    found = identify(Setup.read(**ROD, tolerances=stated), readings)
    known = np.isfinite(found.periods.mu0)
    effects, covariance = found.periods.effects[known], found.covariance
    names = np.array([one.parameter.of for one in found.estimates])
    given = np.array([one.parameter.deviation for one in found.estimates])
    found_costs = {}
    for name in dict.fromkeys(names):
        own = names == name
        shared = effects @ covariance[:, own]
        inside = np.linalg.pinv(covariance[np.ix_(own, own)], hermitian=True)
        found_costs[name] = Cost(
            before=_usual(((effects[:, own] * given[own]) ** 2).sum(axis=1)),
            after=_usual(np.einsum("pi,ij,pj->p", shared, inside, shared)),
        )
    total = np.einsum("pi,ij,pj->p", effects, covariance, effects)
    before = ((effects * given) ** 2).sum(axis=1)
    return found_costs, Cost(before=_usual(before), after=_usual(total))


def _assumed():
    """Return the default tolerances."""
    units = WHISKER.units
    return assumed_tolerances(units, units.read_channels(NOISE, "noise"))


def _usual(variances):
    """Return the square root of the median variance."""
    return float(np.sqrt(np.median(variances)))


def rows(each, total):
    """Yield the rows of the table."""
    assumed = _assumed()
    for name in assumed:
        size, unit = displayed(name, assumed[name], WHISKER.units)
        yield [f"`{name}`", f"{size:.2g} {unit}".strip(), _spelled(each[name])]
    yield ["all together", "", _spelled(total)]


def _spelled(cost):
    return ", ".join(f"{size:.4f}" if size > LEAST else "–" for size in (cost.before, cost.after))


def main():
    """Compute the effects, and print them; with --record, also write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--record", action="store_true", help="write the record")
    arguments = parser.parse_args()
    table = markdown_table(["tolerance", "assumed", "before, after"], rows(*costs(recording())))
    print(table)
    if arguments.record:
        write_record("costs", __doc__, table)
