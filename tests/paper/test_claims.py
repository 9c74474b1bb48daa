"""What is said to the paper's statements, and that it would be something else if they were."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

from vibrissa import solve_curve, solve_onset
from vibrissa.errors import TableError
from vibrissa.mechanics.bending import Bending, measure
from vibrissa.mechanics.elastica import rod_equations
from vibrissa.mechanics.rod import Rod
from vibrissa.mechanics.taper import diameter
from vibrissa.paper.claims import CLAIMS
from vibrissa.paper.evidence import gather
from vibrissa.paper.judging import by_bending, line_fit
from vibrissa.paper.ledger import Verdict, claims_table, markdown
from vibrissa.sticking.solving.shooting import PAPER, shoot
from vibrissa.tables import schemas, store

HOLDS, CONDITION, AMBIGUOUS, CONTRADICTED = Verdict


def changed(table, **columns):
    """Replace columns of a table of the evidence by functions of its rows."""

    def change(evidence):
        rows = getattr(evidence, table).copy()
        for name, function in columns.items():
            rows[name] = function(rows)
        return replace(evidence, **{table: rows})

    return change


def one_scan(evidence):
    """Leave the scan of one rod over one friction."""
    return replace(evidence, scan=evidence.scans()[0])


def moved_by_cycle(column):
    return changed("scan", **{column: lambda rows: rows[column] + 0.1 * rows["cycle"]})


def state(**values):
    return lambda evidence: replace(evidence, state={**evidence.state, **values})


def on_the_grids_of_all_steps(evidence):
    """Slip where a step of both sizes ends, so that rounding down costs nothing."""
    slips = changed("taper", x0_slip=lambda rows: 0.05)(evidence)
    return changed("scan", dx0=lambda rows: np.where(rows["theta"] == 1, 0.0005, 0.001))(slips)


def only_slipping(evidence):
    return replace(evidence, friction=evidence.slipping())


def turned_over():
    """Give θ = 1 the scans of θ = 3 and the other way round."""
    return changed("scan", theta=lambda rows: 4.0 - rows["theta"])


def same_friction(evidence):
    """Give both μ0 of the scans the same steps, the second moved by nothing."""
    rows = evidence.scan[evidence.scan["mu0"] == 0.3]
    return replace(evidence, scan=pd.concat([rows, rows.assign(mu0=0.4)], ignore_index=True))


@pytest.mark.slow
def test_scans_are_ordered_by_taper_then_friction(evidence):
    rows = evidence.scan[evidence.scan["step"] == evidence.scan["step"].min()].head(1)
    keys = [(2.0, 0.3), (2.0, 0.4), (3.0, 0.1), (3.0, 0.2)]
    scan = pd.concat([rows.assign(theta=theta, mu0=mu0) for theta, mu0 in reversed(keys)])
    found = replace(evidence, scan=scan.assign(cycle=1, phase="stick"))
    for scans in (found.scans(), found.first_periods()):
        assert [(one["theta"].iloc[0], one["mu0"].iloc[0]) for one in scans] == keys


def under_equal_force(evidence):
    """Load all rods alike: the more tapered ones bend more."""
    one = {"f_last": 0.1, "alpha_last": 0.0, "x1_init": 0.3, "x0_max": 0.0}
    return replace(evidence, taper=evidence.taper.assign(**one))


def with_less_force(evidence):
    rows = under_equal_force(evidence).taper
    return replace(evidence, taper=rows.assign(f_last=0.1 * rows["theta"] ** -9.0))


def with_taper(function):
    """Replace x0 of Figure 6 by a function of θ and μ0, on steps of 0.001."""

    def x0(rows):
        return function(rows["theta"], rows["mu0"])

    return changed(
        "taper",
        x0_slip=x0,
        x0_max=lambda rows: np.floor(x0(rows) * 1000 + 1e-9) / 1000,
        n_steps=lambda rows: np.floor(x0(rows) * 1000 + 1e-9),
    )


def with_friction(function):
    """Replace x0 of Figure 7 by a function of μ0, on steps of 0.001, where the tip slips."""
    change = changed(
        "friction",
        x0_slip=lambda rows: function(rows["mu0"]),
        x0_max=lambda rows: np.floor(function(rows["mu0"]) * 1000 + 1e-9) / 1000,
    )
    return lambda evidence: change(only_slipping(evidence))


class Cylinder:
    """A curve that is that of the cylinder, whatever the taper."""

    def __new__(cls, theta, eta):
        return solve_curve(1.0, eta)


def straight_curves(eta):
    """Curves on which x0 is a straight line in θ."""

    class Line:
        def __init__(self, theta):
            self.theta = theta

        def onset(self, mu0):
            return 0.01 * self.theta * np.asarray(mu0)

    return [Line(theta) for theta in np.arange(1.0, 20.5, 0.5)]


class Folded:
    """A curve whose moment comes back to where it was."""

    def __init__(self, theta, eta):
        self.curve = solve_curve(theta, eta)
        self.x0_lock = self.curve.x0_lock
        self.mobilised_friction = self.curve.mobilised_friction

    def state(self, x0):
        at = self.curve.state(x0)
        return replace(at, reaction_m=np.abs(at.reaction_m))


def clockwise(theta, f, alpha, x1, y1):
    return rod_equations(theta, f, -alpha, x1, y1)


def aim_at_nothing(theta, f, alpha, x1, y1):
    return x1, y1, 0.0


def one_unknown(theta, f, alpha, x1, y1):
    return shoot(theta, f + alpha, -0.1, x1, y1)


def line_in_theta(theta, mu0):
    return 0.1 * mu0 * theta


def falling(theta, mu0):
    return 0.1 * mu0 * (5.0 - theta)


THIN = Rod(youngs_modulus=2.1e11, base_diameter=1e-3, length=0.1)
MIDDLE = Rod(youngs_modulus=2.1e11, base_diameter=1.8e-3, length=0.1)
MILLIMETRE = Rod(youngs_modulus=2.1e11, base_diameter=5e-3, length=1e-3)
TIGHT = replace(PAPER, rtol=1e-5, atol=1e-7, simplex=1e-6)
LOOSE = replace(PAPER, rtol=1e-2, atol=1e-4, simplex=1e-2, miss=0.1)


def same_travel(response, mu0, model):
    """Travel that does not depend on the law."""
    return 0.1 * mu0


def more_slips(response, mu0, model):
    """By the law kinetic, travel that falls with friction."""
    return 0.1 - 0.1 * mu0 if model.law == "kinetic" else 0.1 * mu0


# Each statement with evidence that is not as it is, or with another value of a name in its module,
# and the verdict on that.
UNCHANGED = changed("taper")
OTHERWISE = [
    ("pushed", changed("scan", x1=lambda rows: rows["footpoint"] - 0.1), {}, CONTRADICTED),
    ("event frequency", with_friction(lambda mu0: 0.1 + 0 * mu0), {}, CONTRADICTED),
    ("force unit", UNCHANGED, {"EXAMPLE": THIN}, CONTRADICTED),
    ("example rod", UNCHANGED, {"EXAMPLE": THIN}, HOLDS),
    ("example rod", UNCHANGED, {"EXAMPLE": MIDDLE}, CONDITION),
    ("taper of eq. (1)", UNCHANGED, {"printed_diameter": diameter}, HOLDS),
    ("arc length", UNCHANGED, {"EXAMPLE": MILLIMETRE}, HOLDS),
    ("sense of α", UNCHANGED, {"rod_equations": clockwise}, CONTRADICTED),
    ("two unknowns", UNCHANGED, {"shooting.shoot": one_unknown}, CONTRADICTED),
    ("two unknowns", UNCHANGED, {"shooting.shoot": aim_at_nothing}, CONTRADICTED),
    ("shooting", one_scan, {"shooting.PAPER": TIGHT}, HOLDS),
    ("shooting", UNCHANGED, {"shooting.PAPER": LOOSE}, CONTRADICTED),
    ("sign of α", changed("scan", alpha=lambda rows: -rows["alpha"]), {}, CONTRADICTED),
    (
        "further deformed",
        changed("scan", phi1=lambda rows: 1.0, f=lambda rows: 1.0 - rows["x0"]),
        {},
        CONTRADICTED,
    ),
    (
        "end of sticking",
        changed("friction", alpha_trail=lambda rows: 0.9 * rows["alpha_trail"]),
        {},
        CONTRADICTED,
    ),
    (
        "event frequency",
        changed("friction", x0_trail=lambda rows: 2 * rows["x0_end"] + 0.01),
        {},
        CONTRADICTED,
    ),
    ("event frequency by any slip law", UNCHANGED, {"steady_travel": same_travel}, HOLDS),
    ("event frequency by any slip law", UNCHANGED, {"steady_travel": more_slips}, CONTRADICTED),
    (
        "μ0 from the load",
        changed("friction", reaction_fx_trail=lambda rows: 1.1 * rows["reaction_fx_trail"]),
        {},
        CONTRADICTED,
    ),
    (
        "μ0 from the load",
        changed("friction", reaction_fx_slip=lambda rows: 1.1 * rows["reaction_fx_slip"]),
        {},
        CONTRADICTED,
    ),
    ("longer with θ", UNCHANGED, {"wide_sweep": straight_curves}, HOLDS),
    ("longer with θ", with_taper(falling), {}, CONTRADICTED),
    ("deformation with θ", under_equal_force, {}, HOLDS),
    ("deformation with θ", with_less_force, {}, CONTRADICTED),
    ("μ0 = 0.3 against 0.4", same_friction, {}, CONTRADICTED),
    ("few steps", with_taper(lambda theta, mu0: 0.1 * mu0 * theta), {}, CONTRADICTED),
    ("few steps", with_taper(lambda theta, mu0: 0.002 * mu0 * theta), {}, HOLDS),
    ("accurate drive", with_taper(line_in_theta), {}, CONTRADICTED),
    ("important for a sensor", UNCHANGED, {"solve_curve": Cylinder}, CONTRADICTED),
    ("taper compensates", UNCHANGED, {"solve_curve": Cylinder}, CONTRADICTED),
    ("longer slides with θ", turned_over(), {}, CONTRADICTED),
    ("longer slides with θ", changed("scan", footpoint=lambda r: 2 * r["footpoint"]), {}, HOLDS),
    ("longer scan with θ", turned_over(), {}, CONTRADICTED),
    ("linear in θ", with_taper(line_in_theta), {"wide_sweep": straight_curves}, HOLDS),
    ("linear in θ", with_taper(lambda t, m: 0.1 * m * (t - 1.9) ** 2), {}, CONTRADICTED),
    ("μ0 strengthens the taper's effect", with_taper(lambda t, m: 0.1 * t ** (9 * m)), {}, HOLDS),
    ("μ0 strengthens the taper's effect", with_taper(lambda t, m: t / m), {}, CONTRADICTED),
    ("levels of Figure 7", with_friction(lambda mu0: 0.1 * mu0 + 0.0005), {}, HOLDS),
    ("levels of Figure 7", with_friction(lambda mu0: 8.0 * mu0), {}, CONTRADICTED),
    ("cause of the levels", with_friction(lambda m: np.round(m, 1)), {}, CONTRADICTED),
    ("no exact trend", with_friction(lambda mu0: 0.1 * mu0 + 0.0003), {}, HOLDS),
    ("no exact trend", changed("friction", x0_max=lambda rows: rows["x0_slip"]), {}, CONTRADICTED),
    ("non-linear in μ0", with_friction(lambda mu0: 0.1 * mu0), {}, CONTRADICTED),
    (
        "periods repeat",
        changed("scan", f=lambda rows: rows["f"] + 0.001 * (rows["cycle"] > 5)),
        {},
        CONTRADICTED,
    ),
    ("periods repeat", moved_by_cycle("x1"), {}, CONTRADICTED),
    ("periods repeat", moved_by_cycle("shape_x"), {}, CONTRADICTED),
    (
        "periods repeat",
        lambda evidence: replace(evidence, scan=evidence.scan.iloc[:-1]),
        {},
        CONTRADICTED,
    ),
    (
        "step size analysed",
        changed("scan", dx0=lambda rows: np.where(rows["theta"] == 1, 0.0005, 0.001)),
        {},
        HOLDS,
    ),
    ("step size analysed", on_the_grids_of_all_steps, {}, HOLDS),
    ("longer with μ0", changed("friction", x0_trail=lambda r: 1 - r["mu0"]), {}, CONTRADICTED),
    ("longer with μ0", changed("friction", f_trail=lambda r: 90 * r["mu0"]), {}, HOLDS),
    ("longer with μ0", with_friction(lambda mu0: 0.1 - 0.1 * mu0), {}, CONTRADICTED),
    ("μ0 from the moment", UNCHANGED, {"solve_curve": Folded}, CONTRADICTED),
    ("longer periods with θ and μ0", turned_over(), {}, CONTRADICTED),
    ("longer periods with θ and μ0", with_taper(falling), {}, CONTRADICTED),
    ("longer way", turned_over(), {}, CONTRADICTED),
    ("more steps", turned_over(), {}, CONTRADICTED),
    (
        "more steps",
        changed("scan", dx0=lambda rows: np.where(rows["theta"] == 1, 0.0005, 0.001)),
        {},
        AMBIGUOUS,
    ),
    ("more events with μ0", with_taper(lambda theta, mu0: 0.01 * theta / mu0), {}, HOLDS),
    (
        "more events with μ0",
        with_taper(lambda theta, mu0: 0.01 * theta * np.where(theta > 2, 1 / mu0, mu0)),
        {},
        AMBIGUOUS,
    ),
    ("negative φ1 in Figure 8", state(phi1=0.1), {}, CONTRADICTED),
    ("penetration in Figure 8", state(shape_y=np.linspace(0.0, 0.55, 101)), {}, CONTRADICTED),
    ("correct in theory", state(residual=1e-3), {}, CONTRADICTED),
    ("correct in theory", state(stability=-0.1), {}, CONDITION),
    ("contact along a line", state(penetrates=False), {}, CONTRADICTED),
    ("contact along a line", changed("taper", penetrates=lambda rows: True), {}, HOLDS),
]


@pytest.mark.parametrize(
    ("power", "reason"), [(0.3, "but not"), (0.5, "at the end"), (0.7, "but not")]
)
def test_a_lock_is_like_a_square_root_or_it_is_said(monkeypatch, evidence, power, reason):
    curve = SimpleNamespace(
        mu_lock=0.48, x0_lock=0.15, onset=lambda mu0: 0.15 - np.abs(0.48 - mu0) ** power
    )
    monkeypatch.setattr("vibrissa.paper.results.solve_curve", lambda theta, eta: curve)
    found = named("non-linear in μ0").judge(evidence)
    assert found.reason.startswith(reason) or f", {reason} like a square root" in found.reason


@pytest.mark.parametrize(
    ("steps", "verdict"), [(-2, CONTRADICTED), (-1, CONDITION), (1, CONDITION), (2, CONTRADICTED)]
)
def test_periods_too_short_and_too_long_are_as_bad(monkeypatch, evidence, steps, verdict):
    """And so are forces that are too small and too large."""

    def walk(theta, eta, dx0, mu0, tolerances):
        size = {(rows["theta"].iloc[0], rows["mu0"].iloc[0]): rows for rows in periods}
        forces = size[theta, mu0]["f"].to_numpy() * (1.0 + 0.01 * steps)
        some = [SimpleNamespace(f=force, alpha=0.0) for force in forces]
        return (some + some)[: len(forces) + 1 + steps]

    periods = evidence.first_periods()
    monkeypatch.setattr("vibrissa.paper.modeling.shooting.walk", walk)
    finding = named("shooting").judge(one_scan(evidence))
    assert finding.verdict == verdict
    assert finding.quantities["largest difference in steps"] == (abs(steps), "1")
    if steps < 0:
        assert finding.quantities["largest error of f"][0] == pytest.approx(-steps)


def named(name):
    (found,) = [claim for claim in CLAIMS if claim.name == name]
    return found


def test_every_statement_can_come_out_otherwise():
    assert {name for name, *_ in OTHERWISE} == {claim.name for claim in CLAIMS}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "change", "other", "verdict"),
    OTHERWISE,
    ids=[f"{name}-{verdict}" for name, *_, verdict in OTHERWISE],
)
def test_another_world_gets_another_verdict(
    monkeypatch, evidence, ledger, name, change, other, verdict
):
    (told,) = [row["verdict"] for row in ledger.to_pylist() if row["claim"] == name]
    assert verdict != told
    claim = named(name)
    for replaced, value in other.items():
        monkeypatch.setattr(f"{claim.compute.__module__}.{replaced}", value)
    finding = claim.judge(change(evidence))
    assert finding.verdict == verdict, finding


@pytest.mark.parametrize(
    ("steps", "verdict"), [(1, HOLDS), (2, CONDITION), (10, CONDITION), (11, CONTRADICTED)]
)
def test_a_few_steps_are_at_most_ten(evidence, steps, verdict):
    world = with_taper(lambda theta, mu0: 0.001 * (steps + 0.05) * theta * mu0 / 0.3)
    assert named("few steps").judge(world(evidence)).verdict == verdict


def test_a_line_that_bends_beyond_the_papers_tapers_has_a_condition(evidence):
    assert named("linear in θ").judge(with_taper(line_in_theta)(evidence)).verdict == CONDITION


def test_a_grid_on_which_no_tip_slips_by_itself_is_not_one_on_which_none_slips(evidence):
    locked = changed("friction", status=lambda rows: "lock")(evidence)
    swung = locked.friction[locked.friction["x0_trail"].notna()]
    finding = named("end of sticking").judge(replace(locked, friction=swung))
    assert finding.verdict == CONDITION and "buckles laterally" in finding.reason


def rods(**values):
    ones = dict.fromkeys(Bending.names(), np.ones(3))
    return Bending(**ones | {name: np.array(value) for name, value in values.items()})


@pytest.mark.parametrize(
    ("after", "verdict"),
    [
        ({name: [1.1, 2.0, 3.0] for name in Bending.names()}, HOLDS),
        ({"energy": [1.1, 2.0, 3.0]}, CONDITION),
        ({"curvature": [1.1, 2.0, 3.0], "energy": [0.9, 2.0, 3.0]}, AMBIGUOUS),
        ({name: [0.9, 2.0, 3.0] for name in Bending.names()}, CONTRADICTED),
    ],
)
def test_more_bent_is_what_all_measures_say(after, verdict):
    assert by_bending("it is", rods(), rods(**after), {}).verdict == verdict


@pytest.mark.parametrize("theta", [1.0, 2.0, 3.0])
def test_the_clamp_puts_in_the_energy_that_the_rod_stores(theta):
    # dU/dx0 = -fx while the tip sticks: an independent check of the bending energy.
    curve = solve_curve(theta, 0.85)
    x0 = np.linspace(0.0, 0.06, 7)
    at = curve.state(x0)
    bent = measure(np.full(7, theta), at.f, at.alpha, curve.x1_init - x0, np.full(7, 0.85))
    spent = [quad(lambda x: -float(curve.state(x).reaction_fx), 0.0, end)[0] for end in x0]
    assert bent.energy - bent.energy[0] == pytest.approx(spent, abs=3e-6)


def test_numbers_beside_the_verdicts_are_those_of_the_rods_they_name(evidence):
    tips = named("taper of eq. (1)").judge(evidence).quantities.values()
    assert [value for value, _ in tips] == pytest.approx([1 / 9, 1 / 3, 0.0], abs=1e-12)
    found = named("deformation with θ").judge(evidence).quantities

    def turn(theta, mu0):
        x0 = solve_onset(theta, mu0, 0.85, dx0=0.001).x0_max
        return np.pi / 2 - float(solve_curve(theta, 0.85).state(x0).phi1)

    ratios = [turn(3.0, mu0) / turn(1.0, mu0) for mu0 in set(evidence.taper["mu0"])]
    (least,) = [value for text, (value, _) in found.items() if text.startswith("smallest turn")]
    assert least == pytest.approx(min(ratios), rel=1e-6)


def test_strain_and_curvature_at_the_clamp_of_a_cylinder():
    # There the moment is largest at alpha = 0: 2·k·K, with k and K of the elastica.
    curve = solve_curve(1.0, 0.85)
    at = curve.state(np.zeros(1))
    bent = measure(np.ones(1), at.f, at.alpha, np.array([curve.x1_init]), np.array([0.85]))
    assert bent.curvature == pytest.approx(-at.reaction_m, rel=1e-9)
    assert bent.strain == pytest.approx(-at.reaction_m / 2, rel=1e-9)
    assert bent.turn == pytest.approx(np.pi / 2 - at.phi1, abs=1e-9)


def test_the_ledger_as_a_table_and_to_read(evidence, tmp_path):
    table = claims_table(
        [named("force unit"), named("example rod")], evidence, study="paper", method="shooting"
    )
    assert (
        table.select(["study", "method"]).to_pylist()
        == [{"study": "paper", "method": "shooting"}] * 2
    )
    store.write(table, tmp_path / "claims.parquet")
    assert store.read(tmp_path / "claims.parquet", schemas.CLAIMS).equals(table)
    row = table.to_pylist()[0]
    finding = named("force unit").judge(evidence)
    assert dict(zip(row["quantity_name"], row["quantity_value"], strict=True)) == {
        name: value for name, (value, _) in finding.quantities.items()
    }
    assert (row["verdict"], row["reason"]) == (finding.verdict, finding.reason)
    lines = markdown(table).splitlines()
    assert lines[2].startswith("2 statements: 1 holds, 1 contradicted. ")
    assert "force: 6996.8 N" in lines[6] and "**contradicted**" in lines[7]
    # A bar inside a cell is not the cell's end.
    assert all(line.replace("\\|", "").count("|") == 6 for line in lines[4:])


@pytest.mark.slow
def test_the_ledger_reads_as_before(ledger, snapshot):
    # Rounding errors differ from machine to machine.
    assert re.sub(r"[\d.]+e-1\d", "~0", markdown(ledger)) == snapshot


@pytest.mark.parametrize(
    ("table", "status", "where"),
    [
        ("stiction", "failed", "grid 'taper'"),
        ("stiction", "lock", "grid 'taper'"),
        ("scans", "lock", "scan 'nine_cycles'"),
        ("states", "failed", "state 'penetrating'"),
    ],
)
def test_nothing_is_judged_by_what_failed(paper, study_tables, table, status, where):
    rows = study_tables[table].to_pylist()
    rows[0]["status"] = status
    doctored = study_tables[table].from_pylist(rows, schema=study_tables[table].schema)
    with pytest.raises(TableError, match=f"rows of the {where} have the status {status}"):
        gather(study_tables | {table: doctored}, dict(paper.claims))


@pytest.mark.parametrize(
    ("status", "change"),
    [("lock", {"x0_trail": None}), ("lock", {"status": "slip"}), ("slip", {"status": "lock"})],
)
def test_points_on_both_sides_of_the_lock_are_needed(paper, study_tables, status, change):
    table = study_tables["stiction"]
    rows = [
        row | change if (row["grid"], row["status"]) == ("friction", status) else row
        for row in table.to_pylist()
    ]
    doctored = table.from_pylist(rows, schema=table.schema)
    with pytest.raises(TableError, match="grid 'friction' needs at least 3 values of μ0 below"):
        gather(study_tables | {"stiction": doctored}, dict(paper.claims))


def test_a_line_is_fitted_and_its_largest_deviation_is_on_either_side():
    x = np.arange(5.0)
    line = line_fit(x, 3.0 - 2.0 * x)
    assert (line.slope, line.r_squared) == (pytest.approx(-2.0), pytest.approx(1.0))
    assert line.deviation == pytest.approx(0.0, abs=1e-12)
    # One point that is off by one, in the middle of five, is off the line by 0.8.
    for off in (1.0, -1.0):
        line = line_fit(x, off * (x == 2.0))
        assert line.slope == pytest.approx(0.0, abs=1e-12)
        assert line.deviation == pytest.approx(0.8)
        assert line.r_squared == pytest.approx(0.0, abs=1e-12)
