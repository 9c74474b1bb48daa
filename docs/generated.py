"""Write the generated parts of the pages, and the JSON Schema of the study file, from the code.

A page holds each part between two marks; `python -m validation pages` replaces the part.
"""

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import grimp
import pyarrow as pa

from vibrissa.design.materials import MATERIALS
from vibrissa.quantities.units import Units
from vibrissa.sensor.tolerances import TOLERABLE, Tolerable, displayed
from vibrissa.sensor.transducer import PRESETS
from vibrissa.study.axes import AXES, TEXTURE_AXES, spell_values
from vibrissa.study.claims import Claims
from vibrissa.study.figures import FIGURE_KINDS, TABLES
from vibrissa.study.json_schema import study_schema
from vibrissa.tables import schemas
from vibrissa.tables.frames import spell_unit
from vibrissa.wording import markdown_table

DOCS = Path(__file__).parent
SCHEMA = DOCS.parent / "workflow/schemas/study.schema.json"
PACKAGE = "vibrissa"
# Axes of the heights of a surface, which have a table of their own.
HEIGHT_AXES = tuple(TEXTURE_AXES)
STATE_SUFFIXES = ("", "_init", "_last", "_slip", "_end", "_trail")


def packages() -> str:
    """Table of the packages: name, purpose, and the packages that each imports."""
    graph = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
    names = {name for name in graph.find_children(PACKAGE) if graph.find_children(name)}
    rows = []
    for name in sorted(names):
        imported = {
            ".".join(other.split(".")[:2])
            for module in graph.find_descendants(name) | {name}
            for other in graph.find_modules_directly_imported_by(module)
        }
        others = sorted(other.split(".")[1] for other in imported & names - {name})
        purpose = (import_module(name).__doc__ or "").partition("\n")[0]
        rows.append((f"`{name.split('.')[1]}`", purpose, ", ".join(others)))
    return markdown_table(("package", "purpose", "imports"), rows)


def section_keys(name: str, known: dict[str, Any] | None = None) -> str:
    """Table of the keys of a section of the study file, except the keys in `known`."""
    schema = study_schema()
    part = schema["$defs"][name] if name else schema
    rows = []
    for key, value in part["properties"].items():
        if known and known.get(key) == value:
            continue
        default = value.get("default")
        shown = "" if default in (None, "", {}) else f"`{json.dumps(default)}`"
        needed = "required" if key in part.get("required", ()) else shown
        rows.append((f"`{key}`", value["description"], needed))
    return markdown_table(("key", "description", "default"), rows)


def grid_keys() -> dict[str, Any]:
    """Schemas of the keys of a grid; scans and comparisons have the same keys."""
    return study_schema()["$defs"]["GridSection"]["properties"]


def points_keys() -> str:
    """Table of the keys of a grid with the points of a file, except the axes."""
    properties = study_schema()["$defs"]["PointsSection"]["properties"]
    return section_keys("PointsSection", {axis: properties[axis] for axis in AXES})


def figure_kinds() -> str:
    """Table of the kinds of figures."""
    rows = [
        (
            f"`{name}`",
            kind.shows,
            f"`{kind.source}` (table `{TABLES[kind.source]}`)" if kind.source else "any of them",
            ", ".join(
                f"`{key}`"
                for key in (kind.required, *kind.single)
                if key and key not in HEIGHT_AXES
            ),
        )
        for name, kind in FIGURE_KINDS.items()
    ]
    head = ("kind", "what it shows", "drawn from", "axes with one value; required keys")
    return markdown_table(head, rows)


def figure_keys() -> str:
    """Table of the keys of a figure, except the axes."""
    properties = study_schema()["$defs"]["Figure"]["properties"]
    return section_keys("Figure", {axis: properties[axis] for axis in (*AXES, *HEIGHT_AXES)})


def texture_keys() -> str:
    """Table of the keys of the heights of a surface, which are axes of its scans."""
    sections = ("wave", "grooves", "rough")
    rows = [
        (f"`{name}`", f"`{name.replace('_', ': {', 1)}: …}}`", axis.meaning)
        for name, axis in TEXTURE_AXES.items()
        if name.startswith(sections)
    ]
    return markdown_table(("axis", "in the study file", "description"), rows)


def claims() -> str:
    """Table of the section `claims`: its keys, and the values that the data must have."""
    rows = []
    for key, value in study_schema()["$defs"]["Claims"]["properties"].items():
        needs = [
            f"{axis} = {spell_values(values)}{' only' * (len(values) == 1)}"
            for axis, values in Claims.needed[key].items()
            if values != (0.0,)  # the axes of the mounting
        ]
        rows.append((f"`{key}`", value["description"], "; ".join(needs)))
    return markdown_table(("key", "description", "values that the data must have"), rows)


def column(field: pa.Field, names: str = "") -> tuple[str, ...]:
    """Row of a column: name, description with equation, unit, values, and the meaning of null."""
    text = {key.decode(): value.decode() for key, value in field.metadata.items()}
    # The columns of both kinds of contact are one row.
    meaning = text["description"].removesuffix(", in tip contact")
    meaning += f"; {text['equation']}" if text["equation"] else ""
    kind = str(field.type).replace("list<item: ", "list of ").replace(">", "")
    unit = spell_unit(text["unit"]) if "double" in kind else ""
    values = text["range"] if kind == "double" else f"{kind}: {text['range']}"
    return names or f"`{field.name}`", meaning, unit, values.removesuffix(": "), text["null"]


def columns(table: str) -> str:
    """Table of the columns of one table alone, of the shared columns, or of a state of the rod."""
    head = ("column", "description", "unit", "values", "null means")
    if table == "state":
        rows = [
            column(entry, ", ".join(f"`{entry.name}{suffix}`" for suffix in STATE_SUFFIXES))
            for entry in schemas.STATE
        ]
        return markdown_table(head, rows)
    shared, state = schemas.DICTIONARY["shared"], schemas.DICTIONARY["state"]
    known = {f"{name}{suffix}" for name in state for suffix in STATE_SUFFIXES}
    if table == "shared":
        found = {
            entry.name: entry
            for schema in schemas.TABLES.values()
            for entry in schema
            if entry.name in shared
        }
        return markdown_table(head, [column(found[name]) for name in shared])
    own = schemas.DICTIONARY[table]
    rows = []
    for entry in schemas.TABLES[table]:
        if entry.name.endswith("_point"):
            both = f"`{entry.name}`, `{entry.name.removesuffix('_point')}_line`"
            rows.append(column(entry, both))
        elif entry.name in own or entry.name not in shared.keys() | known:
            if not entry.name.endswith("_line"):
                rows.append(column(entry))
    return markdown_table(head, rows)


def tolerances() -> str:
    """Table of the tolerances: name, quantity, default, and the source of the default."""

    def assumed(name: str, one: Tolerable) -> str:
        if one.channel >= 0:
            return f"{one.size:g} deviations of the noise"
        if not one.size:
            return "exact"
        size, unit = displayed(name, one.size, Units())
        own = f"{size:.6g} {unit}".strip()
        return f"{1e3 * one.si:g} mm, or {own}" if one.si else own

    # Tolerances with the same default and the same reason share a row.
    rows: dict[tuple[str, str], tuple[list[str], list[str]]] = {}
    for name, one in TOLERABLE.items():
        key = assumed(name, one), one.reason
        names, meanings = rows.setdefault(key, ([], []))
        names.append(f"`{name}`")
        if one.what not in meanings:
            meanings.append(one.what)
    return markdown_table(
        ("name", "quantity", "default", "source or reason"),
        [
            (", ".join(names), "; ".join(meanings), size, reason)
            for (size, reason), (names, meanings) in rows.items()
        ],
    )


def materials() -> str:
    """Table of the materials."""
    rows = [
        (
            f"`{name}`",
            f"{one.modulus / 1e9:.4g}",
            f"{one.yield_strain:.2%}",
            f"{one.density:g}",
            f"{one.name}. {one.source}",
        )
        for name, one in MATERIALS.items()
    ]
    head = ("preset", "E / GPa", "yield strain", "density / kg/m³", "description, source")
    return markdown_table(head, rows)


def transducers() -> str:
    """Table of the transducers."""
    rows = []
    for name, one in PRESETS.items():
        x, y, z = one.noise
        limit = "{:g} N, {:g} N, {:g} N·m".format(*one.limit)
        noise = f"{1e3 * x:.3g} mN, {1e3 * y:.3g} mN, {1e3 * z:.3g} N·mm"
        rows.append((f"`{name}`", limit, noise, one.source))
    head = ("preset", "largest force_x, force_y, moment_z", "noise", "source")
    return markdown_table(head, rows)


def parts() -> dict[str, tuple[str, str]]:
    """Page and text of each generated part, by its name."""
    shared = grid_keys()
    return {
        "packages": ("architecture", packages()),
        "study": ("study_file", section_keys("")),
        "grids": ("study_file", section_keys("GridSection")),
        "points": ("study_file", points_keys()),
        "surfaces": ("study_file", section_keys("SurfaceSection")),
        "scans": ("study_file", section_keys("ScanSection", shared)),
        "readings": ("study_file", section_keys("ReadingSection")),
        "rods of readings": ("study_file", section_keys("RodSizes")),
        "states": ("study_file", section_keys("StateSection")),
        "heights": ("study_file", texture_keys()),
        "figures": ("study_file", figure_kinds()),
        "figure keys": ("study_file", figure_keys()),
        "claims": ("study_file", claims()),
        **{
            f"columns of {name}": ("tables", columns(name))
            for name in ("shared", "state", *schemas.TABLES)
        },
        "tolerances": ("friction", tolerances()),
        "materials": ("design", materials()),
        "transducers": ("simulate", transducers()),
    }


def pages() -> dict[Path, str]:
    """Text that each page with generated parts, and the JSON Schema, should have."""
    texts = {SCHEMA: json.dumps(study_schema(), indent=2) + "\n"}
    for name, (page, text) in parts().items():
        path = DOCS / f"{page}.md"
        begin, end = (
            f"<!-- {name}: made by python -m validation pages -->\n",
            f"<!-- end of {name} -->",
        )
        old = texts.get(path) or path.read_text(encoding="utf-8")
        before, mark, rest = old.partition(begin)
        if not mark or end not in rest:
            raise ValueError(f"{path} has no place for {name}: {begin}{end}")
        texts[path] = f"{before}{begin}{text}\n{end}{rest.partition(end)[2]}"
    return texts


if __name__ == "__main__":
    for path, text in pages().items():
        path.write_text(text, encoding="utf-8")
