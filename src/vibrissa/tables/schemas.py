"""The Arrow schema of each table. It is the data dictionary, too: every column says what it is.

The metadata of a column are its unit, the range of its values, what null means in it, the equation
that it satisfies, and a description. Equations with a number or a letter are those of
docs/model.md. docs/tables.md and the report show all of it.
"""

from collections.abc import Sequence

import pyarrow as pa

from vibrissa.outcomes import Contact, End, Parameter, RodSection, Solver, Status

# Goes up when a column changes its meaning, name or type: older files are refused.
SCHEMA_VERSION = "6"

LENGTH, FORCE, MOMENT, ANGLE, NONE = "L", "E*I0/L^2", "E*I0/L", "rad", "1"
COMPLIANCE, CURVATURE = "rad*L/(E*I0)", "1/L"
TEXT, NUMBER, WHOLE, FLAG = pa.string(), pa.float64(), pa.int64(), pa.bool_()
NUMBERS, TEXTS = pa.list_(NUMBER), pa.list_(TEXT)
# Ranges of numbers as intervals.
ANY, POSITIVE, NOT_NEGATIVE = "(−∞, ∞)", "(0, ∞)", "[0, ∞)"
# What null means.
NO_RESULT = "no result"
NO_SLIP = "the tip is self-locking, or no result"
NO_LOCK = "the tip slips forward, or no result"
NO_END = "the tip slips forward, its path was not followed to the end, or no result"
NO_TRAIL = (
    "the rod does not swing aside, or not in the ideal mounting; its pulled path was not followed "
    "so far (about μ0 = 3); or no result"
)
# Names of what is in a column's metadata, in the order in which they are shown.
UNIT, RANGE, NULL, EQUATION, DESCRIPTION = b"unit", b"range", b"null", b"equation", b"description"


def _words(*words: str) -> str:
    """Range of a column of words."""
    return ", ".join(words)


def _column(
    name: str,
    unit: str,
    description: str,
    *,
    kind: pa.DataType = NUMBER,
    range: str = "",
    null: str = "",
    equation: str = "",
) -> pa.Field:
    """Column that holds null only if it is said what null means."""
    said = {UNIT: unit, RANGE: range, NULL: null, EQUATION: equation, DESCRIPTION: description}
    return pa.field(name, kind, bool(null), {key: text.encode() for key, text in said.items()})


def _text(name: str, description: str, *, range: str = "", null: str = "") -> pa.Field:
    """Column of texts."""
    return _column(name, NONE, description, kind=TEXT, range=range, null=null)


def _changed(column: pa.Field, suffix: str, when: str, null: str) -> pa.Field:
    """Column of the same quantity under another name, at another state."""
    said = {key: value.decode() for key, value in column.metadata.items()}
    return _column(
        f"{column.name}{suffix}",
        said[UNIT],
        said[DESCRIPTION] + when,
        kind=column.type,
        range=said[RANGE],
        null=f"{null}; or {UNKNOWN_MARGINS[column.name]}"
        if null and column.name in UNKNOWN_MARGINS
        else null,
        equation=said[EQUATION],
    )


def _exact(column: pa.Field) -> pa.Field:
    """Column of the same quantity as an exact decimal, or several of a polynomial."""
    said = {key: value.decode() for key, value in column.metadata.items()}
    polynomial = column.name == "curvature"
    return _column(
        column.name,
        said[UNIT],
        f"{said[DESCRIPTION]}, exact decimal"
        if not polynomial
        else "natural curvature of the rod, exact decimals: the coefficients of 1, s, s², …",
        range="" if polynomial else said[RANGE],
        equation=said[EQUATION],
        kind=TEXT,
    )


def _schema(name: str, columns: Sequence[pa.Field]) -> pa.Schema:
    return pa.schema(columns, {"vibrissa.table": name, "vibrissa.schema": SCHEMA_VERSION})


# Tables of several studies may be put one below the other: every row says where it is from.
ORIGIN = (
    _text("study", "name of the study", range="letters, digits, _ and -"),
    _text("method", "how the sticking equilibria were solved", range=_words(*Solver)),
)
THETA = _column(
    "theta",
    NONE,
    "taper factor: diameter of the base over diameter of the tip",
    range="[1, ∞)",
    equation="θ = d0/d1 (1)",
)
ETA = _column("eta", LENGTH, "clamp–surface distance", range="(0, 1)", equation="y(1) = η")
AXES = (
    THETA,
    _column("mu0", NONE, "coefficient of static friction", range=POSITIVE),
    ETA,
    _column("dx0", LENGTH, "step of the clamp", range=POSITIVE),
)
MOUNTING = (
    _column(
        "clamp_angle",
        ANGLE,
        "inclination of the clamp, positive where the rod leans back",
        range="(−π/2, π/2)",
        equation="β in φ(0) = π/2 + β + c·m(0)",
    ),
    _column(
        "clamp_compliance",
        COMPLIANCE,
        "turn of the clamp per moment",
        range=NOT_NEGATIVE,
        equation="c in φ(0) = π/2 + β + c·m(0)",
    ),
    _column(
        "curvature",
        CURVATURE,
        "natural curvature of the rod, negative where it turns away from the surface; at s = 0 "
        "where it is not constant",
        range=ANY,
        equation="κ0 in m = B·(φ' − κ0)",
    ),
    _column(
        "stage_angle",
        ANGLE,
        "angle of the stage to the surface, positive where it approaches",
        range="(−π/2, π/2)",
        equation="δ in height = η − x0·sin δ",
    ),
)
# Beside them: what one number does not say.
CURVATURE_POWERS = _column(
    "curvature_powers",
    CURVATURE,
    "coefficients of s, s², … in the natural curvature, after the constant, exact decimals",
    null="the natural curvature is constant",
    equation="κ0 = curvature + curvature_powers·(s, s², …)",
    kind=TEXT,
)
ADDED_TO = _column(
    "added_to",
    NONE,
    "names of those of these grids that refine added the point to",
    null="the point is on the axes of all its grids",
    kind=TEXTS,
)
# Columns that tables of this version may not have yet: they hold null.
YOUNGER = (CURVATURE_POWERS.name, ADDED_TO.name)
STABILITY, STABILITY_ASIDE = "stability", "stability_aside"
# Where a margin is not known although the state is.
UNKNOWN_MARGINS = {
    STABILITY: "method shooting",
    STABILITY_ASIDE: "method shooting, or section planar",
}
STATE = (
    _column(
        "f",
        FORCE,
        "contact force of the surface on the rod, magnitude",
        range=POSITIVE,
        equation="(fx, fy) = f·(sin α, −cos α)",
    ),
    _column(
        "alpha",
        ANGLE,
        "inclination of the contact force against the normal of the surface",
        range="(−π/2, π/2)",
        equation="tan α = −fx/fy",
    ),
    _column(
        "phi1",
        ANGLE,
        "tangent angle at the contact point",
        range="(−π, 2π)",
        equation="φ1 = φ(s_c)",
    ),
    _column(
        "s_c",
        LENGTH,
        "arc length of the contact point; 1 in tip contact",
        range="(0, 1]",
        equation="s_c = 1 (E4a) or φ(s_c) = 0 (E4b)",
    ),
    _column(
        "reaction_fx",
        FORCE,
        "load of the rod on the clamp, force along the surface",
        range=ANY,
        equation="fx = f·sin α",
    ),
    _column(
        "reaction_fy",
        FORCE,
        "load of the rod on the clamp, force along the normal of the surface",
        range="(−∞, 0)",
        equation="fy = −f·cos α",
    ),
    _column(
        "reaction_m",
        MOMENT,
        "load of the rod on the clamp, moment",
        range=ANY,
        equation="m(0) = φ'(0)",
    ),
    _column(
        STABILITY,
        NONE,
        "smallest eigenvalue of the second variation; positive where the rod is stable",
        range="(−∞, 1]",
        equation="(8)",
    ),
    _column(
        STABILITY_ASIDE,
        NONE,
        "smallest eigenvalue of the second variation out of the plane; positive where a round rod "
        "stays in its plane",
        range="(−∞, 1]",
        equation="(D1) of aside.md",
    ),
)
RESIDUAL = (
    "largest residual of the equilibrium path: by collocation of E1 to E4, in rad and L, also "
    "between its nodes and its states; by shooting the distance of the tip from the contact point "
    "in L"
)


def _state_columns(suffix: str = "", when: str = "", null: str = "") -> list[pa.Field]:
    return [_changed(column, suffix, when, null) for column in STATE]


def _state_lists() -> list[pa.Field]:
    """Columns of those quantities of the states of a path from which the others follow."""
    loads = ("reaction_fx", "reaction_fy", "reaction_m")
    followed = (*loads, "phi1", "s_c", STABILITY, STABILITY_ASIDE)
    columns = {column.name: _changed(column, "", ", of the states", "") for column in STATE}
    return [columns[name].with_type(NUMBERS) for name in followed]


def _status(*statuses: Status) -> pa.Field:
    return _text("status", "outcome", range=_words(*statuses))


MESSAGE = _text("message", "why there is no result, and what to try; or empty")
X1_INIT = _column(
    "x1_init",
    LENGTH,
    "position of the contact point at α = 0, with the clamp at 0",
    range=POSITIVE,
    null=NO_RESULT,
    equation="α = 0 (E3b)",
)
MU_LOCK = _column(
    "mu_lock",
    NONE,
    "critical friction coefficient: above it the tip is self-locking; infinite where it lifts off",
    range="(0, ∞]",
    null=NO_RESULT,
    equation="μ_lock = max −tan α(x0)",
)
X0_LOCK = _column(
    "x0_lock",
    LENGTH,
    "clamp displacement of the critical state",
    range=NOT_NEGATIVE,
    null=NO_RESULT,
    equation="−tan α(x0_lock) = μ_lock",
)
X0_SLIP = _column(
    "x0_slip",
    LENGTH,
    "clamp displacement at the exact onset of slip",
    range=NOT_NEGATIVE,
    null=NO_SLIP,
    equation="−tan α(x0_slip) = μ0",
)
CONTACT = _text("contact", "kind of contact", range=_words(*Contact), null=NO_RESULT)

CURVES = _schema(
    "curves",
    [
        _text("theta", "taper factor, exact decimal", range="[1, ∞)"),
        _column("eta", LENGTH, "clamp–surface distance, exact decimal", range="(0, 1)", kind=TEXT),
        _column(
            "dx0",
            LENGTH,
            "step of the clamp at which the path was followed, exact decimal",
            range=POSITIVE,
            null="the path serves all steps (method collocation)",
            kind=TEXT,
        ),
        *(_exact(column) for column in MOUNTING),
        ORIGIN[1],
        _text(
            "section",
            "whether the rod may leave its plane",
            range=_words(*RodSection),
        ),
        _status(Status.SOLVED, Status.OUT_OF_REACH, Status.FAILED),
        MESSAGE,
        _text(
            "ends_by",
            "how the path ends",
            range=_words(
                End.SWINGS_ASIDE, End.SNAPS, End.OUT_OF_REACH, End.LIFTS_OFF, End.NOT_FOLLOWED
            ),
        ),
        _text("end_message", "more about the end of the path, or empty"),
        X1_INIT,
        _column("residual", NONE, RESIDUAL, range=NOT_NEGATIVE, null=NO_RESULT),
        X0_LOCK,
        MU_LOCK,
        _column(
            "x0_touch",
            LENGTH,
            "first clamp displacement at which the rod touches the surface tangentially",
            range=NOT_NEGATIVE,
            null="it does so nowhere on the path, or no result",
            equation="φ1(x0_touch) = 0",
        ),
        _column(
            "piece_contact", NONE, "kind of contact of each smooth piece of the path", kind=TEXTS
        ),
        _column(
            "piece_states", NONE, "number of states on each smooth piece", kind=pa.list_(WHOLE)
        ),
        _column(
            "piece_parameter",
            NONE,
            "parameter that orders the states: clamp displacement, or continuation parameter",
            range=_words(*Parameter),
            equation="(9)",
            kind=TEXTS,
        ),
        _column("piece_start", NONE, "first value of the parameter (x0 in L)", kind=NUMBERS),
        _column("piece_stop", NONE, "last value of the parameter (x0 in L)", kind=NUMBERS),
        _column("x0", LENGTH, "clamp displacement, of the states", range=ANY, kind=NUMBERS),
        *_state_lists(),
    ],
)

STICTION = _schema(
    "stiction",
    [
        *ORIGIN,
        _column("grids", NONE, "names of the grids that the point belongs to", kind=TEXTS),
        ADDED_TO,
        *AXES,
        *MOUNTING,
        CURVATURE_POWERS,
        _text(
            "status",
            "outcome: the tip slips forward, or is self-locking; the shape is inadmissible; or no "
            "result of the promised accuracy",
            range=_words(Status.SLIP, Status.LOCK, Status.OUT_OF_REACH, Status.FAILED),
        ),
        MESSAGE,
        _changed(CONTACT, "", " at the onset of slip, or in the critical state", NO_RESULT),
        X0_SLIP,
        _column(
            "x0_max",
            LENGTH,
            "clamp displacement of the last sticking state on the step grid; the paper's x0,max",
            range=NOT_NEGATIVE,
            null=NO_SLIP,
            equation="x0,max = n_steps·Δx0",
        ),
        _column(
            "n_steps",
            NONE,
            "steps of the clamp to the last sticking state",
            range=NOT_NEGATIVE,
            null=NO_SLIP,
            equation="n_steps = ⌊x0_slip/Δx0⌋",
            kind=WHOLE,
        ),
        MU_LOCK,
        X0_LOCK,
        *_state_columns("_init", ", at α = 0", NO_RESULT),
        *_state_columns("_last", ", in the last sticking state on the step grid", NO_SLIP),
        *_state_columns("_slip", ", at the exact onset of slip", NO_SLIP),
        _text(
            "ends_by",
            "how sticking in the plane ends after self-locking",
            range=_words(
                End.SWINGS_ASIDE, End.SLIPS_BACK, End.SNAPS, End.OUT_OF_REACH, End.NOT_FOLLOWED
            ),
            null=NO_LOCK,
        ),
        _column(
            "x0_end",
            LENGTH,
            "clamp displacement at which sticking in the plane ends after self-locking",
            range=NOT_NEGATIVE,
            null=NO_END,
            equation="x0_end = x1_init − (1 − s_c), or in another mounting than the ideal one "
            "stability_aside = 0 (swings_aside); tan α(x0_end) = μ0 (slips_back); x0_end = max x0 "
            "(snaps)",
        ),
        *_state_columns("_end", ", where sticking in the plane ends after self-locking", NO_END),
        _column(
            "x0_trail",
            LENGTH,
            "clamp displacement at which the tip slips after the rod has swung aside; from then on "
            "it is dragged",
            range=NOT_NEGATIVE,
            null=NO_TRAIL,
            equation="x0_trail = 2·x0_end + |x0_pulled(μ0)| (D8)",
        ),
        *_state_columns(
            "_trail", ", in the last sticking state after the rod has swung aside", NO_TRAIL
        ),
        X1_INIT,
        _column(
            "penetrates",
            NONE,
            "whether the rod passes through the surface at its tip, up to the last sticking state "
            "or the critical state",
            null=NO_RESULT,
            equation="φ1 < 0 and s_c = 1",
            kind=FLAG,
        ),
        _column("residual", NONE, RESIDUAL, range=NOT_NEGATIVE, null=NO_RESULT),
    ],
)


def _model_columns(suffix: str, contact: str) -> list[pa.Field]:
    """Columns of a comparison for one kind of contact."""
    state = {column.name: column for column in STATE}
    return [
        _changed(STICTION.field("status"), suffix, contact, ""),
        _changed(X0_SLIP, suffix, contact, NO_SLIP),
        _changed(state["f"], f"_slip{suffix}", f", at the exact onset of slip{contact}", NO_SLIP),
        _changed(
            state["reaction_m"], f"_slip{suffix}", f", at the exact onset of slip{contact}", NO_SLIP
        ),
        _changed(MU_LOCK, suffix, contact, NO_RESULT),
        _changed(STICTION.field("residual"), suffix, contact, NO_RESULT),
    ]


COMPARISONS = _schema(
    "comparisons",
    [
        *ORIGIN,
        _text("comparison", "name of the comparison"),
        *AXES[:3],
        _column(
            "penetrates",
            NONE,
            "whether the rod in tip contact passes through the surface, up to the onset of slip or "
            "the critical state",
            equation="φ1 < 0 and s_c = 1",
            kind=FLAG,
        ),
        *_model_columns("_point", ", in tip contact"),
        *_model_columns("_line", ", in line contact"),
    ],
)

SHAPE = (
    _column("shape_s", LENGTH, "arc lengths of points of the rod", range="[0, 1]", kind=NUMBERS),
    _column(
        "shape_x",
        LENGTH,
        "positions of these points along the surface",
        range=ANY,
        equation="x' = cos φ (2)",
        kind=NUMBERS,
    ),
    _column(
        "shape_y",
        LENGTH,
        "positions of these points from the clamp towards the surface",
        range=ANY,
        equation="y' = sin φ (2)",
        kind=NUMBERS,
    ),
    _column(
        "shape_phi",
        ANGLE,
        "tangent angles at these points",
        range=ANY,
        equation="(2)",
        kind=NUMBERS,
    ),
)

SCANS = _schema(
    "scans",
    [
        *ORIGIN,
        _text("scan", "name of the set of scans"),
        *AXES,
        *MOUNTING,
        CURVATURE_POWERS,
        _text(
            "status",
            "outcome; a self-locking rod that swings aside is dragged after its first period, "
            "another has one period, to where sticking ends",
            range=_words(Status.SLIP, Status.LOCK, Status.OUT_OF_REACH, Status.FAILED),
        ),
        _column(
            "cycle",
            NONE,
            "number of the stick-slip cycle; a cycle ends with its slip",
            range="[1, ∞)",
            null=NO_RESULT,
            kind=WHOLE,
        ),
        _column(
            "step",
            NONE,
            "steps of the clamp since the cycle began",
            range=NOT_NEGATIVE,
            null=NO_RESULT,
            kind=WHOLE,
        ),
        _text(
            "phase",
            "whether the tip has slipped in this step",
            range=_words("slip", "stick"),
            null=NO_RESULT,
        ),
        _column("footpoint", LENGTH, "clamp position", range=NOT_NEGATIVE, null=NO_RESULT),
        _column(
            "x0",
            LENGTH,
            "clamp displacement since the last state with α = 0",
            range=NOT_NEGATIVE,
            null=NO_RESULT,
            equation="x0 = step·Δx0 (stick), x0 = 0 (slip)",
        ),
        _column(
            "x1",
            LENGTH,
            "position of the contact point",
            range=POSITIVE,
            null=NO_RESULT,
            equation="x1 = x1_init + clamp position of the last slip",
        ),
        *_state_columns(null=NO_RESULT),
        _column(
            "residual",
            LENGTH,
            "distance of the contact point from the end of the shape, integrated independently",
            range=NOT_NEGATIVE,
            null=NO_RESULT,
        ),
        *SHAPE,
    ],
)

STATES = _schema(
    "states",
    [
        *ORIGIN,
        _text("state", "name of the state"),
        THETA,
        ETA,
        _column(
            "x1",
            LENGTH,
            "position of the contact point, with the clamp at 0",
            range=ANY,
            equation="x(1) = x1 (3)",
        ),
        _status(Status.SOLVED, Status.OUT_OF_REACH, Status.FAILED),
        MESSAGE,
        CONTACT,
        *_state_columns(null=NO_RESULT),
        _column(
            "penetrates",
            NONE,
            "whether the rod passes through the surface at its tip",
            null=NO_RESULT,
            equation="φ1 < 0 and s_c = 1",
            kind=FLAG,
        ),
        _column(
            "residual",
            NONE,
            "largest residual of E1 to E4, in rad and L",
            range=NOT_NEGATIVE,
            null=NO_RESULT,
        ),
        *SHAPE,
    ],
)

CLAIMS = _schema(
    "claims",
    [
        *ORIGIN,
        _text("claim", "short name of the statement"),
        _text("section", "section of the paper that makes it"),
        _text("statement", "what it says, in other words"),
        _text("computed", "what was computed to decide it"),
        _column("quantity_name", NONE, "what each computed quantity is", kind=TEXTS),
        _column(
            "quantity_value", NONE, "computed quantities, each in its unit", range=ANY, kind=NUMBERS
        ),
        _column("quantity_unit", NONE, "unit of each quantity", kind=TEXTS),
        _text(
            "verdict",
            "verdict on the statement",
            range=_words("holds", "holds with a condition", "ambiguous", "contradicted"),
        ),
        _text("reason", "the condition or the reason"),
    ],
)

# By name: the tables of a study, and at last what its blocks hold.
TABLES = {
    schema.metadata[b"vibrissa.table"].decode(): schema
    for schema in (STICTION, SCANS, STATES, COMPARISONS, CLAIMS, CURVES)
}
