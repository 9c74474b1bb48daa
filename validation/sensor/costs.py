"""What each tolerance costs in μ0, by the model, before and after the adjustment to a recording.

A steel rod of 1 mm x 100 mm, θ = 2 at 85 mm, scans 60 mm of a surface of friction 0.30 in steps of
20 µm; the noise is 3 mN and 10 µN·m. With what nothing is stated about as it is assumed,

- before: the error of μ0 by an error of one standard deviation, if nothing is adjusted;
- after: by how much the variance that all periods share would fall if this were known exactly.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from validation.records import write_record
from vibrissa.figures import style
from vibrissa.sensor import Recording, Whisker, identify, scan, surfaces
from vibrissa.sensor.tolerances import TOLERABLE, assumed_tolerances, told

NOISE = "3 mN, 3 mN, 10 uN*m"
STEEL = {"modulus": "210 GPa", "diameter": "1 mm", "length": "100 mm"}
WHISKER = Whisker.read(2, "85 mm", **STEEL).wishing(NOISE)
# Costs below this do not count, and are not drawn.
LEAST = 1e-5
FIGURE = Path(__file__).parents[1] / "records/costs.png"


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a tolerance costs in μ0.

    Attributes
    ----------
    before, after : float
        Standard deviations of μ0 by it, see above.
    """

    before: float
    after: float


def recording():
    """Simulate readings without noise: what is known of them is counted as if they had it."""
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
    """Cost of each tolerance by the model, and of all together; some may be stated."""
    found = identify(
        WHISKER,
        readings,
        noise=NOISE,
        tolerances=stated,
    )
    known = np.isfinite(found.periods.mu0)
    effects, covariance = found.periods.effects[known], found.covariance
    names = np.array([one.of for one in found.tolerances])
    given = np.array([one.tolerance for one in found.tolerances])
    found_costs = {}
    for name in TOLERABLE:
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
    """Tolerances of what nothing is stated about."""
    units = WHISKER.units
    return assumed_tolerances(units, units.read_channels(NOISE, "noise"))


def _usual(variances):
    """Give the standard deviation of the usual period."""
    return float(np.sqrt(np.median(variances)))


def draw(found, path):
    """Draw the costs: a panel for each method, a pair of bars for each tolerance."""
    names = [name for name in TOLERABLE if _counts(found, name)]
    figure = style.page(4.2, style.PAGE)
    panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    place = np.arange(len(names))
    for axes, (method, (each, total)) in zip(panels, found.items(), strict=True):
        for part, shift, color, label in (
            ("before", -0.2, "0.7", "before the adjustment"),
            ("after", 0.2, style.COLORS[0], "after it, all at once"),
        ):
            sizes = [getattr(each[name], part) for name in names]
            axes.barh(place + shift, sizes, height=0.4, color=color, label=label)
        axes.axvline(total.after, color=style.END, linewidth=1.0, label="all together, after it")
        axes.set(xscale="log", xlim=(LEAST, 0.05), title=method)
        axes.grid(axis="x", color="0.9")
        axes.set_axisbelow(True)
    panels[0].set_yticks(place, names)
    panels[0].invert_yaxis()
    figure.supxlabel("standard deviation of μ0 by this tolerance")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False)
    style.save(figure, [path])


def _counts(found, name):
    return any(max(each[name].before, each[name].after) > LEAST for each, _ in found.values())


def table(found):
    """Lines of the table, in Markdown."""
    yield "| tolerance | assumed | " + " | ".join(f"{m}: before, after" for m in found) + " |"
    yield "| --- | --- |" + " --- |" * len(found)
    assumed = _assumed()
    for name in TOLERABLE:
        size, unit = told(name, assumed[name], WHISKER.units)
        cells = [_spelled(each[name]) for each, _ in found.values()]
        yield f"| `{name}` | {f'{size:.2g} {unit}'.strip()} | {' | '.join(cells)} |"
    cells = [_spelled(total) for _, total in found.values()]
    yield f"| all together | | {' | '.join(cells)} |"


def _spelled(cost):
    return ", ".join(f"{size:.4f}" if size > LEAST else "–" for size in (cost.before, cost.after))


def main():
    """Compute the costs, and print or write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--record", action="store_true", help="write the record and its figure")
    arguments = parser.parse_args()

    readings = recording()
    found = {"model": costs(readings)}
    rows = "\n".join(table(found))
    print(rows)
    if arguments.record:
        write_record("costs", __doc__, rows)
        with style.applied():
            draw(found, FIGURE)
