"""Whole proofs as they were: every enclosure to many digits, and how wide each is."""

from decimal import Decimal
from math import log10

import pytest
from flint import arb, arb_mat, ctx

from known import Known
from vibrissa import solve_curve
from vibrissa.outcomes import Contact
from vibrissa.proof import Effort, lock, onset, spelled
from vibrissa.proof.critical import prove_critical, turning
from vibrissa.proof.equilibrium import Rod, equations, inclined, prove, reaching, tangential
from vibrissa.proof.flow import Load, Vicinity, diameter, place, shoot
from vibrissa.proof.krawczyk import operator, reached
from vibrissa.proof.path import follow, moment_and_height, proved_tube
from vibrissa.proof.starting import load_at, path_of, suitable
from vibrissa.proof.table import curve_enclosures, state_enclosures

KNOWN = Known(__file__)
QUICK = Effort(bits=96, order=16, steps=16)
LOAD = Load(arb(-0.9), arb(-2.3), arb(-0.05))
# Of a logarithm: what follows from fixed numbers, and what begins at the solver's.
SAME, ALIKE = 0.01, 0.04


@pytest.fixture(autouse=True)
def _precision():
    with QUICK.spent():
        yield


def middles(balls):
    return [float(one.mid()) if isinstance(one, arb) else float(one) for one in balls]


def widths(balls):
    """Logarithms of the radii; none for a number that is exact."""
    radii = [float(one.rad()) if isinstance(one, arb) else 0.0 for one in balls]
    return [round(log10(radius), 2) if radius else None for radius in radii]


def check(name, within, **parts):
    """Compare the middles of balls to ten digits, and their widths."""
    parts = {key: list(balls) for key, balls in parts.items()}
    KNOWN.check(name, {key: middles(balls) for key, balls in parts.items()}, 1e-10)
    KNOWN.check(f"{name}: widths", {key: widths(balls) for key, balls in parts.items()}, within)


def flat(sections):
    return [value for section in sections for value in section]


@pytest.mark.parametrize("theta", ["1", "2.5", "4"])
def test_a_shot_has_the_same_sections_boxes_and_derivatives(theta):
    shot = shoot(arb(theta), LOAD, 24, second=True)
    short = shoot(arb(theta), LOAD, 24, end=arb("0.8"))
    check(
        f"shot, theta {theta}",
        SAME,
        tip=flat(shot.tip),
        onward=flat(shot.onward),
        passed=flat(shot.passed),
        ends=flat(shot.ends),
        short=flat(short.tip),
        places=[place(arb(theta), arb(k) / 5) for k in range(6)],
        diameter=[diameter(arb(theta), arb("0.3"))],
    )


def test_a_vicinity_is_enclosed_in_the_same_way():
    theta, multiple = arb(2), arb(0, 2.0**-8)
    direction, more = Load(arb(1), arb(1.3), arb(-0.5)), Load(arb(0), arb(0, 1e-5), arb(0, 1e-5))
    box = Load(*(m + d * multiple + e for m, d, e in zip(LOAD, direction, more, strict=True)))
    middle = shoot(theta, LOAD, 12)
    shot = shoot(theta, box, 12, Vicinity(middle, direction, multiple, more))
    check("vicinity", SAME, tip=flat(shot.tip), passed=flat(shot.passed))


def test_the_equations_have_the_same_values_and_slopes():
    rod = Rod(theta=arb(2), eta=arb("0.8"), steps=12)
    at = arb_mat([[value] for value in LOAD])
    lying = arb_mat([[value] for value in (*LOAD, arb("0.9"))])
    parts = {}
    for name, closing in {
        "inclined": inclined(arb("0.3")),
        "reaching": reaching(arb("0.4")),
        "tangential": tangential(),
    }.items():
        values, slopes = equations(rod, closing)(at)
        parts[name] = [*values.entries(), *slopes.entries()]
        values, slopes = equations(rod, closing, Contact.LINE)(lying)
        parts[f"{name}, lying"] = [*values.entries(), *slopes.entries()]
    value, change = turning(LOAD, shoot(rod.theta, LOAD, 12, second=True))
    missed, of_fx, of_more = moment_and_height(rod, shoot(rod.theta, LOAD, 12))
    check(
        "equations",
        SAME,
        turning=[value, *change],
        moment_and_height=[*missed.entries(), *of_fx.entries(), *of_more.entries()],
        **parts,
    )


def test_krawczyk_s_operator_is_the_same():
    centre, values = arb_mat([[1.25], [2.5]]), arb_mat([[arb("0.01", 1e-6)], [arb("-0.02")]])
    box = arb_mat([[arb(1.25, 0.1)], [arb(2.5, 0.2)]])
    slopes = arb_mat([[arb(2, 0.1), arb(0.5)], [arb(-1), arb(3, 0.2)]])
    check(
        "operator",
        SAME,
        image=operator(centre, values, box, slopes).entries(),
        reached=reached(arb_mat([[arb(0.5, 0.1)], [arb(-1e-3)], [arb(0)]])).entries(),
    )


@pytest.mark.parametrize(
    ("name", "theta", "eta", "closing", "near", "contact"),
    [
        ("with a tip", 2, "0.85", inclined(arb("0.3")), 0.0263, Contact.POINT),
        ("at a place", 2, "0.85", reaching(arb("0.4")), 0.0173, Contact.POINT),
        ("lying", 3, "0.7", inclined(arb(0)), [0.0, -0.9866, -0.4, 0.9479], Contact.LINE),
        ("lying at a place", 3, "0.7", reaching(arb("0.48")), None, Contact.LINE),
    ],
)
def test_an_equilibrium_is_enclosed_in_the_same_way(name, theta, eta, closing, near, contact):
    rod = Rod(theta=arb(theta), eta=arb(eta), steps=16)
    if near is None:
        curve = solve_curve(theta, float(eta), contact="line")
        x0 = curve.x1_init - 0.48
        near = [*load_at(curve, x0), float(curve.state(x0).s_c)]
    elif isinstance(near, float):
        near = load_at(solve_curve(theta, float(eta)), near)
    found = prove(rod, closing, near, contact)
    check(
        name,
        ALIKE,
        load=[*found.load, found.s_c],
        told=[found.f, found.alpha, found.mu, found.offset, found.phi1],
        box=found.box,
    )
    KNOWN.check(f"{name}: said", [found.bent_once(), found.keeps_contact(), str(found.contact)])


@pytest.fixture(scope="module")
def cylinder():
    return Rod(theta=arb(1), eta=arb("0.85"), steps=12), solve_curve(1, 0.85)


def test_a_critical_state_is_enclosed_in_the_same_way(cylinder):
    rod, curve = cylinder
    found = prove_critical(rod, load_at(curve, curve.x0_lock))
    check("critical", ALIKE, load=found.load, told=[found.mu, found.offset, found.phi1])


@pytest.mark.parametrize("x0", [0.02, 0.0924, 0.15])
def test_a_tube_is_the_same_before_at_and_behind_the_maximum(cylinder, x0):
    rod, curve = cylinder
    near = Load(*(arb(float(f"{value:.6g}")) for value in load_at(curve, x0)))
    found = proved_tube(rod, near, arb("0.01"), arb("0.01") / 8)
    bend = [] if found.bend is None else [found.bend]
    check(
        f"tube at {x0}",
        ALIKE,
        line=[*found.centre, *found.direction, found.reach],
        last=found.last,
        told=[found.mu, found.rise, found.advance, *bend],
    )
    KNOWN.check(f"tube at {x0}: reaches", widths([*found.more, *found.found]), ALIKE)


@pytest.mark.slow
def test_a_path_has_the_same_tubes(cylinder):
    with Effort(bits=64, order=12, steps=12).spent():
        rod, curve = cylinder
        init = prove(rod, inclined(arb(0)), load_at(curve, 0.0))
        path = follow(rod, init, beyond=arb("0.06"))
        KNOWN.check(
            "path",
            {
                "centres": [float(tube.centre.fx) for tube in path.tubes],
                "reaches": [float(tube.reach.mid()) for tube in path.tubes],
                "mu": [float(tube.mu.mid()) for tube in path.tubes],
            },
            1e-6,
        )


def test_a_taper_has_the_same_effort():
    KNOWN.check(
        "effort",
        {
            theta: [float(value) for value in vars(suitable(Decimal(theta))).values()]
            for theta in ("1", "2", "3", "8", "20", "100")
        },
    )


def test_the_precision_is_as_before_when_an_effort_is_spent():
    before = ctx.prec, ctx.cap
    with Effort(bits=200, order=40, steps=3).spent():
        assert (ctx.prec, ctx.cap) == (200, 41)
    assert (ctx.prec, ctx.cap) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "prove_it"),
    [
        ("onset", lambda: onset("2", "0.4", "0.85", effort=QUICK)),
        ("onset, lying", lambda: onset("3", "0.45", "0.85", contact="line", effort=QUICK)),
        ("lock", lambda: lock("1", "0.85", effort=QUICK)),
    ],
)
def test_a_period_has_the_same_columns(name, prove_it):
    found = prove_it()
    columns = found.columns()
    check(name, ALIKE, columns=columns.values())
    digits = {key: spelled(ball)[:12] for key, ball in columns.items()}
    KNOWN.check(f"{name}: said", {**digits, "first": found.first})


@pytest.mark.slow
def test_rows_of_tables_have_the_same_enclosures(monkeypatch):
    def path_of(*asked, **others):
        return None

    monkeypatch.setattr("vibrissa.proof.table.path_of", path_of)
    points = [(Decimal(mu0), Decimal("0.002")) for mu0 in ("0.2", "0.4", "0.7")]
    found = [
        *curve_enclosures(Decimal(2), Decimal("0.85"), points, QUICK, lock=True),
        *state_enclosures("one", Decimal(2), Decimal("0.85"), Decimal("0.4"), QUICK),
        *state_enclosures("too far", Decimal(2), Decimal("0.85"), Decimal("0.1"), Effort(64, 3, 2)),
    ]
    rows = [
        {
            "row": " ".join(f"{key}={value}" for key, value in one.row.items()),
            "what": f"{one.table} {one.quantity} {one.note}",
            "value": None if one.midpoint is None else float(one.midpoint),
            "on_path": one.on_path,
        }
        for one in found
    ]
    KNOWN.check("rows", rows, 1e-10)


def test_a_path_is_covered_with_the_effort_of_its_taper(monkeypatch):
    asked = []
    monkeypatch.setattr(
        "vibrissa.proof.starting.follow",
        lambda rod, init, beyond, over: asked.append((rod.steps, ctx.prec, ctx.cap, beyond, over)),
    )
    for theta in ("1", "4", "20"):
        path_of(Decimal(theta), Decimal("0.85"), None, beyond=Decimal("0.5"))
    path_of(Decimal(2), Decimal("0.85"), None, over=True)
    assert asked == [
        (12, 64, 13, arb("0.5"), False),
        (20, 64, 13, arb("0.5"), False),
        (66, 64, 13, arb("0.5"), False),
        (12, 64, 13, None, True),
    ]
