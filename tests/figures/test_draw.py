"""Each kind of figure shows what its table has."""

import itertools
from functools import cache

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex
from matplotlib.text import Text
from PIL import Image, ImageSequence

import made_tables
from figure_rows import ROWS, THETA, both_contacts, combined, slipping, states
from vibrissa import solve_curve, solve_state, stick_slip
from vibrissa.computing.comparisons import comparison_table
from vibrissa.computing.scans import scan_tables
from vibrissa.computing.states import states_table
from vibrissa.errors import ArgumentError
from vibrissa.figures import animation, labels, style
from vibrissa.figures.draw import KINDS, animate, draw
from vibrissa.figures.periods import TEETH, amplitudes
from vibrissa.figures.regimes import REGIMES
from vibrissa.scanning import SlipModel, move, stage_maker, surfaces
from vibrissa.sticking.comparison import compare
from vibrissa.sticking.curve import failed_curve
from vibrissa.study.chunks import spell_powers

MU0 = (0.2, 0.3, 0.4, 0.9)
FAILED = failed_curve(theta=2.0, eta=0.05, method="collocation", message="no luck")


def grid(theta=(1.0, 2.0, 3.0), mu0=MU0, dx0=(0.001, 0.005), eta=(0.85,)):
    return made_tables.grid(theta, mu0, eta, dx0)


def points_table(grids, curves):
    parts = [
        made_tables.points(name, axes, "a", [curves[theta] for theta in axes["theta"]])
        for name, axes in grids.items()
    ]
    table = pa.concat_tables(parts)
    # Rows in no order that a figure could rely on
    return table.take(np.random.default_rng(1).permutation(len(table)))


def scanned(curve, theta, mu0):
    point = {name: one for name, (one,) in grid((theta,), (mu0,), (0.01,)).items()}
    scan = stick_slip(curve, mu0, 0.01, 3)
    point |= {"surface": "plane", "law": "free"}
    return scan_tables("runs", point, scan, study="a", method=curve.method, shapes=True).steps


@cache
def curve_of(theta):
    return solve_curve(float(theta), 0.85)


@cache
def points():
    curves = {theta: curve_of(theta) for theta in (1.0, 2.0, 3.0)}
    return points_table({"main": grid(mu0=MU0[:3]), "locks": grid(theta=(2.0,))}, curves)


@cache
def scans():
    made = [scanned(curve_of(theta), theta, mu0) for theta in (2.0, 3.0) for mu0 in (0.3, 0.9)]
    return pa.concat_tables([*made, scanned(FAILED, 1.0, 0.3)])


def rows(table, **values):
    """Rows of a table with the given values, as pandas has them."""
    frame = table.to_pandas()
    for name, value in values.items():
        frame = frame[frame[name] == value]
    assert len(frame)
    return frame


def drawn(axes):
    """Lines that show data."""
    return [line for line in axes.lines if len(line.get_xdata())]


def is_line(line, x, y):
    return np.array_equal(line.get_xdata(), x) and np.array_equal(line.get_ydata(), y)


def legend_of(figure):
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def names_of(axes):
    """Names at the ends of lines, with their colours."""
    return {
        text.get_text(): text.get_color() for text in axes.texts if text.get_gid() == style.NAMED
    }


def test_taper_figure_shows_marks_and_onset_of_each_friction_that_is_chosen():
    chosen = {"grid": "main", "dx0": [0.001], "mu0": [0.2, 0.4], "theta": [1.0, 2.0]}
    figure = draw("taper", points(), chosen)
    lines = drawn(figure.axes[0])
    assert [line.get_marker() for line in lines] == ["", "", "s", "D"]
    for mu0, onset, marks in zip((0.2, 0.4), lines[:2], lines[2:], strict=True):
        found = rows(points(), grid="main", dx0=0.001, mu0=mu0).sort_values("theta")[:2]
        assert is_line(onset, found["theta"], found["x0_slip"])
        assert is_line(marks, found["theta"], found["x0_max"])
        assert names_of(figure.axes[0])[rf"$\mu_0 = {mu0:g}$"] == marks.get_color()
    assert not any("mu_0" in text for text in legend_of(figure))


def lost(made, columns):
    """Some points without an onset, in one of some columns with a status."""
    for column, place, status in zip(
        columns, range(3), ("lock", "failed", "out_of_reach"), strict=True
    ):
        made.loc[made.index[place], column] = status
    return made


TWICE = ("status_line", "status_point", "status_line")


@pytest.mark.parametrize(("kind", "columns"), [("taper", ["status"] * 3), ("models", TWICE)])
def test_failed_locked_and_out_of_reach_look_different(kind, columns):
    axes = combined(theta=THETA, mu0=[0.2, 0.4], eta=[0.85], dx0=[0.001])
    made = slipping(axes).assign(status="slip") if kind == "taper" else both_contacts(2)
    plot = KINDS[kind].plot
    assert not plot(made).axes[0].child_axes
    figure = plot(lost(made, columns))
    (strip,) = figure.axes[0].child_axes
    assert {line.get_marker() for line in strip.lines} == {"|", "x", "_"}
    assert sum(len(line.get_xdata()) for line in strip.lines) == 3
    assert {"locks", "failed", "out of reach"} < set(legend_of(figure))


@pytest.mark.parametrize("largest", [0.5, 0.9])
def test_friction_figure_shows_levels_onset_and_lock(largest):
    mu0 = tuple(round(0.1 + i / 500, 3) for i in range(int((largest - 0.1) * 500) + 1))
    table = points_table({"fine": grid((2.0,), mu0, (0.001,))}, {2.0: curve_of(2.0)})
    figure = draw("friction", table, {"grid": "fine"})
    panel, enlarged = figure.axes
    marks, onset, lock = drawn(panel)
    slips = rows(table, status="slip").sort_values("mu0")
    assert is_line(marks, slips["mu0"], slips["x0_max"])
    assert is_line(onset, slips["mu0"], slips["x0_slip"])
    assert lock.get_xdata() == [curve_of(2.0).mu_lock] * 2
    assert rf"locks above $\mu_\mathrm{{lock}} = {curve_of(2.0).mu_lock:.4f}$" in legend_of(figure)
    # The enlarged levels are whole, and no mark lies on the edge.
    near = drawn(enlarged)[0]
    assert len(np.unique(near.get_ydata())) == 7
    (left, right), (low, high) = enlarged.get_xlim(), enlarged.get_ylim()
    assert left < min(near.get_xdata()) and max(near.get_xdata()) < right
    assert low < min(near.get_ydata()) and max(near.get_ydata()) < high


def test_a_friction_figure_of_few_levels_has_one_panel_and_marks_what_failed():
    made = ROWS["friction"](9).assign(dx0=0.01)
    made = made.assign(n_steps=made.x0_slip // 0.01)
    made.loc[made.index[2], "status"] = "failed"
    figure = KINDS["friction"].plot(made)
    assert len(figure.axes) == 1 and "failed" in legend_of(figure)


def shapes_in(axes):
    """Shapes that begin and end a period."""
    lines = [one for one in axes.collections if isinstance(one, LineCollection)]
    by_color = {to_hex(one.get_edgecolor()[0]): one.get_segments() for one in lines}
    return [by_color[color] for color in (style.START, style.END)]


def area_in(axes):
    """Corners of the area over which the rod passes while its tip sticks."""
    areas = [one for one in axes.collections if isinstance(one, PolyCollection)]
    areas = [one for one in areas if style.SHAPE in map(to_hex, one.get_facecolor())]
    return np.concatenate([path.vertices for one in areas for path in one.get_paths()])


def slips_in(axes):
    """Beginning and end of each slip that is drawn."""
    (arcs,) = [line.get_xdata() for line in axes.lines if np.isnan(line.get_xdata()).any()]
    gaps = np.flatnonzero(np.isnan(arcs))
    return list(zip(arcs[np.append(0, gaps[:-1] + 1)], arcs[gaps - 1], strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("mu0", [0.3, 0.9])
def test_scan_figures_have_a_panel_for_each_taper(mu0):
    chosen = {"scan": "runs", "theta": [2.0, 3.0], "mu0": [mu0]}
    figure = draw("scan", scans(), chosen)
    for theta, axes in zip((2.0, 3.0), figure.axes, strict=True):
        found = rows(scans(), theta=theta, mu0=mu0).sort_values("footpoint")
        begin, end = shapes_in(axes)
        sticking = found[found["phase"] == "stick"]
        last = sticking.groupby("cycle").tail(1)
        assert len(begin) == (found["x0"] == 0).sum() and len(end) == len(last)
        assert np.array_equal(end[0][:, 0], last["shape_x"].iloc[0])
        assert rf"$\theta = {theta:g}$" in axes.get_title("left")
        after = found[found["phase"] == "slip"]
        starts, stops = zip(*slips_in(axes), strict=True)
        assert list(stops) == pytest.approx(list(after["x1"]))
        assert list(starts) == pytest.approx(list(last["x1"][: len(after)]))
        length = rf"$x_\mathrm{{0,max}}$ = {last['x0'].iloc[0]:g}"
        assert length in [text.get_text() for text in axes.texts]


@pytest.mark.slow
def test_all_figures_of_a_scan_have_one_scale_and_the_same_axes():
    tapers, frictions = (2.0, 3.0), (0.2, 0.3)
    parts = [scanned(curve_of(theta), theta, mu0) for theta in tapers for mu0 in frictions]
    scales, limits = [], []
    for chosen in ({"mu0": [0.3]}, {"mu0": [0.2]}, {"mu0": [0.2], "theta": [2.0]}, {}):
        figure = draw("scan", pa.concat_tables(parts), {"scan": "runs", **chosen})
        style.save(figure, [])
        for axes in figure.axes:
            width = axes.get_position().width * figure.get_figwidth()
            scales.append(width / np.ptp(axes.get_xlim()))
            # A single panel has room for names on its right.
            right = axes.get_xlim()[1] if len(figure.axes) > 1 else None
            limits.append((axes.get_xlim()[0], right, *axes.get_ylim()))
    assert scales == pytest.approx([scales[0]] * (2 + 2 + 1 + 4), rel=0.02)
    assert len({limit for limit in limits if limit[1]}) == 1
    assert len({(left, low, high) for left, _, low, high in limits}) == 1


@pytest.mark.parametrize("mu0", [0.3, 0.9])
def test_period_figure_shows_the_first_period_of_sticking(mu0):
    figure = draw("period", scans(), {"scan": "runs", "theta": [2.0], "mu0": [mu0]})
    found = rows(scans(), theta=2.0, mu0=mu0, cycle=1, phase="stick").sort_values("footpoint")
    (begin, after), (end,) = shapes_in(figure.axes[0])
    assert np.array_equal(begin[:, 0], found["shape_x"].iloc[0])
    assert np.array_equal(end[:, 0], found["shape_x"].iloc[-1])
    slipped = rows(scans(), theta=2.0, mu0=mu0, cycle=1, phase="slip").iloc[0]
    assert np.array_equal(after[:, 0], slipped["shape_x"])
    # The area in which the rod was while its tip stuck.
    corners, across = area_in(figure.axes[0])[:, 0], np.concatenate(list(found["shape_x"]))
    extent = pytest.approx((across.min(), across.max()), abs=0.01)
    assert (corners.min(), corners.max()) == extent


def test_a_scan_without_a_result_is_named_beside_the_others():
    for kind in ("scan", "period"):
        figure = draw(kind, scans(), {"scan": "runs", "mu0": [0.3]})
        assert len(figure.axes) == 2 and r"no result: $\theta = 1$" in legend_of(figure)


def test_a_scan_may_have_many_panels():
    rows = pd.concat([ROWS["scan"](1).assign(theta=theta) for theta in range(1, 8)])
    assert KINDS["scan"].plot(rows).axes[6].get_title("left").startswith("(g)")


def test_state_figure_shows_shape_contact_and_clamp_to_scale():
    found = {"inside": solve_state(1, 0.55, 0.15), "outside": solve_state(1, 0.55, 0.45)}
    table = states_table(found, "a")
    figure = draw("state", table, {"state": [*found]})
    (axes,) = figure.axes
    assert axes.get_aspect() == 1 and {"$x_1 = 0.15$", "$x_1 = 0.45$"} <= set(legend_of(figure))
    lines = drawn(axes)
    forces = [text.get_text() for text in axes.texts if text.get_text().startswith("$f = ")]
    for row, force in zip(table.to_pylist(), forces, strict=True):
        assert any(is_line(line, row["shape_x"], row["shape_y"]) for line in lines)
        (contact,) = (line for line in lines if is_line(line, [row["x1"]], [row["eta"]]))
        assert (contact.get_markerfacecolor() == "white") == row["penetrates"]
        assert force == f"$f = {row['f']:.1f}$"
    beyond = [line for line in lines if line.get_color() == style.WARNING and line.get_alpha()]
    assert len(beyond) == sum(state.penetrates for state in found.values())
    assert np.nanmin(beyond[0].get_ydata()) > 0.55
    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    for line in lines[1:]:
        assert x_low <= np.nanmin(line.get_xdata()) and np.nanmax(line.get_xdata()) <= x_high
        assert y_low <= np.nanmin(line.get_ydata()) and np.nanmax(line.get_ydata()) <= y_high


def test_states_without_a_result_are_named_and_many_have_a_colourbar():
    six = states(6)
    figure = KINDS["state"].plot(six.assign(status=np.where(six.index < 2, "failed", "solved")))
    lost = [text for text in legend_of(figure) if text.startswith("no result: ")]
    assert len(lost) == 2
    tapers = KINDS["state"].plot(states(8).assign(theta=np.linspace(1.0, 2.0, 8)))
    assert tapers.axes[1].get_ylabel() == r"$\theta$"


@pytest.mark.parametrize("selection", [{"grid": "none"}, {"grid": "main", "dx0": [0.002]}])
def test_nothing_to_draw_is_refused(selection):
    with pytest.raises(ArgumentError, match="for a figure of kind taper"):
        draw("taper", points(), selection)


@pytest.mark.parametrize(
    ("kind", "selection"),
    [("scan", {"scan": "runs", "theta": [1.0]}), ("friction", {"grid": "main", "dx0": [0.001]})],
)
def test_a_figure_of_what_failed_gives_the_reason(kind, selection):
    table = points_table({"main": grid(theta=(9.0,))}, {9.0: FAILED})
    (text,) = draw(kind, scans() if kind == "scan" else table, selection).axes[0].texts
    reason = "the tables and logs have the reason" if kind == "scan" else "no luck"
    assert text.get_text() == f"failed: {reason}"


@cache
def plane():
    """Points in every regime: point and line contact, slipping and locked."""
    parts = []
    for theta in (1.0, 3.0, 5.0):
        for eta in (0.7, 0.85):
            curve = solve_curve(float(theta), float(eta), contact="line")
            axes = grid(theta=(theta,), mu0=(0.1, 0.4, 0.6), eta=(eta,))
            parts.append(points_table({"plane": axes}, {theta: curve}))
    return pa.concat_tables(parts)


def test_locking_figure_shows_a_curve_for_each_height():
    (axes,) = draw("locking", plane(), {"grid": "plane"}).axes
    shown = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    for eta in (0.7, 0.85):
        known = rows(plane(), eta=eta).drop_duplicates("theta").sort_values("theta")
        assert list(shown[rf"$\eta = {eta}$"]) == list(known["mu_lock"])


def test_regime_map_colours_each_point_and_nothing_beyond_the_grid():
    figure = draw("regimes", plane(), {"grid": "plane"})
    seen = set()
    for axes, eta in zip(figure.axes, (0.7, 0.85), strict=True):
        (mesh,) = axes.collections
        assert mesh.get_rasterized()
        assert (axes.get_xlim(), axes.get_ylim()) == ((1.0, 5.0), (0.1, 0.6))
        field = mesh.get_array().reshape(3, 3)
        for row in rows(plane(), eta=eta).to_dict("records"):
            place = [0.1, 0.4, 0.6].index(row["mu0"]), [1, 3, 5].index(row["theta"])
            slips = {"point": 0, "line": 1}[row["contact"]]
            expected = 6 if row["status"] == "lock" else slips
            assert field[place] == expected
            seen.add(expected)
    assert seen == {0, 1, 6}
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert shown == [REGIMES[i] for i in (0, 1, 6)]


def test_the_law_is_drawn_beside_powers_and_follows_a_square_root():
    mu0 = tuple(round(0.4 + 0.0005 * i, 4) for i in range(160))
    table = points_table({"lock": grid((2.0,), mu0, (0.001,))}, {2.0: curve_of(2.0)})
    _, near = draw("law", table, {"grid": "lock"}).axes
    dots, half, one = near.lines
    slopes = []
    for line in (dots, half, one):
        x, y = np.log(line.get_xdata()), np.log(line.get_ydata())
        slopes.append((y[1] - y[0]) / (x[1] - x[0]))
    assert slopes == pytest.approx([0.5, 0.5, 1.0], abs=0.03)


def test_past_the_lock_sticking_ends_where_a_trailing_or_a_planar_rod_slips():
    for section in ("round", "planar"):
        curve = solve_curve(2.0, 0.85, section=section)
        table = points_table({"g": grid((2.0,), (0.3, 0.6, 0.9), (0.001,))}, {2.0: curve})
        first, later = draw("past_lock", table, {"grid": "g"}).axes
        slips, locked, swing, *_ = (line.get_ydata() for line in drawn(first))
        assert slips == pytest.approx(curve.onset([0.3]))
        (asymptote,) = first.collections[0].get_segments()
        assert asymptote[:, 1] == pytest.approx([curve.x0_lock, locked[0]])
        if section == "round":
            trail = curve.trailing_end([0.6, 0.9]).x0
            assert locked == pytest.approx(trail) and swing == pytest.approx([curve.x0_end] * 2)
            assert drawn(later)[1].get_ydata() == pytest.approx(trail - 2.0 * curve.x0_end)
        else:
            assert locked == pytest.approx([curve.x0_end] * 2) and np.isnan(swing).all()


def test_margins_are_those_of_the_first_period():
    axes = draw("margins", scans(), {"scan": "runs", "mu0": [0.9], "theta": [2.0]}).axes[1]
    found = rows(scans(), theta=2, mu0=0.9, cycle=1, phase="stick").sort_values("footpoint")
    assert is_line(drawn(axes)[0], found["footpoint"], found["stability_aside"])


def test_a_line_ends_where_contact_jumps_to_the_flank():
    table = pd.DataFrame({"footpoint": [0.0, 0.1, 0.2, 0.3], "s_c": [1.0, 1.0, 0.6, 0.5]})
    table = table.assign(theta=4.0, mu0=0.4, eta=0.85, cycle=1, phase="stick", step=range(4))
    table = table.assign(frequency_1=[20.0, 19.0, 25.0, 26.0], frequency_2=np.nan)
    line, *_ = drawn(KINDS["ringing"].plot(table).axes[0])
    assert line.get_xdata() == pytest.approx([0.0, 0.1, 0.15, 0.2, 0.3])
    assert np.array_equal(line.get_ydata(), [20.0, 19.0, np.nan, 25.0, 26.0], equal_nan=True)


@pytest.mark.slow
def test_a_rod_that_swings_aside_keeps_its_shape_while_its_plane_turns():
    chosen = {"scan": "runs", "theta": [2.0], "mu0": [0.9]}
    oblique, above, _ = draw("swing", scans(), chosen).axes
    turned = [line for line in above.lines if line.get_linewidth() == 1.4]
    found = rows(scans(), theta=2, mu0=0.9, cycle=1, phase="stick")
    before = found[found["x1"] > found["footpoint"]].sort_values("footpoint").iloc[-1]
    out = np.array(before["shape_x"]) - before["footpoint"]
    directions = []
    for line in turned:
        x, z = line.get_xdata() - before["footpoint"], np.asarray(line.get_ydata())
        assert np.hypot(x, z) == pytest.approx(np.abs(out))
        far = np.argmax(np.abs(out))
        directions.append(np.degrees(np.arctan2(z[far], x[far]) - np.arctan2(0.0, out[far])))
    assert np.mod(directions, 360.0) == pytest.approx(np.arange(0.0, 181.0, 30.0), abs=1e-9)
    upright = [line for line in oblique.lines if line.get_color() == turned[3].get_color()]
    assert upright[0].get_ydata() - 0.3 * out == pytest.approx(before["shape_y"])
    (text,) = draw("swing", scans(), chosen | {"mu0": [0.3]}).axes[0].texts
    assert text.get_text() == "the scan has no states after lateral buckling"


def test_models_figure_marks_what_penetrates():
    table = comparison_table("models", compare([1, 4, 8], [0.2], [0.85]), "a")
    figure = draw("models", table, {"comparison": "models"})
    line, marks = drawn(figure.axes[0])
    assert np.isfinite(line.get_ydata()).all() and marks.get_ydata()[2] > 30
    assert np.isfinite(marks.get_ydata()).tolist() == [False, False, True]
    locks = [table.to_pandas()[name] for name in ("mu_lock_point", "mu_lock_line")]
    for line, known in zip(drawn(figure.axes[1]), locks, strict=True):
        assert is_line(line, [1, 4, 8], known)


def test_signals_of_a_locking_tip_show_its_stability_fall():
    figure = draw("signals", scans(), {"scan": "runs", "theta": [2.0], "mu0": [0.9]})
    assert abs(figure.axes[0].lines[0].get_ydata()).max() < 0.9
    inside, aside = (line.get_ydata() for line in figure.axes[2].lines)
    # Where the rod swings aside only the margin out of the plane is near zero.
    assert inside.min() > 0.3 > 0.05 > aside.min() > 0


@pytest.mark.parametrize(("axis", "unit"), [("clamp_angle", 180.0 / np.pi), ("curvature", 1.0)])
def test_a_mounting_is_shown_in_its_unit_and_what_no_rod_has_takes_no_room(axis, unit):
    made = ROWS["mounting"](3)
    values = made["clamp_angle"]
    made = made.assign(clamp_angle=0.0, mu_lock=np.inf).assign(**{axis: values})
    figure = KINDS["mounting"].plot(made)
    panels = [panel for panel in figure.axes if panel.axison]
    assert len(panels) == 4
    assert np.unique(drawn(panels[0])[0].get_xdata()) == pytest.approx(np.unique(values) * unit)


@pytest.mark.parametrize(("ahead", "lines"), [([-0.1, 0.1, 0.2], 1), ([0.0, 0.1, 0.2], 0)])
def test_a_line_shows_where_neither_cone_nor_cylinder_is_ahead(ahead, lines):
    made = ROWS["versus"](2)
    angles = sorted(set(made.clamp_angle))[:3]
    made = made[(made.theta <= 2.5) & made.clamp_angle.isin(angles)]
    order = dict(zip(angles, ahead, strict=True))
    lock = np.where(made.theta == 2.5, 0.5 + made.clamp_angle.map(order), 0.5)
    panel = KINDS["versus"].plot(made.assign(mu_lock=lock)).axes[0]
    assert len(panel.collections) == 1 + lines
    assert panel.collections[0].get_array().filled().reshape(2, 3)[0] == pytest.approx(ahead)
    # The colours reach as far as the changes, both ways.
    most = np.abs(ahead).max()
    assert panel.collections[0].get_clim() == pytest.approx((-most, most))


def test_a_change_is_in_per_cent_of_the_ideal_mounting():
    made = ROWS["change"](3)
    made = made.assign(mu_lock=np.where(made.clamp_angle == 0.0, 0.5, 0.55), x0_slip=np.nan)
    lock, onset = (panel.collections[0] for panel in KINDS["change"].plot(made).axes[:2])
    assert lock.get_array().filled() == pytest.approx(10.0) and onset.get_array().mask.all()


SCRIPT = "import matplotlib.pyplot as plt\n\n\ndef draw(table):\n"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("    return table.nothing\n", r"mine.py:5: AttributeError: .*'nothing'"),
        ("    return 3\n", "mine.py: draw returns int; needed: a matplotlib Figure"),
    ],
)
def test_a_script_that_fails_is_named_with_its_line(tmp_path, body, message):
    (tmp_path / "mine.py").write_text(SCRIPT + body)
    with pytest.raises(ArgumentError, match=message):
        draw("script", points(), {"grid": "main"}, script=tmp_path / "mine.py")


def test_a_script_gets_the_rows_and_the_style(tmp_path):
    body = "    figure, axes = plt.subplots()\n    axes.plot(table.theta, table.mu0, 'o')\n"
    (tmp_path / "mine.py").write_text(SCRIPT + body + "    return figure\n")
    look = {"size": [4.0, 2.0], "axes": {"x": [0.5, 9.0], "log": ["y"]}}
    chosen = {"grid": "main", "mu0": [0.2]}
    figure = draw("script", points(), chosen, script=tmp_path / "mine.py", look=look)
    (axes,) = figure.axes
    assert len(axes.lines[0].get_xdata()) == 6 and not axes.spines["top"].get_visible()
    assert tuple(figure.get_size_inches()) == (4.0, 2.0)
    assert axes.get_xlim() == (0.5, 9.0) and axes.get_yscale() == "log"
    zero, *_ = draw("taper", points(), {"grid": "main"}, look={"axes": {"log": ["y"]}}).axes
    assert 1e-3 < zero.get_ylim()[0] < zero.dataLim.y0 + 0.01


def test_a_law_needs_a_lock():
    lifts = points_table({"main": grid(theta=(1.0,), eta=(0.1,))}, {1.0: solve_curve(1.0, 0.1)})
    assert draw("law", lifts, {"grid": "main"}).axes[0].texts[0].get_text() == "no tip locks"


def test_a_series_without_a_point_that_slips_is_named():
    figure = draw("past_lock", points(), {"grid": "locks", "mu0": [0.9]})
    assert {*names_of(figure.axes[0])} == {r"$\theta = 2$"}


def test_a_curvature_is_chosen_with_its_powers(tmp_path):
    (tmp_path / "mine.py").write_text(
        f"{SCRIPT}    figure, axes = plt.subplots()\n    axes.plot(table.mu0)\n    return figure\n"
    )
    rows = points().to_pylist()
    for row in rows[::3]:
        row["curvature_powers"] = spell_powers([0.0, 0.3])
    table = pa.Table.from_pylist(rows, schema=points().schema)
    for curvature, number in (([0.0], len(rows) - len(rows[::3])), ([[0.0, 0.3]], len(rows[::3]))):
        figure = draw("script", table, {"curvature": curvature}, script=tmp_path / "mine.py")
        assert len(figure.axes[0].lines[0].get_xdata()) == number
        assert tuple(figure.get_size_inches()) == (3.5, 2.6)


@pytest.mark.parametrize("kind", ["locking", "models", "past_lock", "margins"])
def test_single_points_are_seen(kind):
    line = drawn(KINDS[kind].plot(ROWS[kind](1).head(1)).axes[0])[0]
    assert line.get_marker() == "o"


def test_a_single_state_has_its_angle_and_a_name_is_needed_only_for_several():
    found = {"inside": solve_state(1, 0.55, 0.15)}
    figure = draw("state", states_table(found, "a"), {"state": [*found]})
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert rf"$\varphi_1 = {found['inside'].phi1:.3f}$" in texts and not figure.legends


def test_states_are_named_by_what_differs_and_else_by_their_own_names():
    tip, line = solve_state(1, 0.55, 0.15), solve_state(1, 0.55, 0.15, contact="line")
    for found, names in (
        ({"a_b": tip, "c": line}, ["tip contact", "line contact"]),
        ({"a_b": line, "c": line}, ["A b", "C"]),
    ):
        figure = draw("state", states_table(found, "a"), {"state": [*found]})
        assert legend_of(figure) == names


def test_names_at_lines_follow_the_limits_of_a_study_file():
    looks = {5.0: {}, 3.0: {"axes": {"x": [1.0, 3.0]}}}
    for last, look in looks.items():
        (axes,) = draw("locking", plane(), {"grid": "plane"}, look=look).axes
        assert {*names_of(axes)} == {r"$\eta = 0.7$", r"$\eta = 0.85$"}
        for text in axes.texts:
            (line,) = (line for line in axes.lines if line.get_label() == text.get_text())
            x, y = axes.transData.inverted().transform(axes.transAxes.transform(text.xy))
            assert x == pytest.approx(last)
            assert y == pytest.approx(line.get_ydata()[list(line.get_xdata()).index(last)])


def test_slopes_are_derivatives_at_the_ideal_mounting_and_bent_lines_are_drawn():
    """Made-up lines: 0.5 − β for μ_lock; 1 + 2β + 40β² for the onset."""
    made = ROWS["slopes"](2)
    beta, degree = made.clamp_angle, np.radians(1.0)
    made = made.assign(mu_lock=0.5 - beta, x0_slip=1.0 + 2.0 * beta + 40.0 * beta**2)
    loads = {"fx": 3.0, "fy": -4.0, "m": 1.0 + 20.0 * beta}
    made = made.assign(**{f"reaction_{name}_slip": load for name, load in loads.items()})
    table, *bent = KINDS["slopes"].plot(made).axes
    numbers = [text.get_text() for text in table.texts]
    for slope in (-100.0 * degree / 0.5, 200.0 * degree, 2000.0 * degree / 5.0):
        assert numbers.count(f"{slope:+.1f}".replace("-", "−")) == 4
    # Only the onset leaves its tangent by more than 15 %: by 40 %.
    shown = [axes.get_title("left") for axes in bent if axes.get_visible()]
    assert len(shown) == 2 and all("x_{0" in title for title in shown)
    assert len(table.patches) == 4
    assert len(KINDS["slopes"].plot(made.assign(x0_slip=1.0 + beta)).axes) == 1


def test_one_value_far_beyond_the_others_does_not_set_the_scale_and_is_written():
    made = ROWS["change"](20)
    is_far = (made.clamp_angle > 0.0) & (made.theta == THETA[3]) & (made.eta == made.eta.min())
    onset = np.where(made.clamp_angle == 0.0, 1.0, np.where(is_far, 1.5, 1.1))
    panel = KINDS["change"].plot(made.assign(mu_lock=0.5, x0_slip=onset)).axes[1]
    assert panel.collections[0].get_clim() == pytest.approx((-10.0, 10.0))
    assert [text.get_text() for text in panel.texts] == ["+50"]


def test_the_border_of_line_contact_is_drawn():
    made = ROWS["change"](3)
    made = made.assign(contact=np.where(made.theta > 2.1, "line", "point"))
    panel = KINDS["change"].plot(made).axes[1]
    places = [x for line in drawn(panel) for x in line.get_xdata()]
    assert places == [0.5 * (2.0 + 2.25)] * 6


@pytest.mark.slow
def test_the_poster_shows_the_states_before_and_after_the_slip():
    figure = draw("slip", scans(), {"scan": "runs", "theta": [2.0], "mu0": [0.3]})
    *_, needed, loads = figure.axes
    found = rows(scans(), theta=2.0, mu0=0.3).sort_values("footpoint")
    first = found[found["cycle"] == 1]
    last, slipped = (first[first["phase"] == phase].iloc[-1] for phase in ("stick", "slip"))
    marks = [line for line in needed.lines if len(line.get_xdata()) == 1]
    assert len(marks) == 3 and marks[0].get_ydata()[0] == pytest.approx(0.0, abs=1e-9)
    for mark, state in zip(marks[1:], (last, slipped), strict=True):
        assert mark.get_xdata()[0] == state["footpoint"]
        assert mark.get_ydata()[0] == pytest.approx(-np.tan(state["alpha"]))
    assert {*names_of(loads)} == {"$f_x$", "$f_y$"}
    assert is_line(loads.lines[0], found["footpoint"], found["reaction_fx"])
    (text,) = draw("slip", scans(), {"scan": "runs", "theta": [1.0], "mu0": [0.3]}).axes[0].texts
    assert text.get_text().startswith("failed")


@pytest.mark.slow
def test_an_animation_moves_all_rods_of_a_scan(tmp_path, monkeypatch):
    monkeypatch.setattr(animation, "FRAMES", 4)
    animate(scans(), {"scan": "runs", "mu0": [0.3]}, tmp_path / "film.apng")
    with Image.open(tmp_path / "film.apng") as film:
        # The picture of viewers that know no animations, and four frames of which it is the last.
        assert film.format == "PNG" and film.n_frames == 1 + 4
        whole, *frames = [
            np.asarray(frame.convert("RGB"), dtype=int) for frame in ImageSequence.Iterator(film)
        ]
    assert np.array_equal(whole, frames[-1])
    for before, after in itertools.pairwise(frames):
        # Something moves in each of the two panels.
        moved = np.flatnonzero(np.abs(after - before).sum(axis=(0, 2)))
        assert moved.min() < frames[0].shape[1] // 2 < moved.max()


# --- Scans that go back, and other laws than the paper's ---


@cache
def moved(law, **motion):
    """A scan by a slip law, as a table of steps."""
    point = {name: one for name, (one,) in grid((2.0,), (0.3,), (0.005,)).items()}
    point |= {"surface": "plane", "law": law}
    curve = curve_of(2.0)
    model = SlipModel.of(law, 0.6)
    scan = move(stage_maker(curve), surfaces.constant(0.3), 0.005, model=model, **motion)
    return scan_tables("runs", point, scan, study="a", method=curve.method, shapes=True).steps


def there_and_back():
    return moved("free", to=(0.1, 0.05))


@pytest.mark.parametrize(("kind", "panel"), [("sawtooth", 0), ("signals", 1)])
def test_loads_are_drawn_along_the_path_of_the_clamp_there_and_back(kind, panel):
    found = rows(there_and_back())
    assert (np.diff(found["footpoint"]) < 0.0).any()
    axes = draw(kind, there_and_back(), {"scan": "runs"}, look={"by": "law"}).axes[panel]
    # A sawtooth shows the first periods alone.
    shown = found[found["cycle"] <= TEETH] if kind == "sawtooth" else found
    assert any(is_line(line, shown["footpoint"], shown["reaction_fx"]) for line in axes.lines)


def test_the_spectrum_of_a_load_is_that_along_the_path_of_the_clamp():
    figure = draw("spectrum", there_and_back(), {"scan": "runs"}, look={"by": "law"})
    expected = amplitudes(rows(there_and_back())["reaction_fx"].to_numpy(), 0.005)
    assert is_line(figure.axes[0].lines[0], *expected)


@pytest.mark.slow
def test_shapes_of_a_scan_that_goes_back_are_in_the_order_of_its_steps():
    table = there_and_back()
    found, axes = rows(table), draw("scan", table, {"scan": "runs"}).axes[0]
    begin, end = shapes_in(axes)
    slips = found[found["phase"] == "slip"]
    assert len(begin) == 1 + len(slips)
    assert begin[-1][0, 0] == pytest.approx(slips["footpoint"].iloc[-1])
    last = found[found["phase"] == "stick"].groupby("cycle").tail(1)
    assert [shape[0, 0] for shape in end] == pytest.approx(last["footpoint"].tolist())
    assert [stop for _, stop in slips_in(axes)] == pytest.approx(slips["x1"].tolist())


@pytest.mark.slow
@pytest.mark.parametrize(("law", "says"), [("free", True), ("kinetic", False)])
def test_each_period_has_the_shape_in_which_it_begins_by_any_law(law, says):
    table = moved(law, cycles=3)
    axes = draw("scan", table, {"scan": "runs"}).axes[0]
    begin, _ = shapes_in(axes)
    after = rows(table, phase="slip")
    assert [shape[-1, 0] for shape in begin[1:]] == pytest.approx(after["x1"].tolist())
    # Only where no friction is needed does a period begin with α = 0.
    assert any("alpha" in text.get_text() for text in axes.texts) == says


@pytest.mark.slow
def test_an_animation_ends_where_the_clamp_ends(tmp_path, monkeypatch):
    told, set_text = [], Text.set_text

    def recorded(text, value):
        told.append(str(value))
        set_text(text, value)

    monkeypatch.setattr(Text, "set_text", recorded)
    animate(there_and_back(), {"scan": "runs"}, tmp_path / "film.apng")
    places = [text for text in told if text.startswith("clamp at")]
    assert places[0] == "clamp at 0.000" and places[-1] == "clamp at 0.050"
    assert "clamp at 0.100" in places


def test_names_of_lines_that_end_at_one_place_do_not_overlap():
    with style.applied():
        figure, axes = style.axes(2.6)
        for i, end in enumerate((0.5, 0.501, 0.502, 0.9)):
            axes.plot([0.0, 1.0], [0.0, end], label=f"line {i}")
        labels.at_ends(axes)
        style.save(figure, [])
        texts = [text for text in axes.texts if text.get_gid() == style.NAMED]
        # Without the lines that lead to the names.
        boxes = [Text.get_window_extent(text) for text in texts]
    assert [text.get_text() for text in texts] == [f"line {i}" for i in range(4)]
    for below, above in itertools.pairwise(boxes):
        assert below.y1 <= above.y0 + 1.0
