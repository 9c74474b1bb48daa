from functools import cache

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from matplotlib.colors import to_hex

import made_tables
from vibrissa import solve_curve, solve_state, stick_slip
from vibrissa.figures import style
from vibrissa.figures.draw import KINDS, _failure, draw
from vibrissa.mechanics.states import ContactState
from vibrissa.outcomes import Status
from vibrissa.sticking.api import EquilibriumState
from vibrissa.sticking.comparison import compare
from vibrissa.sticking.curve import failed_curve
from vibrissa.tables import records, schemas, store

THETA = (1.0, 1.5, 2.0, 3.0)
MU0 = (0.2, 0.3, 0.4, 0.9)
FAILED = failed_curve(theta=2.0, eta=0.05, method="collocation", message="no luck")


def grid(theta=THETA, mu0=MU0, dx0=(0.001, 0.005), eta=(0.85,)):
    return made_tables.grid(theta, mu0, eta, dx0)


def points_table(grids, curves):
    parts = [
        made_tables.points(name, axes, "a", [curves[theta] for theta in axes["theta"]])
        for name, axes in grids.items()
    ]
    table = store.joined(parts, schemas.STICTION)
    # Rows in no order that a figure could rely on
    return table.take(np.random.default_rng(1).permutation(len(table)))


def scan_table(curve, theta, mu0):
    point = {name: one for name, (one,) in grid((theta,), (mu0,), (0.01,)).items()}
    scan = stick_slip(curve, mu0, 0.01, 3)
    return records.scan_table("runs", point, scan, study="a", method=curve.method)


def failed_state():
    return EquilibriumState(
        **dict.fromkeys(ContactState.names(), float("nan")),
        status=Status.FAILED,
        message="no luck",
        contact="point",
        theta=1.0,
        x1=0.1,
        eta=0.5,
        residual=float("nan"),
    )


@cache
def curve_of(theta):
    return solve_curve(float(theta), 0.85)


@cache
def tables():
    return {
        "stiction": points_table(
            {"main": grid(mu0=MU0[:3]), "locks": grid(theta=(2.0,))},
            {theta: curve_of(theta) for theta in THETA},
        ),
        "failed points": points_table({"main": grid(theta=(9.0,))}, {9.0: FAILED}),
        "scans": store.joined(
            [
                scan_table(curve_of(2.0), 2.0, 0.3),
                scan_table(curve_of(3.0), 3.0, 0.3),
                scan_table(curve_of(2.0), 2.0, 0.9),
                scan_table(FAILED, 1.0, 0.3),
            ],
            schemas.SCANS,
        ),
        "states": records.states_table(
            {
                "inside": solve_state(1, 0.55, 0.15),
                "outside": solve_state(2, 0.85, 0.3),
                "lost": failed_state(),
            },
            "a",
        ),
    }


FIGURES = {
    "taper": ("taper", "stiction", {"grid": "main", "dx0": 0.001}),
    "friction": ("friction", "stiction", {"grid": "locks", "theta": 2, "dx0": 0.005}),
    "scan": ("scan", "scans", {"scan": "runs", "theta": 2, "mu0": 0.3}),
    "locked scan": ("scan", "scans", {"scan": "runs", "theta": 2, "mu0": 0.9}),
    "period": ("period", "scans", {"scan": "runs", "theta": 2, "mu0": 0.3}),
    "locked period": ("period", "scans", {"scan": "runs", "theta": 2, "mu0": 0.9}),
    "penetrating state": ("state", "states", {"state": "inside"}),
    "state": ("state", "states", {"state": "outside"}),
}


def example(name):
    kind, table, selection = FIGURES[name]
    figure = draw(kind, tables()[table], selection)
    return figure, figure.axes[0]


def rows(table, **values):
    """Rows of a table with the given values, in the order of the first axis that is not given."""
    found = [
        row
        for row in tables()[table].to_pylist()
        if all(row[key] == value for key, value in values.items())
    ]
    assert found
    return found


def column(found, name):
    return [row[name] for row in found]


def drawn(axes):
    """Data of the lines that show some."""
    return [line for line in axes.lines if len(line.get_xdata())]


def is_line(line, x, y):
    return np.array_equal(line.get_xdata(), x) and np.array_equal(line.get_ydata(), y)


@pytest.mark.slow
def test_taper_figure_shows_marks_and_onset_of_each_friction():
    _, axes = example("taper")
    lines = drawn(axes)
    assert len(lines) == 6
    assert [line.get_marker() for line in lines[1::2]] == ["s", "D", "^"]
    assert len({line.get_color() for line in lines}) == 3
    for mu0, onset, marks in zip((0.2, 0.3, 0.4), lines[::2], lines[1::2], strict=True):
        found = sorted(rows("stiction", grid="main", dx0=0.001, mu0=mu0), key=lambda r: r["theta"])
        assert column(found, "theta") == [1, 1.5, 2, 3]
        assert is_line(onset, column(found, "theta"), column(found, "x0_slip"))
        assert is_line(marks, column(found, "theta"), column(found, "x0_max"))
        assert (onset.get_marker(), marks.get_linestyle()) == ("None", "None")
        assert f"{mu0:g}" in marks.get_label()


def test_friction_figure_shows_marks_onset_and_lock():
    _, axes = example("friction")
    onset, marks, lock = drawn(axes)
    found = sorted(rows("stiction", grid="locks", dx0=0.005), key=lambda row: row["mu0"])
    assert [row["status"] for row in found] == ["slip", "slip", "slip", "lock"]
    slips = found[:3]
    assert is_line(onset, column(slips, "mu0"), column(slips, "x0_slip"))
    assert is_line(marks, column(slips, "mu0"), column(slips, "x0_max"))
    assert lock.get_xdata() == [curve_of(2.0).mu_lock] * 2
    assert "0.005" in marks.get_label()
    assert any(f"{curve_of(2.0).mu_lock:.4f}" in text.get_text() for text in axes.texts)


def test_friction_figure_enlarges_the_first_of_many_levels():
    mu0 = [round(0.1 + i / 500, 3) for i in range(150)]
    table = points_table({"fine": grid((2.0,), mu0, (0.001,))}, {2.0: curve_of(2.0)})
    figure = draw("friction", table, {"grid": "fine"})
    (axes,) = figure.axes
    (inset,) = axes.child_axes
    for line, enlarged in zip(axes.lines[:2], inset.lines, strict=True):
        assert len(line.get_xdata()) == 150
        assert is_line(enlarged, *line.get_data())
    levels = np.unique(table.column("n_steps").to_numpy())[:7]
    assert inset.get_yticks() == pytest.approx(levels * 0.001)
    low, high = inset.get_ylim()
    assert low < levels[0] * 0.001 < levels[6] * 0.001 < high
    shown = table.column("mu0").to_numpy()[np.isin(table.column("n_steps").to_numpy(), levels)]
    assert inset.get_xlim() == pytest.approx((shown.min() - 0.002, shown.max() + 0.002))
    # A box around it, of one colour; the figure itself has none.
    frame = {(one.get_visible(), to_hex(one.get_edgecolor())) for one in inset.spines.values()}
    assert frame == {(True, "#999999")}
    assert not axes.spines["top"].get_visible()


@pytest.mark.parametrize(("name", "mu0"), [("scan", 0.3), ("locked scan", 0.9)])
def test_scan_figure_shows_every_shape_and_where_periods_begin(name, mu0):
    figure, axes = example(name)
    found = rows("scans", theta=2, mu0=mu0)
    starts = [row for row in found if row["x0"] == 0]
    surface, *shapes, footpoints = drawn(axes)
    assert surface.get_ydata() == [0.85, 0.85]
    assert len(shapes) == len(found) + len(starts)
    for line, row in zip(shapes, found + starts, strict=True):
        assert is_line(line, row["shape_x"], row["shape_y"])
    bold = {line.get_color() for line in shapes[len(found) :]}
    assert bold == {style.START}
    assert {line.get_color() for line in shapes[: len(found)]} == {style.SHAPE}
    assert is_line(footpoints, column(found, "footpoint"), [0] * len(found))
    # A slip into each later period, but none before the first.
    assert len(starts) == 4
    assert figure.legends


@pytest.mark.parametrize(("count", "said"), [(1, "1 stick-slip cycle"), (2, "2 stick-slip cycles")])
def test_a_scan_figure_says_how_many_cycles_there_are(count, said):
    found = pd.DataFrame(rows("scans", theta=2, mu0=0.3)).query(f"cycle <= {count}")
    (axes, *_) = KINDS["scan"].plot(found).axes
    assert axes.get_title().endswith(f": {said}")


@pytest.mark.parametrize(("name", "mu0"), [("period", 0.3), ("locked period", 0.9)])
def test_period_figure_shows_the_first_period_of_sticking(name, mu0):
    _, axes = example(name)
    found = rows("scans", theta=2, mu0=mu0, cycle=1, phase="stick")
    _surface, *shapes, footpoints = drawn(axes)
    for line, row in zip(shapes, [*found, found[0], found[-1]], strict=True):
        assert is_line(line, row["shape_x"], row["shape_y"])
    assert [to_hex(line.get_color()) for line in shapes[-2:]] == [style.START, style.END]
    assert is_line(footpoints, column(found, "footpoint"), [0] * len(found))
    # A rod that locks has no x0,max.
    title = f"{found[-1]['footpoint']:g}" if name == "period" else "the tip locks"
    assert title in axes.get_title()


@pytest.mark.parametrize(("name", "state"), [("penetrating state", "inside"), ("state", "outside")])
def test_state_figure_shows_shape_contact_and_clamp(name, state):
    _, axes = example(name)
    (row,) = rows("states", state=state)
    surface, shape, contact, clamp = drawn(axes)
    assert surface.get_ydata() == [row["eta"]] * 2
    assert is_line(shape, row["shape_x"], row["shape_y"])
    assert is_line(contact, [row["x1"]], [row["eta"]])
    assert is_line(clamp, [0], [0])
    told = [text for text in axes.texts if "passes through" in text.get_text()]
    assert len(told) == row["penetrates"] == (state == "inside")


@pytest.mark.parametrize("name", [name for name in FIGURES if name not in ("taper", "friction")])
def test_shapes_are_drawn_in_true_proportions_and_whole(name):
    _, axes = example(name)
    assert axes.get_aspect() == 1
    (x_low, x_high), (y_low, y_high) = axes.get_xlim(), axes.get_ylim()
    for line in drawn(axes)[1:]:
        assert x_low <= min(line.get_xdata()) and max(line.get_xdata()) <= x_high
        assert y_low <= min(line.get_ydata()) and max(line.get_ydata()) <= y_high


@pytest.mark.parametrize("name", FIGURES)
def test_axes_say_what_they_show(name):
    _, axes = example(name)
    assert axes.get_xlabel() and axes.get_ylabel()


@pytest.mark.parametrize(
    "name",
    ["state", *(pytest.param(name, marks=pytest.mark.slow) for name in ("friction", "scan"))],
)
def test_files_are_whole_and_the_same_table_gives_the_same_bytes(name, tmp_path):
    starts = {"pdf": b"%PDF-", "svg": b"<?xml", "png": b"\x89PNG\r\n\x1a\n"}
    ends = {"pdf": b"%%EOF\n", "svg": b"</svg>\n", "png": b"IEND\xaeB`\x82"}
    contents = []
    for run in "ab":
        paths = [tmp_path / f"{run}.{ending}" for ending in starts]
        figure, _ = example(name)
        style.save(figure, paths)
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]
    assert b"CreationDate" not in contents[0][0] and b"dc:date" not in contents[0][1]
    for ending, content in zip(starts, contents[0], strict=True):
        assert content.startswith(starts[ending]) and content.endswith(ends[ending])
    assert len(list(tmp_path.iterdir())) == 6


def test_an_unknown_kind_is_refused():
    message = f"unknown kind of figure 'pie'; allowed: {', '.join(KINDS)}"
    with pytest.raises(ValueError, match=message):
        draw("pie", tables()["stiction"], {})


@pytest.mark.parametrize(
    ("name", "other"),
    [
        ("taper", {"grid": "none"}),
        ("taper", {"dx0": 0.002}),
        ("friction", {"theta": 7}),
        ("scan", {"scan": "none"}),
        ("scan", {"mu0": 0.31}),
        ("period", {"theta": 1.5}),
        ("state", {"state": "none"}),
    ],
)
def test_nothing_to_draw_is_refused(name, other):
    kind, table, selection = FIGURES[name]
    with pytest.raises(ValueError, match=f"no rows to draw for {kind} figure with") as error:
        draw(kind, tables()[table], selection | other)
    assert str(selection | other) in str(error.value)


@pytest.mark.parametrize(
    ("kind", "table", "selection"),
    [
        ("scan", "scans", {"scan": "runs", "theta": 1, "mu0": 0.3}),
        ("period", "scans", {"scan": "runs", "theta": 1, "mu0": 0.3}),
        ("state", "states", {"state": "lost"}),
        ("friction", "failed points", {"grid": "main", "dx0": 0.001}),
    ],
)
def test_a_figure_of_what_failed_says_so(kind, table, selection, tmp_path):
    figure = draw(kind, tables()[table], selection)
    (text,) = figure.axes[0].texts
    assert text.get_text().startswith("failed: ")
    assert ("no luck" in text.get_text()) == (kind in ("state", "friction"))
    style.save(figure, [tmp_path / "figure.svg"])
    assert b"failed: " in (tmp_path / "figure.svg").read_bytes()


def test_points_without_an_onset_leave_gaps(tmp_path):
    table = tables()["stiction"]
    for name in ("x0_slip", "x0_max", "n_steps"):
        field = table.schema.field(name)
        table = table.set_column(
            table.schema.get_field_index(name), field, pa.nulls(len(table), field.type)
        )
    status = table.schema.get_field_index("status")
    table = table.set_column(status, "status", pa.array(["lock"] * len(table)))
    figure = draw("friction", table, {"grid": "locks", "dx0": 0.001})
    style.save(figure, [tmp_path / "figure.png"])
    assert not np.isfinite(figure.axes[0].lines[1].get_ydata().astype(float)).any()


@pytest.fixture(scope="module")
def plane():
    """Points in every regime: point and line contact, slipping and locked."""
    parts = []
    for theta in (1.0, 3.0, 5.0):
        for eta in (0.7, 0.85):
            curve = solve_curve(float(theta), float(eta), contact="line")
            axes = grid(theta=(theta,), mu0=(0.1, 0.4, 0.6), eta=(eta,))
            parts.append(points_table({"plane": axes}, {theta: curve}))
    return store.joined(parts, schemas.STICTION)


def test_locking_figure_shows_a_curve_for_each_height(plane):
    (axes,) = draw("locking", plane, {"grid": "plane"}).axes
    shown = {line.get_label(): line.get_ydata() for line in axes.get_lines()}
    for eta in (0.7, 0.85):
        known = {r["theta"]: r["mu_lock"] for r in plane.to_pylist() if r["eta"] == eta}
        assert list(shown[rf"$\eta = {eta}$"]) == [known[theta] for theta in sorted(known)]


def test_regime_map_colours_each_point_by_what_happens_there(plane):
    panels = draw("regimes", plane, {"grid": "plane"}).axes
    seen = set()
    for axes, eta in zip(panels, (0.7, 0.85), strict=True):
        assert axes.get_title() == rf"$\eta = {eta}$"
        (mesh,) = axes.collections
        field = mesh.get_array().reshape(3, 3)
        for row in plane.to_pylist():
            if row["eta"] == eta:
                place = [0.1, 0.4, 0.6].index(row["mu0"]), [1, 3, 5].index(row["theta"])
                slips = {"point": 0, "line": 1}[row["contact"]]
                locks = {"slips_back": 2, "snaps": 3, "swings_aside": 6}.get(row["ends_by"])
                expected = locks if row["status"] == "lock" else slips
                assert field[place] == expected
                seen.add(expected)
    assert seen == {0, 1, 6}


def locking_points():
    """Onsets near two locks: a smooth maximum and a kink."""
    mu0 = tuple(round(0.4 + 0.0005 * i, 4) for i in range(160))
    curves = {t: solve_curve(float(t), 0.85, contact="line") for t in (2.0, 2.8)}
    return points_table({"lock": grid(tuple(curves), mu0, (0.001,))}, curves)


def test_the_law_near_the_lock_is_a_square_root_except_in_a_kink():
    figure = draw("law", locking_points(), {"grid": "lock"})
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    labels = [text for text in texts if "exponent" in text]
    exponents = [float(label.rsplit(" ", 1)[1]) for label in labels]
    assert exponents == pytest.approx([0.5, 1.0], abs=0.06)
    # The law meets the lock: black lines end in the large marks.
    lines = [line for line in figure.axes[0].lines if line.get_color() == "black"]
    assert len(lines) == 2 and all(len(line.get_xdata()) > 10 for line in lines)


def test_past_the_lock_sticking_ends_where_a_trailing_or_a_planar_rod_slips():
    mu0 = (0.3, 0.6, 0.9)
    curves = {section: solve_curve(2.0, 0.85, section=section) for section in ("round", "planar")}
    for section, curve in curves.items():
        table = points_table({"g": grid((2.0,), mu0, (0.001,))}, {2.0: curve})
        first, later = draw("past_lock", table, {"grid": "g"}).axes
        slips, locked, swing, *_ = (line.get_ydata() for line in drawn(first))
        assert slips == pytest.approx(curve.onset([0.3]))
        if section == "round":
            trail = curve.trailing_end([0.6, 0.9]).x0
            assert locked == pytest.approx(trail) and swing == pytest.approx([curve.x0_end] * 2)
            dragged = drawn(later)[1].get_ydata()
            assert dragged == pytest.approx(trail - 2.0 * curve.x0_end)
        else:
            assert locked == pytest.approx([curve.x0_end] * 2)
            assert np.isnan(swing).all()
        (asymptote,) = (
            line for line in first.lines if len(set(line.get_xdata())) == 1 < len(line.get_xdata())
        )
        assert asymptote.get_xdata()[0] == pytest.approx(curve.mu_lock)


def test_the_margin_out_of_the_plane_is_marked_as_zero_at_x1_init():
    axes = draw("margins", tables()["scans"], {"scan": "runs", "mu0": 0.9}).axes[1]
    curve, _, mark = drawn(axes)[:3]
    found = rows("scans", theta=2, mu0=0.9, cycle=1, phase="stick")
    assert is_line(curve, column(found, "footpoint"), column(found, "stability_aside"))
    assert mark.get_xdata() == pytest.approx([curve_of(2.0).x1_init], abs=1e-12)
    assert list(mark.get_ydata()) == [0.0]
    # In line contact it is where the clamp is under the contact point, not under the tip.
    lying = scan_table(solve_curve(5.0, 0.33, contact="line"), 5.0, 0.9)
    _, _, mark = drawn(draw("margins", lying, {"scan": "runs"}).axes[1])[:3]
    assert mark.get_xdata() == pytest.approx(
        [solve_curve(5.0, 0.33, contact="line").x0_end], abs=1e-4
    )


def test_a_rod_that_swings_aside_keeps_its_shape_while_its_plane_turns():
    oblique, above, _ = draw(
        "swing", tables()["scans"], {"scan": "runs", "theta": 2, "mu0": 0.9}
    ).axes
    turned = {to_hex(line.get_color()): line for line in above.lines if line.get_linewidth() == 1.8}
    found = rows("scans", theta=2, mu0=0.9, cycle=1, phase="stick")
    before = max(
        (row for row in found if row["x1"] > row["footpoint"]), key=lambda r: r["footpoint"]
    )
    out = np.array(before["shape_x"]) - before["footpoint"]
    directions = []
    for line in turned.values():
        x, z = line.get_xdata() - before["footpoint"], np.asarray(line.get_ydata())
        assert np.hypot(x, z) == pytest.approx(np.abs(out))
        far = np.argmax(np.abs(out))
        directions.append(np.degrees(np.arctan2(z[far], x[far]) - np.arctan2(0.0, out[far])))
    assert np.mod(directions, 360.0) == pytest.approx(np.arange(0.0, 181.0, 30.0), abs=1e-9)
    # Each is drawn in the other panel, too, with its height.
    (upright,) = (line for line in oblique.lines if to_hex(line.get_color()) == list(turned)[3])
    assert upright.get_ydata() - 0.3 * out == pytest.approx(before["shape_y"])


@pytest.mark.parametrize("mu0", [0.3, 0.9])
def test_a_swing_is_not_drawn_of_a_tip_that_slips_or_a_rod_that_is_guided(mu0):
    table = tables()["scans"]
    if mu0 == 0.9:
        planar = solve_curve(2.0, 0.85, section="planar")
        table = scan_table(planar, 2.0, 0.9)
        assert min(column(table.to_pylist(), "x1")) < max(column(table.to_pylist(), "footpoint"))
    figure = draw("swing", table, {"scan": "runs", "theta": 2, "mu0": mu0})
    (text,) = figure.axes[0].texts
    assert text.get_text() == "the rod does not swing aside in this scan"
    assert np.isnan(drawn(draw("margins", table, {"theta": 2, "mu0": mu0}).axes[1])[2].get_xdata())


def test_models_figure_marks_what_penetrates():
    table = records.comparison_table("models", compare([1, 4, 8], [0.2], [0.85]), "a")
    figure = draw("models", table, {"comparison": "models"})
    line, marks = figure.axes[0].lines
    assert np.isfinite(line.get_ydata()).all()
    assert np.isfinite(marks.get_ydata()).tolist() == [False, False, True]
    assert marks.get_ydata()[2] > 30


def test_signals_of_a_locking_tip_show_its_stability_fall():
    figure = draw("signals", tables()["scans"], {"scan": "runs", "theta": 2, "mu0": 0.9})
    inclination, *_ = figure.axes[0].lines
    assert abs(inclination.get_ydata()).max() < 0.9
    inside, aside = (line.get_ydata() for line in figure.axes[2].lines)
    # Where the rod swings aside only the margin out of the plane is near zero.
    assert inside.min() > 0.3 > 0.05 > aside.min() > 0


def test_several_states_stand_in_one_figure():
    lying = solve_state(1, 0.55, 0.15, "line")
    table = records.states_table({"paper": solve_state(1, 0.55, 0.15), "lying": lying}, "a")
    figure = draw("state", table, {"state": ["paper", "lying"]})
    text = " ".join(text.get_text() for text in figure.axes[0].texts)
    assert "point contact" in text and "line contact" in text and "passes through" in text


def test_regimes_tell_how_a_lock_goes_on():
    curve = {1.5: solve_curve(1.5, 0.5, contact="line", section="planar")}
    mu0 = tuple(i / 10 for i in range(1, 13))
    table = points_table({"plane": grid((1.5,), mu0, (0.001,), (0.5,))}, curve)
    figure = draw("regimes", table, {"grid": "plane"})
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "locks, then slips back" in shown and "locks, then snaps through" in shown
    assert "no result" not in shown


def test_what_failed_first_is_said_where_there_is_nothing_to_draw():
    rows = pd.DataFrame({"status": ["out_of_reach", "failed"], "message": ["too high", "no luck"]})
    for found, said in ((rows, "too high"), (rows[["status"]], "the tables and logs say why")):
        (text,) = _failure(found).axes[0].texts
        assert text.get_text() == f"out of reach: {said}"
