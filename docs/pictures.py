"""Draw pictures of the pages with the program's own solver and simulator."""

from collections.abc import Callable
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrissa import Mounting, Rod, sensor, solve_curve
from vibrissa.figures import labels, style, symbols
from vibrissa.files import write_atomically
from vibrissa.scanning import surfaces, textures
from vibrissa.sensor import Setup, Whisker, scan
from vibrissa.strip.drawing import draw

DOCS = Path(__file__).parent
ETA = 0.85
S = np.linspace(0.0, 1.0, 101)
QUIET = "0.55"


def rod(panel: Axes, curve, x0: float, side: int = 1, clamp: float | None = None, **look) -> None:
    """Draw a rod, with its clamp; `side` −1 is its mirror image."""
    at = x0 if clamp is None else clamp
    shape = curve.shapes(x0, S)
    x, y = at + side * np.asarray(shape.x).ravel(), np.asarray(shape.y).ravel()
    panel.plot(x, y, **{"linewidth": 1.6, **look})
    symbols.clamp(panel, at)


def side_view(panel: Axes, left: float, right: float) -> None:
    """Give a panel with rods the same scale along both axes."""
    symbols.surface(panel, ETA)
    panel.set(aspect="equal", xlim=(left, right), ylim=(-0.06, ETA + 0.14))
    panel.axis("off")


def lateral() -> Figure:
    """Draw a rod that buckles laterally, and the load on its clamp up to the next slip."""
    mu0, curve = 0.9, solve_curve(theta=1, eta=ETA)
    swing = curve.x0_end
    trail = float(curve.trailing_end(mu0).x0)
    figure = Figure(figsize=(style.PAGE, 2.5), layout="constrained")
    rods, loads = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
    rod(rods, curve, 0.0, color=QUIET, linewidth=1.0)
    rod(rods, curve, swing, color=style.COLORS[0])
    rod(rods, curve, swing - 0.3, -1, swing + 0.3, color=style.COLORS[1])
    rods.text(-0.03, 0.3, "1", ha="right")
    rods.text(swing - 0.14, 0.15, "2", ha="right", color=style.COLORS[0])
    rods.text(swing + 0.39, 0.45, "3", color=style.COLORS[1])
    side_view(rods, -0.15, 1.15)
    x0 = np.linspace(0.0, swing, 200)
    before = curve.state(x0).reaction_fx
    loads.plot(x0, before, color=style.COLORS[0])
    pulled = np.linspace(2 * swing - trail, swing, 200)
    after = -curve.state(pulled).reaction_fx
    loads.plot(2 * swing - pulled, after, color=style.COLORS[1])
    loads.plot([swing, swing], [before[-1], after[-1]], color=style.INK, linestyle=":")
    end = float(after[0])
    loads.plot([trail, trail], [end, 0.0], color=style.INK, linestyle=":")
    loads.axhline(0.0, color=QUIET, linewidth=0.6)
    loads.annotate("2  buckles laterally", (swing, 0.0), (6, 3), textcoords="offset points")
    loads.annotate("slips", (trail, end), (-4, 2), textcoords="offset points", ha="right")
    loads.text(0.02, before[0] + 0.4, "1")
    middle = len(pulled) // 2
    loads.text(2 * swing - pulled[middle], after[middle] + 0.3, "3  trails behind")
    loads.set(xlabel=r"clamp displacement $x_0$ / $L$", ylabel=r"load $f_x$ / $(E I_0/L^2)$")
    return figure


def mountings() -> Figure:
    """Draw the friction that sticking needs in each mounting, and rods in them."""
    cases = {
        "ideal": Mounting(),
        r"$\beta$ = 5°: leans back": Mounting(clamp_angle=np.radians(5)),
        "c = 0.2: yields": Mounting(clamp_compliance=0.2),
        r"$\kappa_0$ = −0.3: curved": Mounting(curvature=-0.3),
        r"$\delta$ = 5°: oblique stage": Mounting(stage_angle=np.radians(5)),
    }
    figure = Figure(figsize=(style.PAGE, 2.9), layout="constrained")
    left, panel = figure.subplots(1, 2, width_ratios=(1.0, 1.7))
    for (name, mounting), color, dashes in zip(
        cases.items(), (style.INK, *style.COLORS), style.DASHES, strict=False
    ):
        curve = solve_curve(theta=2, eta=ETA, mounting=mounting)
        x0 = np.linspace(0.0, curve.x0_lock, 200)
        look = {"color": color, "linestyle": dashes}
        panel.plot(x0, curve.mobilised_friction(x0), label=name, **look)
        rod(left, curve, 0.0, **{**look, "linewidth": 1.2})
    panel.axhline(0.3, color=QUIET, linewidth=0.7)
    panel.text(0.155, 0.305, r"$\mu_0$ = 0.3", color="0.35", ha="right", va="bottom")
    panel.set(xlabel=r"clamp displacement $x_0$ / $L$", ylabel=r"friction required, $-\tan\alpha$")
    panel.set_ylim(0.0, None)
    labels.at_ends(panel)
    side_view(left, -0.2, 0.75)
    left.set_title(r"the rods at $\alpha = 0$", fontsize=8)
    return figure


def tapers() -> Figure:
    """Draw what taper changes for a sensor: travel, sensitivity to the step, force, lock."""
    theta = np.linspace(1.0, 6.0, 26)
    curves = [solve_curve(theta=float(one), eta=ETA, contact="line") for one in theta]
    onset = np.array([float(curve.onset(0.3)) for curve in curves])
    shift = 1e-5
    slope = [
        float(np.diff(curve.mobilised_friction([x0 - shift, x0 + shift]))[0]) / (2 * shift)
        for curve, x0 in zip(curves, onset, strict=True)
    ]
    force = [-float(curve.state(x0).reaction_fy) for curve, x0 in zip(curves, onset, strict=True)]
    shown = {
        r"$x_{0,\mathrm{slip}}$ / $L$": ("travel of the clamp", onset),
        r"$d\mu/dx_0 \cdot L$": ("error by the step", slope),
        r"normal force / $(E I_0/L^2)$": ("signal", force),
        r"$\mu_\mathrm{lock}$": ("largest friction", [curve.mu_lock for curve in curves]),
    }
    figure = Figure(figsize=(style.PAGE, 1.9), layout="constrained")
    for panel, (name, (title, values)) in zip(figure.subplots(1, 4), shown.items(), strict=True):
        panel.plot(theta, np.abs(values), color=style.COLORS[0])
        panel.set(xlabel=style.TAPER, ylabel=name, ylim=(0.0, None), xlim=(1.0, 6.0))
        panel.set_title(title, fontsize=8)
    return figure


def wave() -> Figure:
    """Draw how slips lock to a wave of the surface."""
    length, amplitude = 0.02, 2e-4
    plane = surfaces.constant(0.3)
    texture = textures.wave(amplitude=amplitude, wavelength=length)
    wavy = plane.with_texture(texture)
    figure = Figure(figsize=(style.PAGE, 2.6), layout="constrained")
    heights, tips = figure.subplots(2, 1, sharex=True, height_ratios=(1.0, 2.2))
    heights.set(ylabel=r"height / $10^{-3} L$")
    for surface, name, color, dashes in (
        (plane, "plane", style.COLORS[1], style.DASHES[1]),
        (wavy, "wave", style.COLORS[0], style.DASHES[0]),
    ):
        signals = scan(Whisker(theta=2.0, eta=ETA), surface, step=0.0005, to=0.2).to_pandas()
        contact, clamp = signals["contact"].to_numpy(), signals["footpoint"].to_numpy()
        tips.plot(contact, clamp, color=color, linestyle=dashes, label=name, linewidth=1.2)
    first, last = contact.min(), contact.max()
    x = np.linspace(first, last, 1000)
    heights.plot(x, 1e3 * texture.height(x), color=style.SURFACE)
    tips.set(xlabel="position of the tip / $L$", ylabel="position of the clamp / $L$")
    tips.set_xlim(first, last)
    for at in np.arange(np.ceil(first / length), last / length) * length:
        for panel in (heights, tips):
            panel.axvline(at, color="0.85", linewidth=0.6, zorder=0)
    labels.at_ends(tips)
    return figure


def resonance() -> Figure:
    """Draw how often a sliding tip meets a wave, and the natural frequencies of its rod."""
    curve = solve_curve(theta=2, eta=ETA)
    steel = Rod(youngs_modulus=2.1e11, base_diameter=8e-4, length=0.1)
    first = float(curve.frequencies(0.0, 1, tip="slides").ravel()[0])
    natural = first * steel.frequency_unit(density=7850)
    figure = Figure(figsize=(style.COLUMN + 1.0, 2.5), layout="constrained")
    panel = figure.subplots()
    length = np.geomspace(5e-3, 10.0, 50)
    for speed, dashes in zip((1.0, 10.0, 100.0), style.DASHES, strict=False):
        look = {"color": style.COLORS[0], "linestyle": dashes}
        panel.loglog(length, speed / length, label=f"{speed:g} mm/s", **look)
        panel.plot(speed / natural, natural, "o", color=style.COLORS[1])
    panel.axhline(natural, color=style.COLORS[1])
    panel.text(9.0, 1.15 * natural, f"the sliding rod: {natural:.0f} Hz", ha="right")
    panel.set(xlim=(5e-3, 10.0), ylim=(0.3, 3e4))
    panel.set(xlabel="wavelength of the texture / mm", ylabel="waves per second / Hz")
    labels.at_ends(panel)
    return figure


def readings() -> Figure:
    """Draw the table of a scan over a surface whose friction varies."""
    surface = surfaces.patches([0.0, 0.65], [0.2, 0.4])
    signals = scan(Whisker(theta=2.0, eta=ETA), surface, step=0.0005, to=0.4).to_pandas()
    figure = Figure(figsize=(style.PAGE, 2.8), layout="constrained")
    panels = figure.subplots(3, 1, sharex=True)
    clamp = signals["footpoint"]
    for panel, key, name, color in zip(
        panels,
        ("force_x", "force_y", "contact"),
        ("force_x", "force_y", "contact"),
        (style.COLORS[0], style.COLORS[2], style.INK),
        strict=True,
    ):
        panel.plot(clamp, signals[key], color=color)
        panel.set_ylabel(name)
        panel.margins(x=0.0)
    panels[-1].set_xlabel("footpoint: position of the clamp / $L$")
    return figure


def strip() -> Figure:
    """Draw the strip of the recording in examples/."""
    examples = DOCS.parent / "examples"
    found = sensor.identify(Setup.read(examples / "setup.toml"), examples / "measurement.csv")
    return draw(found)


PICTURES: dict[str, Callable[[], Figure]] = {
    "lateral": lateral,
    "mountings": mountings,
    "tapers": tapers,
    "wave": wave,
    "resonance": resonance,
    "readings": readings,
    "strip": strip,
}


def main() -> None:
    """Draw all pictures."""
    for name, drawn in PICTURES.items():
        figure = drawn()
        with write_atomically(DOCS / f"{name}.svg") as temporary:
            figure.savefig(temporary, format="svg", metadata={"Date": None})


if __name__ == "__main__":
    with matplotlib.rc_context(style.SETTINGS):
        main()
