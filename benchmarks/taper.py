"""Does a tapered rod measure friction better? Errors over taper and step, simulated and predicted.

Steel whiskers of 100 mm at η = 0.85 are moved over random textures (μ0 0.30 ± 0.025, correlated
over 2 mm) and read by an ATI Nano17 SI-12-0.12; slips end at α = 0. The cylinder has 0.7 mm at the
base. Tapered rods are as thick there, or so thick that they are strained as much, or so thick that
they press on the surface as much. Where a rod would pass through the surface it lies down on it.
"""

import argparse
import multiprocessing
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import norm

from vibrissa import Rod, solve_onset
from vibrissa.figures import COLORS, MARKERS, STYLE, save
from vibrissa.sensor import friction
from vibrissa.sensor.identification import Found, Method, Recording, identify
from vibrissa.sensor.response import largest_strain, respond
from vibrissa.sensor.scanning import path, scan
from vibrissa.sensor.transducer import preset

ETA, CONTACT, LENGTH, MODULUS, DIAMETER = 0.85, "line", 0.1, 2.1e11, 0.7e-3
SENSOR = preset("nano17-si-12-0.12")
TAPERS = (1.0, 1.5, 2.0, 3.0, 4.0)
STEPS = ("0.0001", "0.0002", "0.0005", "0.001", "0.002", "0.005", "0.01")
# The tail of the texture stays below the lock of all these rods.
MEAN, SPREAD, CORRELATION = 0.3, 0.025, 0.02
# A scan has so many steps, whatever their size, but is not longer than this (L).
MOST, LONG = 2000, 2.0
# Where more of the slips are missed, or made up, than this nothing is said about errors.
MISSED = 0.05
# Equally likely frictions of the texture, over which a prediction is averaged.
TEXTURE = MEAN + SPREAD * norm.ppf((np.arange(32) + 0.5) / 32)
DESIGNS = ("same base diameter", "same largest strain", "same force on the surface")


@cache
def onset(theta, mu0=MEAN):
    """Find normal force (E·I0/L²) at the onset of slip and largest strain up to it (d0/L)."""
    response = respond(theta, ETA, CONTACT, pull=False)
    slip = solve_onset(theta, mu0, ETA, contact=CONTACT)
    x1 = response.curve.x1_init
    strains = [
        largest_strain(theta, ETA, x1, response.curve.state(0.0)),
        largest_strain(theta, ETA, x1 - slip.x0_slip, slip.slip),
    ]
    return -float(slip.slip.reaction_fy), max(strains)


@cache
def rods(theta):
    """Choose one rod for each of the designs."""
    (force, strain), (force1, strain1) = onset(theta), onset(1.0)
    thick = (1.0, strain1 / strain, (force1 / force) ** 0.25)
    return [Rod(MODULUS, DIAMETER * factor, LENGTH) for factor in thick]


def noise_in(rod):
    """Give the standard deviation of a reading, in the rod's own units."""
    return np.array(SENSOR.deviation) / scale_of(rod)


def scale_of(rod):
    """Give the units of fx, fy and m in SI."""
    return np.array([rod.force_unit, rod.force_unit, rod.moment_unit])


def sensitivity(response, x0):
    """Differentiate the friction that sticking needs with respect to x0 (1/L)."""
    (fx, fy, _), (dfx, dfy, _) = response(x0).T, response.slope(x0).T
    return (dfx * fy - fx * dfy) / fy**2


def predicted(response, mu0, step, noise, method):
    """Predict the standard deviation of a friction, of the onset in its step and of the noise."""
    x0 = np.array([response.push_limit(value)[0] for value in np.atleast_1d(mu0)])
    tilt = sensitivity(response, x0)
    variance = (tilt * step) ** 2 / 12.0
    fx, fy, _ = response(x0).T
    if method is Method.FORCES:
        variance += (noise[0] / fy) ** 2 + (fx * noise[1] / fy**2) ** 2
    if method is Method.MOMENT:
        # All samples of the period find the place of the tip together.
        parts = (np.arange(200) + 0.5) / 200
        weight = (response.slope(x0[:, None] * parts)[..., 2] / noise[2]) ** 2
        samples = np.maximum(x0 / step, 1.0)
        variance += tilt**2 / (weight.mean(axis=1) * samples)
    return np.sqrt(variance)


def one(case):
    """Find the errors of one taper and step on several surfaces, where the slips are found."""
    theta, step, seeds = case
    response = respond(theta, ETA, CONTACT, pull=False)
    errors = {}
    for seed in range(seeds):
        surface = friction.random(seed, MEAN, SPREAD, CORRELATION)
        truth = scan(response, surface, path(step, [min(MOST * float(step), LONG)]))
        reactions = np.stack([truth.fx, truth.fy, truth.m], axis=1)
        for design, rod in zip(DESIGNS, rods(theta), strict=True):
            generator = np.random.default_rng([seed, 1])
            readings = SENSOR.measured(reactions * scale_of(rod), generator) / scale_of(rod)
            if SENSOR.saturated(readings * scale_of(rod)).any():
                raise ValueError(f"the transducer is saturated by the rod of θ = {theta}, {design}")
            recording = Recording(truth.footpoint, readings, np.arange(len(readings)))
            for method in Method:
                try:
                    found = identify(
                        response, recording, noise_in(rod), method, float(step), law="free"
                    )
                except ValueError:
                    continue
                slip = np.array([status is Found.SLIP for status in found.status])
                error = (found.mu0 - truth.mu0[found.last])[slip]
                periods = len(found.status), int(truth.period[-1])
                errors.setdefault((design, method), []).append((error, *periods))
    results = {}
    for key, parts in errors.items():
        found, there = (sum(part[i] for part in parts) for i in (1, 2))
        if len(parts) == seeds and abs(found - there) <= MISSED * there:
            results[theta, step, *key] = np.concatenate([part[0] for part in parts])
    return results


def main():
    """Print the tables, draw the figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--workers", type=int, default=None)
    parser.add_argument("--figure", type=Path, help="where to draw it (.png, .svg, .pdf)")
    arguments = parser.parse_args()

    responses = {theta: respond(theta, ETA, CONTACT, pull=False) for theta in TAPERS}
    results = {}
    cases = [(theta, step, arguments.seeds) for step in STEPS for theta in TAPERS]
    with multiprocessing.Pool(arguments.workers) as pool:
        for errors in pool.imap_unordered(one, cases):
            results |= errors

    print("| θ | x0_slip | dμ/dx0 | force | strain | base for the same strain, force | μ_lock |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for theta, response in responses.items():
        x0 = response.push_limit(MEAN)[0]
        (force, strain), (_, thin, thick) = onset(theta), rods(theta)
        print(
            f"| {theta:g} | {x0:.4f} | {float(sensitivity(response, np.array(x0))):.1f} "
            f"| {force:.2f} | {strain * DIAMETER / LENGTH:.2%} | {thin.base_diameter * 1e3:.2f}, "
            f"{thick.base_diameter * 1e3:.2f} mm | {response.curve.mu_lock:.3f} |"
        )
    for step in ("0.0001", "0.001", "0.005"):
        print(f"\nstep {step}: rms error, bias")
        print("| design | method | " + " | ".join(f"θ = {theta:g}" for theta in TAPERS) + " |")
        print("| --- | --- |" + " --- |" * len(TAPERS))
        for design in DESIGNS:
            for method in Method:
                cells = []
                for theta in TAPERS:
                    error = results.get((theta, step, design, method))
                    cells.append(
                        "—"
                        if error is None
                        else f"{np.sqrt(np.mean(error**2)):.1e}, {error.mean():+.0e}"
                    )
                print(f"| {design} | {method} | " + " | ".join(cells) + " |")
    if arguments.figure is not None:
        with matplotlib.rc_context(STYLE):
            figure = draw(responses, results)
        save(figure, [arguments.figure])


def draw(responses, results):
    """Draw errors over the step for each design, and what they come from."""
    figure = Figure(figsize=(9.0, 5.6), layout="constrained")
    panels = figure.subplots(2, 3)
    steps = np.geomspace(float(STEPS[0]), float(STEPS[-1]), 60)
    shown = [(axes, d, Method.FORCES) for axes, d in zip(panels[0], DESIGNS, strict=True)]
    shown.append((panels[1, 0], DESIGNS[0], Method.MOMENT))
    for axes, design, method in shown:
        for i, (theta, response) in enumerate(responses.items()):
            noise = noise_in(rods(theta)[DESIGNS.index(design)])
            expected = [
                np.sqrt(np.mean(predicted(response, TEXTURE, s, noise, method) ** 2)) for s in steps
            ]
            axes.loglog(steps, expected, color=COLORS[i], linewidth=0.9)
            found = [
                (float(s), np.sqrt(np.mean(results[theta, s, design, method] ** 2)))
                for s in STEPS
                if (theta, s, design, method) in results
            ]
            axes.loglog(
                *np.array(found).reshape(-1, 2).T, MARKERS[i], color=COLORS[i], markersize=4
            )
        axes.set_ylim(*((1e-3, 1e-1) if method is Method.FORCES else (1e-4, 1e-1)))
        axes.set_title(f"{method}, {design}", fontsize=9)
        axes.set_xlabel(r"step of the stage $\Delta x_0$ / $L$")
    for axes in panels[:, 0]:
        axes.set_ylabel(r"rms error of $\mu_0$")

    tapers = np.linspace(1.0, 6.0, 26)
    curves = [respond(theta, ETA, CONTACT, pull=False) for theta in tapers]
    onsets = [np.array(response.push_limit(MEAN)[0]) for response in curves]
    tilt = np.array([sensitivity(*pair) for pair in zip(curves, onsets, strict=True)])
    force = np.array([-r(x0)[1] for r, x0 in zip(curves, onsets, strict=True)])
    axes = panels[1, 1]
    axes.plot(tapers, tilt / tilt[0], color="black", label=r"$d\mu/dx_0$ at the onset")
    axes.plot(tapers, force / force[0], "--", color="black", label="force, same base diameter")
    axes.set_title(rf"why: relative to $\theta = 1$, $\mu_0 = {MEAN}$", fontsize=9)
    axes.set(xlabel=r"taper factor $\theta$", ylim=(0, 1))
    axes.legend(fontsize=8)

    axes = panels[1, 2]
    for i, (theta, response) in enumerate(responses.items()):
        mu0 = np.linspace(0.03, response.curve.mu_lock - 1e-4, 80)
        expected = predicted(response, mu0, 1e-3, noise_in(rods(theta)[0]), Method.MOMENT)
        axes.semilogy(mu0, expected, color=COLORS[i], linewidth=0.9)
        axes.axvline(response.curve.mu_lock, 0.0, 0.1, color=COLORS[i], linewidth=2.5)
    axes.set_title(r"moment, $\Delta x_0 = 0.001$, up to the lock", fontsize=9)
    axes.set(xlabel=r"$\mu_0$", ylim=(1e-4, 3e-2))
    lines = [
        panels[0, 0].plot([], [], MARKERS[i], color=COLORS[i], linestyle="-", label=f"{theta:g}")[0]
        for i, theta in enumerate(TAPERS)
    ]
    figure.legend(
        handles=lines,
        title=r"taper factor $\theta$ (marks: simulated, lines: predicted)",
        loc="outside upper center",
        ncols=len(TAPERS),
    )
    return figure


if __name__ == "__main__":
    main()
