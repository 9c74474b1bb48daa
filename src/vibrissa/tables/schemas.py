"""Which columns each table has, in which order: its Arrow schema.

The meaning, unit and range of each column are in data_dictionary.toml.
"""

import tomllib
from importlib.resources import files

import pyarrow as pa

from vibrissa.study.axes import AXES, LAW_AXES, POWERS, SURFACE_AXES

# To be raised when a column changes its meaning, name or type: older files are then refused.
SCHEMA_VERSION = "10"

NONE = "1"
TEXT, NUMBER, WHOLE, FLAG = pa.string(), pa.float64(), pa.int64(), pa.bool_()
NUMBERS, TEXTS = pa.list_(NUMBER), pa.list_(TEXT)
_TYPES = {
    "number": NUMBER,
    "text": TEXT,
    "whole": WHOLE,
    "flag": FLAG,
    "numbers": NUMBERS,
    "texts": TEXTS,
}
# Keys of a column's metadata, in the order of display.
UNIT, RANGE, NULL, EQUATION, DESCRIPTION = b"unit", b"range", b"null", b"equation", b"description"

NO_RESULT = "no result"
NO_SLIP = "the tip is self-locking, or no result"
NO_END = "the tip slips forward, the path was not followed to its end, or no result"
NO_TRAIL = (
    "the rod does not buckle laterally; its mounting is not ideal; μ0 is above about 3, where the "
    "path in retraction ends; or no result"
)
# When a stability margin is unknown although the state is known.
UNKNOWN_MARGINS = {
    "stability": "method shooting",
    "stability_aside": "method shooting, or section planar",
}

DICTIONARY = tomllib.loads(
    files("vibrissa.tables").joinpath("data_dictionary.toml").read_text(encoding="utf-8")
)


def _field(name: str, entry: dict[str, str]) -> pa.Field:
    """Make a column; it is nullable only if the dictionary defines the meaning of null."""
    metadata = {
        UNIT: entry.get("unit", NONE),
        RANGE: entry.get("range", ""),
        NULL: entry.get("null", ""),
        EQUATION: entry.get("equation", ""),
        DESCRIPTION: entry["description"],
    }
    kind = _TYPES[entry.get("type", "number")]
    return pa.field(name, kind, bool(entry.get("null")), metadata)


def _state(suffix: str = "", when: str = "", null: str = NO_RESULT) -> list[pa.Field]:
    """Make the columns of a state: `when` names the state, `null` explains missing values."""
    return [
        _field(
            f"{name}{suffix}",
            entry
            | {
                "description": entry["description"] + when,
                "null": f"{null}; or {UNKNOWN_MARGINS[name]}" if name in UNKNOWN_MARGINS else null,
            },
        )
        for name, entry in DICTIONARY["state"].items()
    ]


def _frequencies(when: str = "", null: str = NO_RESULT) -> list[pa.Field]:
    """Make the columns of natural frequencies: `when` names the state."""
    return [
        _field(
            name,
            entry
            | {
                "description": entry["description"] + when,
                "null": f"{entry['null']}; {null}",
            },
        )
        for name, entry in DICTIONARY["frequencies"].items()
    ]


def _loads(suffix: str, when: str) -> list[pa.Field]:
    """Make the columns of the loads on the clamp at an end of a slip."""
    null = {"null": DICTIONARY["periods"][f"x0{suffix}"]["null"]}
    loads = ("reaction_fx", "reaction_fy", "reaction_m")
    entries = {name: DICTIONARY["state"][name] for name in loads}
    return [
        _field(f"{name}{suffix}", entry | null | {"description": entry["description"] + when})
        for name, entry in entries.items()
    ]


def _compared(contact: str, when: str) -> list[pa.Field]:
    """Make the columns of a point's solution in one kind of contact."""
    points, state = DICTIONARY["stiction"], DICTIONARY["state"]
    onset = {"null": NO_SLIP}
    columns = {
        "status": points["status"],
        "x0_slip": points["x0_slip"],
        "f_slip": state["f"] | onset,
        "reaction_m_slip": state["reaction_m"] | onset,
        "mu_lock": points["mu_lock"],
        "residual": points["residual"],
    }
    return [
        _field(f"{name}_{contact}", entry | {"description": entry["description"] + when})
        for name, entry in columns.items()
    ]


def _schema(table: str, *columns: str | list[pa.Field]) -> pa.Schema:
    """Make a schema from columns: names in the data dictionary, or fields."""
    of_scan = DICTIONARY["scans"] if table in ("periods", "friction") else {}
    known = DICTIONARY["shared"] | of_scan | DICTIONARY[table]
    fields = [
        field
        for part in columns
        for field in (
            [_field(name, known[name]) for name in part.split()] if isinstance(part, str) else part
        )
    ]
    return pa.schema(fields, {"vibrissa.table": table, "vibrissa.schema": SCHEMA_VERSION})


# The axes, and the further coefficients of polynomials.
_POINT = " ".join((*AXES, *POWERS.values()))
# The axes of scans that a point does not have.
_SCAN = f"surface {' '.join(SURFACE_AXES | LAW_AXES)}"
_SHAPE = "shape_s shape_x shape_y shape_phi"
STATE = tuple(_field(name, entry) for name, entry in DICTIONARY["state"].items())

STICTION = _schema(
    "stiction",
    f"study method grid {_POINT}",
    "status message contact x0_slip x0_max n_steps mu_lock x0_lock",
    _state("_init", ", at α = 0"),
    _state("_last", ", in the last sticking state on the step grid", NO_SLIP),
    _state("_slip", ", at the exact onset of slip", NO_SLIP),
    _frequencies(", at the exact onset of slip", NO_SLIP),
    "ends_by x0_end",
    _state("_end", ", where sticking of a locked tip in the plane ends", NO_END),
    "x0_trail",
    _state("_trail", ", in the last sticking state after the rod has buckled laterally", NO_TRAIL),
    "x1_init penetrates residual",
)
SCANS = _schema(
    "scans",
    f"study method scan {_POINT} {_SCAN}",
    "status message cycle step phase side footpoint x0 x1 mu0_tip",
    "height inclination apparent_friction",
    _state(),
    _frequencies(),
    f"residual {_SHAPE}",
)
PERIODS = _schema(
    "periods",
    f"study method scan {_POINT} {_SCAN}",
    "status message period ends_by side steps",
    "footpoint_begin footpoint_last footpoint_onset footpoint_slip travel",
    "x1 x1_rest slip_length mu0_tip height inclination apparent_friction x0_onset x0_rest",
    _loads("_onset", ", at the exact end of sticking"),
    _loads("_rest", ", after the slip"),
    "released dissipated",
)
FRICTION = _schema(
    "friction",
    f"study readings {_POINT} {_SCAN}",
    "transducer modulus diameter length recording read_by status message grade",
    "mu0_true mu0_read mu0_deviation mu0_random mu0_common mu0_low mu0_high inside",
    "periods_true periods_read periods_used period_error period_deviation predicted",
    "way strain saturated penetrates limit_name limit_share",
)
STATES = _schema(
    "states",
    "study method state theta eta x1 status message contact",
    _state(),
    _frequencies(),
    f"penetrates residual {_SHAPE}",
)
COMPARISONS = _schema(
    "comparisons",
    "study method comparison theta mu0 eta penetrates",
    _compared("point", ", in tip contact"),
    _compared("line", ", in line contact"),
)
CLAIMS = _schema(
    "claims",
    "study method claim section statement computed",
    "quantity_name quantity_value quantity_unit verdict reason",
)

SHAPE = tuple(SCANS.field(name) for name in _SHAPE.split())
# Columns of the loads at both ends of a slip.
LOADS = tuple(name for name in PERIODS.names if name.startswith("reaction_"))
# Schemas of all tables of a study, by name.
TABLES = {
    schema.metadata[b"vibrissa.table"].decode(): schema
    for schema in (STICTION, SCANS, PERIODS, FRICTION, STATES, COMPARISONS, CLAIMS)
}
