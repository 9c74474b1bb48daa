"""Every kind of figure with one to a hundred series, in all formats."""

import re
import struct
import warnings
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import image
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.contour import ContourSet

from figure_rows import ROWS, THETA, combined, drawn, made_comparison, plane, slipping, states
from vibrissa.figures import regimes, style
from vibrissa.figures.draw import KINDS
from vibrissa.figures.series import Series

COUNTS = (1, 6, 100)


def laid_out(figure):
    """Lay a figure out as for its files; a warning is an error."""
    FigureCanvasAgg(figure)
    with style.applied(), warnings.catch_warnings():
        warnings.simplefilter("error")
        figure.draw_without_rendering()


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


@pytest.mark.parametrize(
    ("largest", "told", "count", "few"),
    [
        (0.2, "", 19, False),
        (0.42, "\na line ends where the tip locks", 19, False),
        (
            0.95,
            "\na line ends where the tip locks: for $\\mu_0 \\geq 0.5$ at every $\\theta$",
            9,
            False,
        ),
        (
            1.85,
            "\na line ends where the tip locks: for $\\mu_0 \\geq 0.55$ at every $\\theta$",
            5,
            True,
        ),
    ],
)
def test_series_that_lock_take_no_colours(largest, told, count, few):
    mu0 = np.linspace(0.05, largest, 19).round(9)
    rows = slipping(combined(theta=THETA, mu0=mu0, eta=[0.85], dx0=[0.001]))
    figure = KINDS["taper"].plot(rows)
    (axes,) = [axes for axes in figure.axes if not is_bar(axes)]
    assert axes.get_title().endswith(f"0.001${told}")
    colors = {line.get_color() for line in axes.lines} - {"black"}
    assert len(colors) == count
    # The light end of the colour map, or the last of the colours that are used.
    last = style.COLORS[count - 1] if few else Series(range(count), "").color(count - 1)
    assert last in colors
    laid_out(figure)
    inside_the_page(figure)


def test_a_study_that_locks_everywhere_says_so():
    rows = slipping(combined(theta=THETA, mu0=[0.8, 0.9], eta=[0.85], dx0=[0.001]))
    (text,) = KINDS["taper"].plot(rows).axes[0].texts
    assert text.get_text() == "the tip locks at every point"


def with_locks(rows):
    """A comparison in which the tip locks from 0.4 on in tip contact, from 0.3 in line contact."""
    known = {"point": rows.mu0 < 0.4, "line": rows.mu0 < 0.3}
    return rows.assign(
        **{f"status_{one}": np.where(slips, "slip", "lock") for one, slips in known.items()},
        **{f"x0_slip_{one}": rows[f"x0_slip_{one}"].where(slips) for one, slips in known.items()},
    )


def test_models_are_compared_where_the_tip_slips_in_both():
    mu0 = (0.1, 0.2, 0.35, 0.5)
    rows = combined(theta=THETA, mu0=mu0, eta=[0.85])
    figure = KINDS["models"].plot(with_locks(made_comparison(rows)))
    errors, locks = figure.axes
    told = "\na line ends where the tip locks: for $\\mu_0 \\geq 0.35$ at every $\\theta$"
    assert figure.get_suptitle().endswith(f"in tip contact{told}")
    named = [text.get_text() for text in errors.get_legend().get_texts()]
    assert named == [r"$\mu_0 = 0.1$", r"$\mu_0 = 0.2$"]
    assert {line.get_color() for line in errors.lines} == set(style.COLORS[:2])
    # Colours are for the series: the kinds of contact are told by their lines.
    assert [(line.get_color(), line.get_linestyle()) for line in locks.lines] == [
        ("black", "-"),
        ("black", "--"),
    ]
    laid_out(figure)
    inside_the_page(figure)


def test_models_say_where_there_is_nothing_to_compare():
    rows = with_locks(made_comparison(combined(theta=[1.0, 2.0], mu0=[0.35, 0.5], eta=[0.85])))
    figure = KINDS["models"].plot(rows)
    errors, locks = figure.axes
    (text,) = errors.texts
    assert text.get_text() == "nowhere an onset of slip\nin both kinds of contact"
    assert not errors.axison and len(locks.lines) == 2
    laid_out(figure)
    inside_the_page(figure)


@pytest.mark.parametrize("kind", ["locking", "models"])
def test_a_mark_at_the_top_is_seen_whole(kind):
    rows = ROWS[kind](3)
    axes = KINDS[kind].plot(rows[rows.theta == 1.0]).axes[-1]
    top = max(line.get_ydata().max() for line in axes.lines)
    low, high = axes.get_ylim()
    assert low == 0.0 and high == pytest.approx(1.05 * top)


def test_every_kind_is_drawn():
    assert ROWS.keys() == KINDS.keys()


def visible(figure):
    return [axes for axes in figure.axes if axes.get_visible()]


def panels_of(figure):
    return [axes.get_position() for axes in visible(figure) if not is_bar(axes)]


CASES = [
    pytest.param(kind, count, marks=() if count == 6 else pytest.mark.slow)
    for kind in ROWS
    for count in COUNTS
]


@pytest.mark.parametrize(("kind", "count"), CASES)
def test_the_data_have_room_and_nothing_is_cut_off(kind, count):
    figure = drawn(kind, count)
    laid_out(figure)
    # Axes of equal scale are as wide as the rod travels.
    area = sum(place.width * place.height for place in panels_of(figure))
    assert area > (0.2 if kind in ("scan", "period", "state", "swing") else 0.4)
    inside_the_page(figure)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ROWS)
def test_all_formats_look_alike(kind, tmp_path, monkeypatch):
    figure = drawn(kind, 6)
    # As it is laid out and looked at: type of one size is measured once.
    monkeypatch.setattr(style, "RESOLUTION", figure.dpi)
    text, pixels = saved(figure, tmp_path)
    boxes = boxes_in_svg(text)
    for axes in visible(figure):  # an inset has a box of its own
        assert np.abs(np.array(boxes) - axes.get_position().bounds).max(axis=1).min() < 2e-4
    # The left spine of each panel is in the PNG where the SVG has it.
    for left, bottom, _, height in (place.bounds for place in panels_of(figure)):
        column = round(left * pixels.shape[1])
        rows = (1.0 - bottom - np.array([0.9, 0.1]) * height) * len(pixels)
        spine = pixels[slice(*rows.astype(int)), column - 2 : column + 3]
        assert spine.mean(axis=(0, 2)).min() < 0.7


def test_a_figure_is_laid_out_once_for_all_formats(tmp_path, monkeypatch):
    """Else its PDF, whose type is measured in another way, would have other axes than its PNG."""
    figure, layouts = drawn("taper", 3), []
    engine = figure.get_layout_engine()
    execute = engine.execute
    monkeypatch.setattr(engine, "execute", lambda page: layouts.append(page) or execute(page))
    style.save(figure, [tmp_path / f"figure.{ending}" for ending in ("svg", "pdf", "png")])
    assert layouts == [figure]


def test_pixels_are_enough_for_print(tmp_path):
    style.save(drawn("taper", 3), [tmp_path / "figure.png"])
    header = (tmp_path / "figure.png").read_bytes()[16:24]
    assert struct.unpack(">II", header) == (round(6.3 * 200), round(4.2 * 200))


def test_a_law_is_fitted_to_the_16_points_next_to_the_lock():
    gap = np.geomspace(1e-4, 1e-1, 17)
    distance = np.where(np.arange(17) < 16, 3.0 * np.sqrt(gap), 100.0)
    for order in (slice(None), slice(None, None, -1)):
        law = regimes._fitted_law(gap[order], distance[order])
        assert (law.scale, law.exponent) == pytest.approx((3.0, 0.5))


@pytest.mark.parametrize(("gap", "distance"), [(0.0, 0.1), (-1e-5, 0.1), (2e-5, 0.0), (2e-5, -0.1)])
def test_what_is_at_the_lock_or_past_it_has_no_part_in_the_law(gap, distance):
    gaps = np.geomspace(1e-4, 1e-1, 15)
    law = regimes._fitted_law(np.append(gaps, gap), np.append(3.0 * np.sqrt(gaps), distance))
    assert (law.scale, law.exponent) == pytest.approx((3.0, 0.5))


def test_a_law_and_its_correction_are_found():
    gap = np.geomspace(1e-6, 1e-2, 40)
    law = regimes._fitted_law(gap, 2.0 * np.sqrt(gap) * (1.0 + np.sqrt(gap)) ** 0.7)
    assert (law.scale, law.exponent, law.correction) == pytest.approx((2.0, 0.5, 0.7), rel=1e-6)
    assert law(np.array([1e-4])) == pytest.approx(2e-2 * 1.01**0.7, rel=1e-6)


def is_bar(axes):
    return axes.get_label() == "<colorbar>"


def inside_the_page(figure):
    """Nothing that is read is cut off; no legend covers half of a panel, or a label."""
    renderer = figure.canvas.get_renderer()
    page = figure.bbox.padded(1.0)
    for axes in visible(figure):
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


@pytest.mark.slow
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


@pytest.mark.parametrize(
    ("values", "told"),
    [
        ([0.3, 0.35], ["0.3", "0.35"]),
        ([0.1234561, 0.5], ["0.123456", "0.5"]),
        ([0.30000001, 0.3, 0.4], ["0.3", "0.30000001", "0.4"]),
    ],
)
def test_few_series_are_told_apart(values, told):
    series = Series(values, "x")
    assert [series.label(value) for value in sorted(values)] == [f"$x = {text}$" for text in told]


def test_many_series_are_told_apart():
    rows = slipping(combined(theta=THETA, mu0=0.2 + 1e-6 * np.arange(20), eta=[0.85], dx0=[0.001]))
    (bar,) = filter(is_bar, KINDS["taper"].plot(rows).axes)
    texts = [text.get_text() for text in bar.get_yticklabels()]
    assert texts[:2] == ["0.2", "0.200001"] and len(set(texts)) == 20


def test_maps_of_near_heights_are_told_apart():
    axes = {"theta": THETA, "mu0": [0.1, 0.2], "eta": [0.9999998, 0.9999999]}
    figure = KINDS["regimes"].plot(slipping(combined(**axes, dx0=[0.001])))
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == [r"$\eta = 0.9999998$", r"$\eta = 0.9999999$"]


def test_graded_colours_get_lighter_with_the_value():
    values = [0.001, 0.002, 0.004, 0.3, 0.31, 5.0, 90.0]
    series = Series(values * 2, "x")
    lightness = [np.dot(to_rgb(series.color(value)), (0.2, 0.7, 0.1)) for value in values]
    steps = np.diff(lightness)
    assert (steps > 0.05).all()


@pytest.mark.parametrize("kind", ["law", "past_lock", "margins"])
def test_a_legend_that_has_no_room_in_the_axes_is_below(kind):
    figure = drawn(kind, 1)
    assert len(figure.legends) == 1 and not any(axes.get_legend() for axes in figure.axes)


@pytest.mark.parametrize(("count", "inside"), [(1, True), (3, True), (4, False), (6, False)])
@pytest.mark.parametrize("kind", ["taper", "models"])
def test_a_legend_of_few_series_is_beside_the_data(kind, count, inside):
    figure = drawn(kind, count)
    assert (figure.axes[0].get_legend() is not None) is inside
    assert len(figure.legends) == (0 if inside else 1)


@pytest.mark.parametrize("changed", [{"status": "lock"}, {"mu_lock": np.inf}])
def test_a_law_without_an_onset_below_a_lock_says_so(changed):
    figure = KINDS["law"].plot(ROWS["law"](2).assign(**changed))
    (text,) = figure.axes[0].texts
    assert text.get_text() == "there is no onset of slip below a lock" and len(figure.axes) == 1


def test_an_asymptote_is_drawn_where_the_rod_is_followed_past_the_lock():
    def dashed(rows):
        axes, _ = KINDS["past_lock"].plot(rows).axes
        return [
            line for line in axes.lines if line.get_linestyle() == "--" and len(line.get_xdata())
        ]

    rows = ROWS["past_lock"](2)
    assert len(dashed(rows)) == 2
    assert dashed(rows[rows.status == "slip"]) == []
    assert len(dashed(rows[rows.status == "lock"].groupby("theta").head(1))) == 2
    never = rows.theta == 3.0
    lifts = rows.assign(mu_lock=rows.mu_lock.where(~never, np.inf))
    assert len(dashed(lifts[~never | (lifts.status == "slip")])) == 1


@pytest.mark.parametrize(
    ("heights", "ahead", "lines"),
    [
        (2, [-0.1, 0.1, 0.2], 1),
        (3, [-0.1, 0.1, 0.2], 1),
        (1, [-0.1, 0.1, 0.2], 0),
        (2, [0.1, 0.2, 0.3], 0),
        (2, [-0.3, -0.2, -0.1], 0),
        (2, [0.0, 0.1, 0.2], 0),
        (2, [-0.2, -0.1, 0.0], 0),
    ],
)
def test_a_line_shows_where_neither_cone_nor_cylinder_is_ahead(heights, ahead, lines):
    angle = [-0.1, 0.0, 0.1]
    rows = combined(theta=[1.0, 2.0], eta=np.linspace(0.3, 0.9, heights), clamp_angle=angle)
    lock = np.where(
        rows.theta == 2.0, rows.clamp_angle.map(dict(zip(angle, ahead, strict=True))), 0.0
    )
    others = dict.fromkeys(("clamp_compliance", "curvature", "stage_angle"), 0.0)
    axes = KINDS["versus"].plot(rows.assign(mu_lock=lock, **others)).axes[0]
    shown = [one for one in axes.collections if isinstance(one, ContourSet)]
    assert len(shown) == lines


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


@pytest.mark.parametrize("kind", ["change", "versus"])
def test_a_map_of_one_height_shows_its_values(kind):
    figure = KINDS[kind].plot(ROWS[kind](1))
    for axes in figure.axes[:2]:
        (mesh,) = axes.collections
        (_, low), (_, high) = mesh.get_datalim(axes.transData).get_points()
        assert (low, high) == pytest.approx((0.27, 0.33))


def test_a_map_of_one_mounting_has_a_cell_around_zero():
    rows = ROWS["versus"](3)
    axes = KINDS["versus"].plot(rows[rows.clamp_angle == 0.0]).axes[0]
    (low, _), (high, _) = axes.collections[0].get_datalim(axes.transData).get_points()
    assert (low, high) == pytest.approx((-0.1, 0.1))


@pytest.mark.parametrize(
    ("lost", "told"),
    [
        (1, "without a lock: $\\eta$ = 0.9"),
        (5, "without a lock: $\\eta$ = 0.5, 0.6, 0.7, 0.8, 0.9"),
        (6, "without a lock: 6 values of $\\eta$ from 0.4 to 0.9"),
    ],
)
@pytest.mark.parametrize("none", [np.inf, np.nan])
def test_heights_without_a_lock_take_no_colours(lost, told, none):
    rows = ROWS["locking"](7)
    heights = sorted(set(rows.eta))
    kept = rows.eta < heights[7 - lost]
    (axes,) = KINDS["locking"].plot(rows.assign(mu_lock=rows.mu_lock.where(kept, none))).axes
    assert axes.get_title() == told
    assert [line.get_color() for line in axes.lines] == list(style.COLORS[: 7 - lost])
    assert len(axes.get_legend().get_texts()) == 7 - lost


def test_where_no_tip_locks_the_figure_says_so():
    (axes,) = KINDS["locking"].plot(ROWS["locking"](2).assign(mu_lock=np.inf)).axes
    assert axes.texts[0].get_text() == "no tip locks"


@pytest.mark.parametrize(
    ("kind", "status", "marker"),
    [
        ("taper", "slip", "_"),
        ("friction", "slip", "_"),
        ("past_lock", "slip", "o"),
        ("past_lock", "lock", "o"),
    ],
)
def test_a_single_point_is_seen(kind, status, marker):
    rows = ROWS[kind](1)
    figure = KINDS[kind].plot(rows[rows.status == status].head(1))
    for axes in figure.axes:
        point = next(line for line in axes.lines if len(line.get_xdata()) == 1)
        assert point.get_marker() == marker and np.isfinite(point.get_ydata()).all()
    several = KINDS[kind].plot(ROWS[kind](6)).axes[0].lines[0]
    assert len(several.get_xdata()) > 1 and several.get_marker() in ("", "None")


def test_states_have_their_numbers_their_names_or_a_colourbar():
    one, six, seven = (drawn("state", count) for count in (1, 6, 7))
    assert "f = 2.7" in one.axes[0].texts[0].get_text()
    names = [text.get_text() for text in six.legends[0].get_texts()]
    assert names[0] == "state_0_with_a_…er_long_name_0" and len(set(names)) == 7
    assert max(map(len, names[:-1])) == 30
    assert len(seven.axes) == 2


@pytest.mark.parametrize(
    ("lost", "told"),
    [
        (0, ""),
        (1, "\nwithout a result: state_0_with_a_…er_long_name_0"),
        (2, "\nwithout a result: 2 states"),
    ],
)
def test_states_without_a_result_are_told(lost, told):
    rows = states(6)
    rows = rows.assign(status=np.where(rows.index < lost, "failed", "solved"))
    figure = KINDS["state"].plot(rows)
    assert figure.axes[0].get_title() == rf"$\theta = 1$, $y_1 = 0.85${told}"
    laid_out(figure)
    inside_the_page(figure)


def test_states_of_several_tapers_are_told_by_taper():
    rows = states(8).assign(theta=np.linspace(1.0, 2.0, 8))
    figure = KINDS["state"].plot(rows)
    assert figure.axes[1].get_ylabel() == r"$\theta$"
    assert figure.axes[0].get_title() == "$y_1 = 0.85$"


@pytest.mark.parametrize(
    ("axis", "unit", "label"),
    [
        ("clamp_angle", 180.0 / np.pi, "degree"),
        ("stage_angle", 180.0 / np.pi, "degree"),
        ("clamp_compliance", 1.0, "$L/(E I_0)$"),
        ("curvature", 1.0, r"$\kappa_0 L$"),
    ],
)
def test_an_axis_of_the_mounting_is_shown_in_its_unit(axis, unit, label):
    rows = ROWS["mounting"](3)
    values = rows["clamp_angle"]
    figure = KINDS["mounting"].plot(rows.assign(clamp_angle=0.0).assign(**{axis: values}))
    shown = figure.axes[0].lines[0].get_xdata()
    assert np.unique(shown) == pytest.approx(np.unique(values) * unit)
    assert figure.get_supxlabel().endswith(label)


@pytest.mark.parametrize("count", [3, 12])
@pytest.mark.parametrize(
    ("without", "drawn", "told"),
    [
        (["x0_slip", "reaction_fx_slip", "reaction_fy_slip", "reaction_m_slip"], 1, "no tip slips"),
        (["mu_lock"], 4, r"onset of slip at $\mu_0 = 0.2$; no tip locks"),
        ([], 5, r"onset of slip at $\mu_0 = 0.2$"),
    ],
)
def test_what_no_mounting_has_is_said_and_takes_no_room(without, drawn, told, count):
    rows = ROWS["mounting"](count).assign(**dict.fromkeys(without, np.nan))
    # A tip that lifts off before it locks has no lock, either.
    figure = KINDS["mounting"].plot(rows.replace({"mu_lock": np.nan}, np.inf))
    panels = [axes for axes in figure.axes if axes.lines]
    assert len(panels) == drawn and len(figure.axes) == drawn + (count > len(style.COLORS))
    assert all(np.isfinite(line.get_ydata()).all() for axes in panels for line in axes.lines[:3])
    assert figure.get_figheight() == pytest.approx({1: 3.2, 4: 5.2, 5: 7.2}[drawn])
    # Each column of panels has its numbers below.
    assert [axes for axes in panels if axes.xaxis.get_tick_params()["labelbottom"]] == panels[-2:]
    title = figure.get_suptitle() or figure.legends[0].get_title().get_text()
    assert told in title


def test_what_one_mounting_has_is_drawn():
    rows = ROWS["mounting"](3)
    one = rows.assign(x0_slip=rows.x0_slip.where(rows.clamp_angle == 0.0))
    assert len(KINDS["mounting"].plot(one).axes) == 5


@pytest.mark.parametrize("penetrates", [True, False])
@pytest.mark.parametrize("count", [3, 40])
def test_states_have_a_legend_where_it_has_something_to_say(count, penetrates):
    figure = KINDS["state"].plot(ROWS["state"](count).assign(penetrates=penetrates))
    said = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    names = count if count <= len(style.COLORS) else 0
    assert len(said) == names + penetrates
    assert ("hollow: passes through the surface" in said) == penetrates
