"""The Arrow schema of each table, with a description and a unit on every column."""

from collections.abc import Sequence

import pyarrow as pa

# Goes up when a column changes its meaning, name or type: older files are refused.
SCHEMA_VERSION = "5"

LENGTH, FORCE, MOMENT, ANGLE, NONE = "L", "E*I0/L^2", "E*I0/L", "rad", "1"
TEXT, NUMBER, WHOLE, FLAG = pa.string(), pa.float64(), pa.int64(), pa.bool_()
NUMBERS = pa.list_(NUMBER)


def _column(
    name: str, kind: pa.DataType, unit: str, description: str, nullable: bool = False
) -> pa.Field:
    return pa.field(name, kind, nullable, {"unit": unit, "description": description})


def _schema(name: str, columns: Sequence[pa.Field]) -> pa.Schema:
    return pa.schema(columns, {"vibrissa.table": name, "vibrissa.schema": SCHEMA_VERSION})


# Tables of several studies may be put one below the other: every row says where it is from.
ORIGIN = (
    _column("study", TEXT, NONE, "name of the study"),
    _column("method", TEXT, NONE, "solver of the sticking equilibria: collocation or shooting"),
)
AXES = (
    _column("theta", NUMBER, NONE, "taper factor, base over tip diameter"),
    _column("mu0", NUMBER, NONE, "coefficient of static friction"),
    _column("eta", NUMBER, LENGTH, "distance between clamp and contact line"),
    _column("dx0", NUMBER, LENGTH, "footpoint displacement step"),
)
STATE = (
    ("f", FORCE, "contact force magnitude"),
    ("alpha", ANGLE, "contact force inclination; the force on the rod is f*(sin, -cos)(alpha)"),
    ("phi1", ANGLE, "slope at the contact point"),
    ("s_c", LENGTH, "arc length of the contact point, 1 in point contact"),
    ("reaction_fx", FORCE, "clamp reaction along the surface, f*sin(alpha)"),
    ("reaction_fy", FORCE, "clamp reaction normal to the surface, -f*cos(alpha)"),
    ("reaction_m", MOMENT, "clamp reaction moment, phi'(0)"),
    ("stability", NONE, "least second variation per bending energy, positive where stable"),
)
RESIDUAL = (
    "largest equilibrium misfit of the sticking curve: collocation, of the slope (rad) and the "
    "closing conditions (L), also between its nodes and states; shooting, of the tip's position (L)"
)


def _state_columns(suffix: str, when: str, nullable: bool) -> list[pa.Field]:
    return [
        _column(f"{name}{suffix}", NUMBER, unit, f"{description}{when}", nullable)
        for name, unit, description in STATE
    ]


CURVES = _schema(
    "curves",
    [
        _column("theta", TEXT, NONE, "taper factor, exact decimal"),
        _column("eta", TEXT, LENGTH, "distance between clamp and contact line, exact decimal"),
        _column("dx0", TEXT, LENGTH, "step of the walk, exact decimal; null: serves all", True),
        _column("method", TEXT, NONE, "collocation or shooting"),
        _column("status", TEXT, NONE, "solved, out_of_reach or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        _column("ends_by", TEXT, NONE, "snaps, out_of_reach, lifts_off or not_followed"),
        _column("end_message", TEXT, NONE, "more about the end of the curve, or empty"),
        _column("x1_init", NUMBER, LENGTH, "contact point at alpha = 0, clamp at 0", True),
        _column("residual", NUMBER, NONE, RESIDUAL, True),
        _column("x0_lock", NUMBER, LENGTH, "displacement at which -tan(alpha) is largest", True),
        _column("mu_lock", NUMBER, NONE, "largest value of -tan(alpha)", True),
        _column("x0_touch", NUMBER, LENGTH, "first displacement with phi1 = 0, if any", True),
        _column("piece_contact", pa.list_(TEXT), NONE, "kind of contact of each smooth piece"),
        _column("piece_states", pa.list_(WHOLE), NONE, "number of states on each smooth piece"),
        _column("piece_parameter", pa.list_(TEXT), NONE, "x0 or advance: what counts the states"),
        _column("piece_start", NUMBERS, NONE, "first value of the parameter (x0 in L)"),
        _column("piece_stop", NUMBERS, NONE, "last value of the parameter (x0 in L)"),
        _column("x0", NUMBERS, LENGTH, "footpoint displacements of the states, piece by piece"),
        _column("reaction_fx", NUMBERS, FORCE, "f*sin(alpha) of the states"),
        _column("reaction_fy", NUMBERS, FORCE, "-f*cos(alpha) of the states"),
        _column("reaction_m", NUMBERS, MOMENT, "phi'(0) of the states"),
        _column("phi1", NUMBERS, ANGLE, "slope at the contact point of the states"),
        _column("s_c", NUMBERS, LENGTH, "arc length of the contact point of the states"),
        _column("stability", NUMBERS, NONE, "least second variation of the states"),
    ],
)

STICTION = _schema(
    "stiction",
    [
        *ORIGIN,
        _column("grids", pa.list_(TEXT), NONE, "names of the grids that the point belongs to"),
        *AXES,
        _column(
            "status",
            TEXT,
            NONE,
            "slip, lock (the tip never slips forward), out_of_reach or failed",
        ),
        _column("message", TEXT, NONE, "why there is no result, or empty"),
        _column("contact", TEXT, NONE, "point or line, at the onset of slip or the lock", True),
        _column("x0_slip", NUMBER, LENGTH, "exact onset of slip", True),
        _column("x0_max", NUMBER, LENGTH, "last state of stiction on the step grid", True),
        _column("n_steps", WHOLE, NONE, "steps to the last state of stiction", True),
        _column("mu_lock", NUMBER, NONE, "largest friction at which the tip slips", True),
        _column("x0_lock", NUMBER, LENGTH, "onset of slip at that friction", True),
        *_state_columns("_init", ", at alpha = 0", True),
        *_state_columns("_last", ", at the last state of stiction", True),
        *_state_columns("_slip", ", at the exact onset of slip", True),
        _column("ends_by", TEXT, NONE, "past the lock: slips_back, snaps, out_of_reach", True),
        _column(
            "x0_end", NUMBER, LENGTH, "displacement at which sticking past the lock ends", True
        ),
        *_state_columns("_end", ", where sticking past the lock ends", True),
        _column("x1_init", NUMBER, LENGTH, "contact point at alpha = 0, clamp at 0", True),
        _column(
            "penetrates",
            FLAG,
            NONE,
            "point contact with phi1 < 0 up to the last state of stiction, or up to the lock",
            True,
        ),
        _column("residual", NUMBER, NONE, RESIDUAL, True),
    ],
)


def _model_columns(suffix: str) -> list[pa.Field]:
    """Column of a comparison for one contact model."""
    return [
        _column(f"status{suffix}", TEXT, NONE, "slip, lock, out_of_reach or failed"),
        _column(f"x0_slip{suffix}", NUMBER, LENGTH, "exact onset of slip", True),
        _column(f"f_slip{suffix}", NUMBER, FORCE, "contact force at the onset", True),
        _column(f"reaction_m_slip{suffix}", NUMBER, MOMENT, "clamp moment at the onset", True),
        _column(f"mu_lock{suffix}", NUMBER, NONE, "largest friction at which the tip slips", True),
        _column(f"residual{suffix}", NUMBER, NONE, RESIDUAL, True),
    ]


COMPARISONS = _schema(
    "comparisons",
    [
        *ORIGIN,
        _column("comparison", TEXT, NONE, "name of the comparison"),
        *AXES[:3],
        _column(
            "penetrates", FLAG, NONE, "point contact with phi1 < 0 up to the onset or to the lock"
        ),
        *_model_columns("_point"),
        *_model_columns("_line"),
    ],
)

SHAPE = (
    _column("shape_s", NUMBERS, LENGTH, "arc lengths of the shape's points"),
    _column("shape_x", NUMBERS, LENGTH, "positions along the surface of the shape's points"),
    _column("shape_y", NUMBERS, LENGTH, "positions normal to the surface of the shape's points"),
    _column("shape_phi", NUMBERS, ANGLE, "slopes of the shape's points"),
)
_SHAPE_RESIDUAL = (
    "distance of the contact point from the end of the shape, integrated independently"
)

SCANS = _schema(
    "scans",
    [
        *ORIGIN,
        _column("scan", TEXT, NONE, "name of the set of scans"),
        *AXES,
        _column(
            "status",
            TEXT,
            NONE,
            "slip, lock (one period, on past the lock), out_of_reach or failed",
        ),
        _column("cycle", WHOLE, NONE, "stick-slip cycle, from 1; it ends with its slip", True),
        _column("step", WHOLE, NONE, "steps since the cycle began", True),
        _column("phase", TEXT, NONE, "slip where the tip has just slipped, stick otherwise", True),
        _column("footpoint", NUMBER, LENGTH, "position of the clamp", True),
        _column("x0", NUMBER, LENGTH, "clamp displacement since the last alpha = 0 state", True),
        _column("x1", NUMBER, LENGTH, "position of the contact point", True),
        *_state_columns("", "", True),
        _column("residual", NUMBER, LENGTH, _SHAPE_RESIDUAL, True),
        *SHAPE,
    ],
)

STATES = _schema(
    "states",
    [
        *ORIGIN,
        _column("state", TEXT, NONE, "name of the state"),
        _column("theta", NUMBER, NONE, "taper factor, base over tip diameter"),
        _column("eta", NUMBER, LENGTH, "distance between clamp and contact line"),
        _column("x1", NUMBER, LENGTH, "contact point, clamp at 0"),
        _column("status", TEXT, NONE, "solved, out_of_reach or failed"),
        _column("message", TEXT, NONE, "what went wrong and what to try, or empty"),
        _column("contact", TEXT, NONE, "point or line", True),
        *_state_columns("", "", True),
        _column("penetrates", FLAG, NONE, "whether phi1 < 0: the shape passes the surface", True),
        _column("residual", NUMBER, NONE, RESIDUAL.replace(" of the sticking curve", ""), True),
        *SHAPE,
    ],
)


CLAIMS = _schema(
    "claims",
    [
        *ORIGIN,
        _column("claim", TEXT, NONE, "short name of the statement"),
        _column("section", TEXT, NONE, "section of the paper that makes it"),
        _column("statement", TEXT, NONE, "what it says, in other words"),
        _column("computed", TEXT, NONE, "what was computed to decide it"),
        _column("quantity_name", pa.list_(TEXT), NONE, "what each computed quantity is"),
        _column("quantity_value", NUMBERS, NONE, "computed quantities, each in its unit"),
        _column("quantity_unit", pa.list_(TEXT), NONE, "unit of each quantity"),
        _column("verdict", TEXT, NONE, "holds, holds with a condition, ambiguous or contradicted"),
        _column("reason", TEXT, NONE, "the condition or the reason"),
    ],
)
