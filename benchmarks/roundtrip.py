"""A random surface, a scan of it, a real transducer, and back to friction: bias and coverage.

A steel whisker of 100 mm and 1 mm at the base (θ = 2, η = 0.85) moves 150 mm in steps of 50 µm over
a random texture (μ0 0.30 ± 0.04, correlated over 2 mm) and is read by an ATI Nano17 SI-12-0.12.
"""

import argparse
import multiprocessing
from collections import defaultdict
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from vibrissa.files import write_atomically
from vibrissa.sensor import friction
from vibrissa.sensor.identification import Found, Method, Recording, identify
from vibrissa.sensor.response import Response, respond
from vibrissa.sensor.scanning import Outcome, SlipLaw, path, scan
from vibrissa.sensor.transducer import preset
from vibrissa.units import Rod

ROD = Rod(youngs_modulus=2.1e11, base_diameter=1e-3, length=0.1)
SENSOR = preset("nano17-si-12-0.12")
SCALE = np.array([ROD.force_unit, ROD.force_unit, ROD.moment_unit])
POSITIONS = path("0.0005", ["1.5"])
# The energy law's slips do not end at α = 0: what the spacing makes of them is shown on purpose.
LAWS = (SlipLaw.FREE, SlipLaw.ENERGY)

_response: Response | None = None


def one(seed, drift, crosstalk):
    """Errors and whether the intervals cover, by law and method; periods there were and found."""
    global _response
    if _response is None:
        _response = respond(2.0, 0.85)
    results = {}
    flawed = replace(
        SENSOR, drift=tuple(drift * step for step in SENSOR.resolution), crosstalk=crosstalk
    )
    surface = friction.random(seed, 0.3, 0.04, 0.02)
    for law in LAWS:
        truth = scan(_response, surface, POSITIONS, law, 0.8)
        reactions = np.stack([truth.fx, truth.fy, truth.m], axis=1) * SCALE
        readings = flawed.measured(reactions, np.random.default_rng([seed, 1])) / SCALE
        recording = Recording(truth.footpoint, readings, np.arange(len(readings)))
        for method in Method:
            try:
                found = identify(_response, recording, np.array(SENSOR.deviation) / SCALE, method)
            except ValueError:
                continue  # refused: no state of this rod
            ok = np.array([status is Found.SLIP for status in found.status])
            mu0 = truth.mu0[found.last][ok]
            covers = (found.low[ok] <= mu0) & (mu0 <= found.high[ok])
            counts = int(truth.period[-1]), len(found.status)
            ended = truth.outcome is not Outcome.COMPLETE
            results[law, method] = (
                found.mu0[ok] - mu0,
                covers,
                found.deviation[ok],
                (*counts, ended),
            )
    return results


def main():
    """Print the table, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--figure", type=Path, help="where to draw the errors (.png, .svg, .pdf)")
    parser.add_argument(
        "--drift", type=float, default=0.0, help="of the zero, in steps of resolution per √sample"
    )
    parser.add_argument("--crosstalk", type=float, default=0.0, help="part of full scale")
    arguments = parser.parse_args()

    gathered = defaultdict(list)
    with multiprocessing.Pool(arguments.workers) as pool:
        scanned = partial(one, drift=arguments.drift, crosstalk=arguments.crosstalk)
        for results in pool.imap_unordered(scanned, range(arguments.seeds), chunksize=5):
            for key, value in results.items():
                gathered[key].append(value)
    print(
        "| slips | method | scans, ended | periods, found | bias | rms error | stated | coverage |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    errors = {}
    for (law, method), parts in gathered.items():
        error, covers, stated = (np.concatenate([part[i] for part in parts]) for i in range(3))
        there, found, ended = np.sum([part[3] for part in parts], axis=0)
        errors[law, method] = error
        print(
            f"| {law} | {method} | {len(parts)}, {ended} | {there}, {found} | {error.mean():+.1e} "
            f"| {np.sqrt(np.mean(error**2)):.1e} | {stated.mean():.1e} | {covers.mean():.2%} |"
        )
    if arguments.figure is not None:
        draw(errors, arguments.figure)


def draw(errors, path):
    """Draw a histogram of the errors for each law and method."""
    figure = Figure(figsize=(9.0, 2.8), layout="constrained")
    panels = figure.subplots(1, len(LAWS) * len(Method) - 1)
    shown = [key for key in errors if key != (SlipLaw.ENERGY, Method.SPACING)]
    for axes, key in zip(panels, shown, strict=True):
        axes.hist(errors[key], bins=np.linspace(-0.007, 0.007, 71), color="0.35")
        axes.axvline(0.0, color="C3", linewidth=0.8)
        axes.set_title(f"{key[1]}\nslips: {key[0]}", fontsize=9)
        axes.set(yticks=[], xticks=[-0.005, 0.0, 0.005], xlabel="error of μ0")
    with write_atomically(path) as temporary:
        figure.savefig(temporary, dpi=130)


if __name__ == "__main__":
    main()
