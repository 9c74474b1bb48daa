"""Designs for three needs, and the neighbours of each, compared in simulated recordings.

The set-up is drawn from the default tolerances, alike for all rods of a need: the rod itself, its
mounting, the stage, zeros, drift, axes, crosstalk and the origin of the moment. A recording of some
thirty periods on a surface of one friction is simulated with it and read by `identify`, which knows
the nominal set-up. What is compared is the root mean square error of all frictions. The local slope
of the surface and the angle of the stage are exact: the one is the same for every rod, and with the
other a scan takes long.
"""

import argparse
import multiprocessing
from dataclasses import replace

import numpy as np
import pandas as pd

from vibrissa.design import DesignStatus, Requirements, design
from vibrissa.errors import VibrissaError
from vibrissa.sensor import PeriodStatus, Whisker, identify, scan, surfaces
from vibrissa.sensor.tolerances import assumed_tolerances

EXACT = {"tolerances": {"surface_slope": "exact", "stage_angle": "exact"}}
NANO = {"transducer": "nano17-si-12-0.12"}
NEEDS = {
    "small friction, Nano17": {
        **NANO,
        "material": "music-wire",
        "step": "20 um",
        "mu0": "0.05 to 0.15",
    },
    "a polymer rod": {**NANO, "material": "pom", "step": "50 um", "mu0": "0.2 to 0.35"},
    "wide range, soft surface: below 0.5 N": {
        "material": "stainless-302-wire",
        "noise": "2 mN, 2 mN, 10 uN*m",
        "range": "0.5 N, 0.5 N, 50 mN*m",
        "load": 1.0,
        "step": "20 um",
        "mu0": "0.15 to 0.45",
    },
}
SIZES = ("theta", "eta", "diameter", "length")
CHOICES = {name: Requirements.model_fields[name].default for name in SIZES}


def neighbours(best):
    """Rods that were turned down: the best of each other taper, and those one step beside it."""
    own = {name: getattr(best, name) for name in SIZES}
    rods = [
        {name: getattr(other, name) for name in SIZES}
        for other in best.alternatives
        if other.theta != best.theta
    ]
    for name in ("eta", "diameter", "length"):
        at = int(np.argmin(np.abs(np.array(CHOICES[name]) - own[name])))
        for beside in (at - 1, at + 1):
            if 0 <= beside < len(CHOICES[name]):
                rods.append({**own, name: CHOICES[name][beside]})
    return rods


def checked(need, rod):
    """Design that checks one rod."""
    given = {name: (value,) for name, value in rod.items()}
    return design(Requirements.read(**NEEDS[need], **EXACT, **given))


def drawn(whisker, noise, generator):
    """Draw a true whisker, how its loads are shown, and the scale of the stage."""
    sizes = assumed_tolerances(whisker.units, noise)
    error = {name: size * generator.standard_normal() for name, size in sizes.items()}
    length = 1.0 + error["length"]
    mounting = replace(
        whisker.mounting,
        clamp_angle=error["clamp_angle"],
        clamp_compliance=abs(error["clamp_compliance"]),
        curvature=error["curvature"],
    )
    true = replace(
        whisker,
        theta=max(whisker.theta + error["theta"], 1.0),
        eta=(whisker.eta + error["eta"]) / length,
        mounting=mounting,
        rod=None,
    )
    stiff = (1.0 + error["modulus"]) * (1.0 + error["diameter"]) ** 4
    scale = stiff * np.array([length**-2, length**-2, 1.0 / length])
    turn = error["transducer_angle"]
    mixing = np.eye(3)
    mixing[0, 1] += turn
    mixing[1, 0] -= turn
    mixing[2] += [error["moment_origin_y"], -error["moment_origin_x"], 0.0]
    full = np.array([1.0, 1.0, whisker.units.channels[0] / whisker.units.channels[2] * 0.01])
    crosstalk = sizes["crosstalk"] * generator.standard_normal((3, 3)) * np.outer(full, 1.0 / full)
    mixing += crosstalk * (1.0 - np.eye(3))
    channels = ("force_x", "force_y", "moment_z")
    zero, drift = (
        np.array([error[f"{what}_{channel}"] for channel in channels]) for what in ("zero", "drift")
    )
    return true, mixing * scale, zero, drift, (1.0 + error["stage_scale"]) / length


def errors(case):
    """Errors of the frictions that one drawn set-up gives with one rod."""
    need, rod, mu0, seed = case
    result = checked(need, rod)
    whisker = Whisker(theta=result.theta, eta=result.eta, rod=result.rod)
    asked, units = result.requirements, whisker.units
    noise, generator = np.array(asked.noise) / units.channels, np.random.default_rng(seed)
    true, mixing, zero, drift, way = drawn(whisker, noise, generator)
    step = asked.step / result.length
    try:
        to = 30.5 * float(whisker.curve.onset(mu0))
        found = scan(true, surfaces.constant(mu0), step=step * way, to=[to * way]).truth
        walk = np.cumsum(generator.standard_normal(found.reactions.shape), axis=0)
        walk *= drift / np.sqrt(len(found))
        readings = found.reactions @ mixing.T + zero + zero + walk
        readings += noise * generator.standard_normal(readings.shape)
        names = ("footpoint [m]", "force_x [N]", "force_y [N]", "moment_z [N*m]")
        values = np.column_stack([found.clamp / way * result.length, readings * units.channels])
        frame = pd.DataFrame(values, columns=names)
        stated = replace(whisker, tolerances=dict.fromkeys(EXACT["tolerances"], 0.0))
        periods = identify(stated, frame, noise=noise).periods
    except VibrissaError:
        return np.array([])
    known = periods.status == PeriodStatus.SLIP
    return (periods.mu0 - mu0)[known]


def compare(need, seeds, pool):
    """Print predicted and achieved uncertainties of the chosen rod and of its neighbours."""
    best = design(Requirements.read(**NEEDS[need], **EXACT))
    print(f"\n{need}\n{best!r}\n")
    if best.status is not DesignStatus.FOUND:
        return
    mu0 = float(best.mu0[np.argmax(best.uncertainty.whole)])
    rods = [{name: getattr(best, name) for name in SIZES}]
    rods += [rod for rod in neighbours(best) if checked(need, rod).status is DesignStatus.FOUND]
    print(f"| θ | η | d0 | L | predicted at μ0 = {mu0:g} | rms error | bias | recordings |")
    print("| --- " * 8 + "|")
    for rod in rods:
        own = checked(need, rod)
        predicted = float(np.interp(mu0, own.mu0, own.uncertainty.whole))
        cases = [(need, rod, mu0, seed) for seed in range(seeds)]
        each = [one for one in pool.map(errors, cases, chunksize=1) if len(one)]
        means = np.array([np.sqrt(np.mean(one**2)) for one in each])
        bias = np.mean([one.mean() for one in each])
        print(
            f"| {rod['theta']:g} | {rod['eta']:.3f} | {1e3 * rod['diameter']:g} mm "
            f"| {1e3 * rod['length']:.0f} mm | {predicted:.4f} "
            f"| {np.sqrt(np.mean(means**2)):.4f} | {bias:+.4f} | {len(each)} |",
            flush=True,
        )


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--seeds", type=int, default=24, help="recordings of each rod")
    parser.add_argument("--need", choices=NEEDS, action="append")
    arguments = parser.parse_args()
    with multiprocessing.Pool(arguments.workers) as pool:
        for need in arguments.need or NEEDS:
            compare(need, arguments.seeds, pool)


if __name__ == "__main__":
    main()
