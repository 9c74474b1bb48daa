"""Does a tapered rod measure friction better? Errors over taper and step, simulated and predicted.

Steel whiskers of 100 mm at η = 0.85 are moved over surfaces of random friction (μ0 0.30 ± 0.025,
correlated over 2 mm) and read by an ATI Nano17 SI-12-0.12; slips end at α = 0. The cylinder has a
base diameter of 0.7 mm. Tapered rods have the same base diameter, or that with the same largest
strain, or that with the same force on the surface. A rod lies flat on the surface where it would
otherwise pass through it.
"""

import argparse
import multiprocessing
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from vibrissa import Rod, solve_onset
from vibrissa.errors import VibrissaError
from vibrissa.figures import style
from vibrissa.figures.style import COLORS, MARKERS
from vibrissa.outcomes import Contact
from vibrissa.sensor import (
    PeriodStatus,
    Recording,
    Units,
    Whisker,
    identify,
    path,
    preset,
    respond,
    simulate,
    surfaces,
)
from vibrissa.sensor.identification.uncertainty import step_deviation
from vibrissa.sensor.strain import largest_strain

ETA, CONTACT, LENGTH, MODULUS, DIAMETER = 0.85, "line", 0.1, 2.1e11, 0.7e-3
SENSOR = preset("nano17-si-12-0.12")
TAPERS = (1.0, 1.5, 2.0, 3.0, 4.0)
STEPS = ("0.0001", "0.0002", "0.0005", "0.001", "0.002", "0.005", "0.01")
# The largest frictions of the surfaces are below the critical friction of all these rods.
MEAN, SPREAD, CORRELATION = 0.3, 0.025, 0.02
# A scan has so many steps, whatever their size, but is not longer than this (L).
MOST, LONG = 2000, 2.0
# Errors are not compared where a larger part of the periods is missed, or found in excess.
MISSED = 0.05
# Equally likely frictions of the surfaces, over which a prediction is averaged.
TEXTURE = MEAN + SPREAD * norm.ppf((np.arange(32) + 0.5) / 32)
DESIGNS = ("same base diameter", "same largest strain", "same force on the surface")


@cache
def onset(theta, mu0=MEAN):
    """Find normal force (E·I0/L²) at the onset of slip and largest strain up to it (d0/L)."""
    response = respond(theta, ETA, CONTACT, pull=False)
    slip = solve_onset(theta, mu0, ETA, contact=CONTACT)
    strains = [largest_strain(response.curve, s) for s in (response.curve.state(0.0), slip.slip)]
    return -float(slip.slip.reaction_fy), max(strains)


@cache
def rods(theta):
    """Choose one rod for each of the designs."""
    (force, strain), (force1, strain1) = onset(theta), onset(1.0)
    thick = (1.0, strain1 / strain, (force1 / force) ** 0.25)
    return [Rod(MODULUS, DIAMETER * factor, LENGTH) for factor in thick]


def noise_in(rod):
    """Give the standard deviation of a reading, in the rod's own units."""
    return np.array(SENSOR.deviation) / Units(rod).channels


def predicted(response, mu0, step, noise):
    """Predict the standard deviation of a friction: of the onset in its step, and of the noise."""
    x0 = np.array([response.push_limit(value)[0] for value in np.atleast_1d(mu0)])
    slope = response.demand_slope(x0)
    variance = step_deviation(slope, step) ** 2
    # All samples of the period find the place of the tip together.
    parts = (np.arange(200) + 0.5) / 200
    weight = ((response.slope(x0[:, None] * parts) / noise) ** 2).sum(axis=-1)
    samples = np.maximum(x0 / step, 1.0)
    variance += slope**2 / (weight.mean(axis=1) * samples)
    return np.sqrt(variance)


class Trial(NamedTuple):
    """Errors of the frictions that one scan gave, and how many periods were found and are there."""

    errors: np.ndarray
    found: int
    there: int


def recorded(truth, rod, seed):
    """Let the transducer read a scan with one rod."""
    scale = Units(rod).channels
    readings = SENSOR.measured(truth.reactions * scale, np.random.default_rng([seed, 1]))
    if SENSOR.saturated(readings).any():
        raise ValueError(f"the transducer is saturated by a rod of {rod.base_diameter} m")
    return Recording(clamp=truth.clamp, readings=readings / scale, line=np.arange(len(readings)))


def whisker(theta):
    """Make the rod of a taper, in its own units."""
    return Whisker(theta=theta, eta=ETA, contact=Contact(CONTACT))


def trial(theta, rod, seed, truth):
    """Identify friction; None if the recording is refused."""
    try:
        asked = {"noise": noise_in(rod), "assume": False}
        found = identify(whisker(theta), recorded(truth, rod, seed), **asked).periods
    except VibrissaError:
        return None
    slip = found.status == PeriodStatus.SLIP
    errors = (found.mu0 - truth.mu0[found.last])[slip]
    return Trial(errors, len(found), int(truth.period[-1]))


def one(case):
    """Find the errors of one taper and step on several surfaces, where the slips are found."""
    theta, step, seeds = case
    response = respond(theta, ETA, CONTACT, pull=False)
    done = {design: [] for design in DESIGNS}
    for seed in range(seeds):
        surface = surfaces.random(seed, MEAN, SPREAD, CORRELATION)
        truth = simulate(response, surface, path(step, [min(MOST * float(step), LONG)]))
        for design, rod in zip(DESIGNS, rods(theta), strict=True):
            if (found := trial(theta, rod, seed, truth)) is not None:
                done[design].append(found)
    results = {}
    for key, parts in done.items():
        found, there = sum(part.found for part in parts), sum(part.there for part in parts)
        if len(parts) == seeds and abs(found - there) <= MISSED * there:
            results[theta, step, key] = np.concatenate([part.errors for part in parts])
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
    print_rods(responses)
    for step in ("0.0001", "0.001", "0.005"):
        print_errors(results, step)
    if arguments.figure is not None:
        with style.applied():
            figure = draw(responses, results)
        style.save(figure, [arguments.figure])


def print_rods(responses):
    """Print what the tapers do at the mean friction."""
    print("| θ | x0_slip | dμ/dx0 | force | strain | base for the same strain, force | μ_lock |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for theta, response in responses.items():
        x0 = response.push_limit(MEAN)[0]
        (force, strain), (_, thin, thick) = onset(theta), rods(theta)
        print(
            f"| {theta:g} | {x0:.4f} | {float(response.demand_slope(x0)):.1f} "
            f"| {force:.2f} | {strain * DIAMETER / LENGTH:.2%} | {thin.base_diameter * 1e3:.2f}, "
            f"{thick.base_diameter * 1e3:.2f} mm | {response.curve.mu_lock:.3f} |"
        )


def print_errors(results, step):
    """Print root mean square errors and biases of one step of the stage."""
    print(f"\nstep {step}: rms error, bias")
    print("| design | " + " | ".join(f"θ = {theta:g}" for theta in TAPERS) + " |")
    print("| --- |" + " --- |" * len(TAPERS))
    for design in DESIGNS:
        errors = [results.get((theta, step, design)) for theta in TAPERS]
        cells = ("—" if x is None else f"{rms(x):.1e}, {x.mean():+.0e}" for x in errors)
        print(f"| {design} | " + " | ".join(cells) + " |")


def rms(values):
    """Root mean square."""
    return np.sqrt(np.mean(values**2))


def draw(responses, results):
    """Draw errors over the step for each design, and what they come from."""
    figure = style.page(4.6, style.PAGE)
    panels = figure.subplots(2, 3)
    for axes, design in zip(panels[0], DESIGNS, strict=True):
        draw_errors(axes, responses, results, design)
    panels[0, 0].set_ylabel(r"rms error of $\mu_0$")
    panels[1, 0].set_axis_off()
    draw_reasons(panels[1, 1])
    draw_lock(panels[1, 2], responses)
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


def draw_errors(axes, responses, results, design):
    """Draw predicted and simulated errors over the step of the stage."""
    steps = np.geomspace(float(STEPS[0]), float(STEPS[-1]), 60)
    for i, (theta, response) in enumerate(responses.items()):
        noise = noise_in(rods(theta)[DESIGNS.index(design)])
        expected = [rms(predicted(response, TEXTURE, step, noise)) for step in steps]
        axes.loglog(steps, expected, color=COLORS[i], linewidth=0.9)
        keys = {float(step): (theta, step, design) for step in STEPS}
        found = {step: rms(results[key]) for step, key in keys.items() if key in results}
        axes.loglog(list(found), list(found.values()), MARKERS[i], color=COLORS[i], markersize=4)
    axes.set_ylim(1e-4, 1e-1)
    axes.set_title(design)
    axes.set_xlabel(r"step of the stage $\Delta x_0$ / $L$")


def draw_reasons(axes):
    """Draw over the taper why errors differ: slope of the demand, and force on the surface."""
    tapers = np.linspace(1.0, 6.0, 26)
    curves = [respond(theta, ETA, CONTACT, pull=False) for theta in tapers]
    onsets = [response.push_limit(MEAN)[0] for response in curves]
    pairs = list(zip(curves, onsets, strict=True))
    slope = np.array([response.demand_slope(x0) for response, x0 in pairs])
    force = np.array([-response(x0)[1] for response, x0 in pairs])
    axes.plot(tapers, slope / slope[0], color="black", label=r"$d\mu/dx_0$ at the onset")
    axes.plot(tapers, force / force[0], "--", color="black", label="force, same base diameter")
    axes.set_title(rf"why: relative to $\theta = 1$, $\mu_0 = {MEAN}$")
    axes.set(xlabel=r"taper factor $\theta$", ylim=(0, 1))
    axes.legend()


def draw_lock(axes, responses):
    """Draw over the friction what is predicted, up to self-locking."""
    for i, (theta, response) in enumerate(responses.items()):
        mu0 = np.linspace(0.03, response.curve.mu_lock - 1e-4, 80)
        expected = predicted(response, mu0, 1e-3, noise_in(rods(theta)[0]))
        axes.semilogy(mu0, expected, color=COLORS[i], linewidth=0.9)
        axes.axvline(response.curve.mu_lock, 0.0, 0.1, color=COLORS[i], linewidth=2.5)
    axes.set_title(r"$\Delta x_0 = 0.001$, up to the lock")
    axes.set(xlabel=r"$\mu_0$", ylim=(1e-4, 3e-2))
