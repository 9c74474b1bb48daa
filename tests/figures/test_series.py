"""Every kind of figure with one to a hundred series, in all formats."""

import re
import warnings
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib import image
from matplotlib.colors import to_rgb

from vibrissa.figures import style
from vibrissa.figures.draw import KINDS
from vibrissa.figures.series import Series

COUNTS = (1, 3, 6, 20, 100)
THETA = np.linspace(1.0, 3.0, 9)


def combined(**axes):
    """All combinations of the values of some axes, as rows."""
    return pd.MultiIndex.from_product(axes.values(), names=axes).to_frame(index=False)


def slipping(rows):
    """Made-up results at grid points: an onset that bends up to a lock as a square root."""
    lock = rows.eval("0.7 - 0.07 * theta - 0.2 * eta")
    gap = (lock - rows.mu0).clip(lower=0.0)
    onset = 0.1 * rows.theta * (1.0 - np.sqrt(gap / lock)) * (1.2 - rows.eta)
    slips = gap > 0.0
    return rows.assign(
        status=np.where(slips, "slip", "lock"),
        message="",
        contact=np.where(rows.mu0 > 0.5 * lock, "line", "point"),
        ends_by=np.where(rows.theta > 2, "slips_back", "snaps"),
        mu_lock=lock,
        x0_lock=0.1 * rows.theta * (1.2 - rows.eta),
        x0_slip=onset.where(slips),
        n_steps=(onset // rows.dx0).where(slips),
        x0_max=(onset // rows.dx0 * rows.dx0).where(slips),
        penetrates=rows.theta > 2.5,
    )


def taper(count):
    return slipping(
        combined(theta=THETA, mu0=np.linspace(0.05, 0.5, count), eta=[0.85], dx0=[0.001])
    )


def friction(count):
    return slipping(
        combined(theta=[2.0], mu0=np.linspace(0.05, 0.5, count), eta=[0.85], dx0=[0.0005])
    )


def plane(count):
    axes = {"theta": THETA, "mu0": np.linspace(0.1, 0.7, 7), "eta": np.linspace(0.3, 0.9, count)}
    return slipping(combined(**axes, dx0=[0.001]))


def near_locks(count):
    axes = {"theta": np.linspace(1.0, 3.0, count), "mu0": np.linspace(0.2, 0.5, 31)}
    return slipping(combined(**axes, eta=[0.85], dx0=[0.001]))


def past_locks(count):
    """As near the locks and beyond, where the end of sticking jumps up."""
    rows = near_locks(count)
    locks = rows.status == "lock"
    return rows.assign(
        ends_by=np.where(locks, "swings_aside", None),
        x0_end=(4.0 * rows.x0_lock).where(locks),
        x0_trail=(8.0 * rows.x0_lock + 0.02 * rows.mu0).where(locks),
    )


def mounted(count):
    axes = {"theta": np.linspace(1.0, 3.0, count), "clamp_angle": np.linspace(-0.1, 0.1, 5)}
    rows = slipping(combined(**axes, mu0=[0.2], eta=[0.85], dx0=[0.001]))
    return in_mountings(rows, 0.0)


def in_mountings(rows, ideal):
    """Made-up results that follow the inclination of the clamp; all else is ideal."""
    forces = {f"reaction_{name}_slip": rows.theta * rows.clamp_angle for name in ("fx", "fy", "m")}
    lock = rows.mu_lock - rows.clamp_angle * (1.0 - ideal * rows.theta)
    others = dict.fromkeys(("clamp_compliance", "curvature", "stage_angle"), 0.0)
    return rows.assign(**forces, **others).assign(mu_lock=lock)


def deviating(count):
    axes = {"theta": THETA, "eta": np.linspace(0.3, 0.9, count), "clamp_angle": [0.0, 0.02]}
    return in_mountings(slipping(combined(**axes, mu0=[0.2], dx0=[0.001])), 0.0)


def against_cylinders(count):
    axes = {"theta": [1.0, 2.0, 4.0], "eta": np.linspace(0.3, 0.9, count)}
    rows = combined(**axes, clamp_angle=np.linspace(-0.2, 0.2, 5), mu0=[0.2], dx0=[0.001])
    return in_mountings(slipping(rows), 1.0)


def shapes(begins, bends):
    """Rods from a clamp at each x0, bent the more the farther it is from the tip."""
    height = np.linspace(0.0, 0.85, 30)
    bent = [begin + bend * (height / 0.85) ** 2 for begin, bend in zip(begins, bends, strict=True)]
    return {"shape_x": bent, "shape_y": [height] * len(bent)}


def cycles(count):
    rows = combined(cycle=range(1, count + 1), x0=np.linspace(0.0, 0.05, 6))
    footpoint = 0.05 * (rows.cycle - 1) + rows.x0
    return rows.assign(
        theta=2.0,
        mu0=0.3,
        eta=0.85,
        dx0=0.01,
        status="slip",
        phase="stick",
        footpoint=footpoint,
        alpha=-np.arctan(6.0 * rows.x0),
        stability=1.0 - rows.x0,
        stability_aside=0.5 - rows.x0,
        reaction_fx=rows.x0,
        reaction_fy=-1.0,
        reaction_m=0.5 - rows.x0,
        **shapes(footpoint, 0.45 - rows.x0),
    )


def swung(count, per_scan=40):
    """First periods of rods of several tapers that swing aside half-way, at their own places."""
    rows = combined(theta=np.linspace(1.0, 3.0, count), step=range(per_scan))
    over = 0.5 / rows.theta
    footpoint = 2.0 * over * rows.step / (per_scan - 1)
    ahead = over - footpoint
    turned = np.where(ahead > 0.0, 1.0, -1.0)
    (bent,) = shapes([0.0], [0.3])["shape_x"]
    return rows.assign(
        mu0=0.9,
        eta=0.85,
        dx0=0.01,
        status="lock",
        cycle=1,
        phase="stick",
        footpoint=footpoint,
        x1=over,
        s_c=1.0,
        phi1=np.where(ahead > 0.0, 0.3, np.pi - 0.3),
        stability=0.7 + ahead.abs(),
        stability_aside=ahead.abs(),
        shape_x=[at + way * bent for at, way in zip(footpoint, turned, strict=True)],
        shape_y=shapes(footpoint, footpoint)["shape_y"],
    )


def swinging(count):
    """One rod in more and more steps."""
    return swung(1, 2 * count)


def states(count):
    x1 = np.linspace(0.05, 0.5, count)
    return pd.DataFrame(
        {
            "state": [f"state_{i}_with_a_rather_long_name_{i}" for i in range(count)],
            "theta": 1.0,
            "eta": 0.85,
            "x1": x1,
            "status": "solved",
            "message": "",
            "contact": "point",
            "f": 2.7,
            "alpha": -0.1,
            "phi1": 0.4,
            "s_c": 1.0,
            "penetrates": x1 < 0.2,
            **shapes(np.zeros(count), x1),
        }
    )


def both_contacts(count):
    rows = combined(theta=THETA, mu0=np.linspace(0.05, 0.5, count), eta=[0.85])
    return rows.assign(
        x0_slip_point=0.1 * rows.theta * (1.0 + rows.mu0),
        x0_slip_line=0.1 * rows.theta,
        penetrates=rows.theta > 2.0,
        mu_lock_point=0.5,
        mu_lock_line=0.5 - 0.1 * (rows.theta - 1.0),
    )


ROWS = {
    "taper": taper,
    "friction": friction,
    "locking": plane,
    "regimes": plane,
    "law": near_locks,
    "past_lock": past_locks,
    "margins": swung,
    "swing": swinging,
    "mounting": mounted,
    "change": deviating,
    "versus": against_cylinders,
    "scan": cycles,
    "period": cycles,
    "signals": cycles,
    "state": states,
    "models": both_contacts,
}


def drawn(kind, count):
    with style.applied(), warnings.catch_warnings():
        # Such as matplotlib's when type leaves no room for the axes.
        warnings.simplefilter("error")
        return KINDS[kind].plot(ROWS[kind](count))


def saved(figure, folder):
    """Write a figure; return the text of the SVG and the pixels of the PNG."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        style.save(figure, [folder / f"figure.{ending}" for ending in ("svg", "png")])
    return (folder / "figure.svg").read_text(), image.imread(folder / "figure.png")[..., :3]


def boxes_in_svg(text):
    """Box of each axes in a file, left, bottom, width and height as fractions of the page."""
    page = ElementTree.fromstring(text)
    _, _, width, height = map(float, page.get("viewBox").split())
    found = []
    for group in page.iter("{http://www.w3.org/2000/svg}g"):
        if re.fullmatch(r"axes_\d+", group.get("id", "")):
            # The background is drawn first.
            path = group.find(".//{http://www.w3.org/2000/svg}path").get("d")
            x, y = np.array(re.findall(r"[-\d.]+", path), float).reshape(-1, 2).T
            left, bottom = x.min() / width, 1.0 - y.max() / height
            found.append((left, bottom, np.ptp(x) / width, np.ptp(y) / height))
    return found


def test_every_kind_is_drawn():
    assert ROWS.keys() == KINDS.keys()


CASES = [
    # A hundred maps, each with axes of its own
    pytest.param(kind, count, marks=pytest.mark.slow if (kind, count) == ("regimes", 100) else ())
    for kind in ROWS
    for count in COUNTS
]


@pytest.mark.parametrize(("kind", "count"), CASES)
def test_the_data_have_room_and_all_formats_look_alike(kind, count, tmp_path, monkeypatch):
    figure = drawn(kind, count)
    # As it is laid out and looked at: type of one size is measured once.
    monkeypatch.setattr(style, "RESOLUTION", figure.dpi)
    text, pixels = saved(figure, tmp_path)
    visible = [axes for axes in figure.axes if axes.get_visible()]
    boxes = boxes_in_svg(text)
    places = [axes.get_position() for axes in visible]
    for place in places:  # an inset has a box of its own
        assert np.abs(np.array(boxes) - place.bounds).max(axis=1).min() < 2e-4
    # Axes of equal scale are as wide as the rod travels.
    panels = [place for place, axes in zip(places, visible, strict=True) if not is_bar(axes)]
    area = sum(place.width * place.height for place in panels)
    assert area > (0.2 if kind in ("scan", "period", "state", "swing") else 0.4)
    # The left spine of each panel is in the PNG where the SVG has it.
    for left, bottom, _, height in (place.bounds for place in panels):
        column = round(left * pixels.shape[1])
        rows = (1.0 - bottom - np.array([0.9, 0.1]) * height) * len(pixels)
        spine = pixels[slice(*rows.astype(int)), column - 2 : column + 3]
        assert spine.mean(axis=(0, 2)).min() < 0.7
    inside_the_page(figure)


def is_bar(axes):
    return axes.get_label() == "<colorbar>"


def inside_the_page(figure):
    """Nothing that is read is cut off; no legend covers half of a panel, or a label."""
    renderer = figure.canvas.get_renderer()
    page = figure.bbox.padded(1.0)
    for axes in filter(lambda axes: axes.get_visible(), figure.axes):
        read = [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.texts, axes.get_legend()]
        for artist in filter(None, read):
            box = artist.get_window_extent(renderer)
            if box.width > 0.0:
                assert page.containsx(box.x0) and page.containsx(box.x1), artist
                assert page.containsy(box.y0) and page.containsy(box.y1), artist
        if legend := axes.get_legend():
            box = legend.get_window_extent(renderer)
            assert box.width * box.height < 0.5 * axes.bbox.width * axes.bbox.height
    labels = [axes.xaxis.label for axes in figure.axes] + figure.texts
    for label in labels:
        for legend in figure.legends:
            box = label.get_window_extent(renderer)
            assert box.width == 0.0 or not box.overlaps(legend.get_window_extent(renderer))


SERIES = {
    "taper": r"\mu_0",
    "locking": r"\eta",
    "law": r"\theta",
    "past_lock": r"\theta",
    "margins": r"\theta",
    "state": "x_1",
    "models": r"\mu_0",
}


@pytest.mark.parametrize("count", [20, 100])
@pytest.mark.parametrize("kind", SERIES)
def test_many_series_have_colours_of_their_own_that_a_colourbar_tells(kind, count):
    figure = drawn(kind, count)
    (bar,) = filter(is_bar, figure.axes)
    assert bar.get_ylabel() == f"${SERIES[kind]}$"
    shades = {tuple(to_rgb(line.get_color())) for line in figure.axes[0].lines}
    assert len(shades - {to_rgb("black"), to_rgb(style.SURFACE)}) == count
    values = [float(text.get_text()) for text in bar.get_yticklabels()]
    assert len(values) == (20 if count == 20 else 11)
    assert values == sorted(values)


@pytest.mark.parametrize("count", [1, 3, 6])
@pytest.mark.parametrize("kind", ["taper", "locking", "law", "past_lock", "margins", "models"])
def test_few_series_have_the_papers_colours_and_a_legend(kind, count):
    figure = drawn(kind, count)
    assert not any(map(is_bar, figure.axes))
    axes = figure.axes[1 if kind == "law" else 0]
    (legend,) = figure.legends or [axes.get_legend()]
    labels = [text.get_text() for text in legend.get_texts()]
    assert sum(SERIES[kind] in label for label in labels) == count
    colors = {line.get_color() for line in axes.lines} & set(style.COLORS)
    assert colors == set(style.COLORS[:count])


def test_graded_colours_get_lighter_with_the_value():
    values = [0.001, 0.002, 0.004, 0.3, 0.31, 5.0, 90.0]
    series = Series(values * 2, "x")
    lightness = [np.dot(to_rgb(series.color(value)), (0.2, 0.7, 0.1)) for value in values]
    steps = np.diff(lightness)
    assert (steps > 0.05).all()


def test_single_points_are_seen():
    for kind in ("locking", "models"):
        rows = ROWS[kind](3)
        figure = KINDS[kind].plot(rows[rows.theta == 1.0])
        assert all(line.get_marker() == "o" for axes in figure.axes for line in axes.lines)


def test_a_map_of_one_point_has_a_cell_around_it():
    rows = plane(1)
    figure = KINDS["regimes"].plot(rows[(rows.theta == 1.0) & (rows.mu0 == rows.mu0.min())])
    (mesh,) = figure.axes[0].collections
    low, high = mesh.get_datalim(figure.axes[0].transData).get_points()
    assert low == pytest.approx([0.9, 0.09]) and high == pytest.approx([1.1, 0.11])


def test_states_have_their_numbers_their_names_or_a_colourbar():
    one, six, seven = (drawn("state", count) for count in (1, 6, 7))
    assert "f = 2.7" in one.axes[0].texts[0].get_text()
    names = [text.get_text() for text in six.legends[0].get_texts()]
    assert names[0].startswith("state_0_") and names[0].endswith("…") and len(names) == 7
    assert len(seven.axes) == 2


def test_states_of_several_tapers_are_told_by_taper():
    rows = states(8).assign(theta=np.linspace(1.0, 2.0, 8))
    figure = KINDS["state"].plot(rows)
    assert figure.axes[1].get_ylabel() == r"$\theta$"
    assert figure.axes[0].get_title() == "$y_1 = 0.85$"
