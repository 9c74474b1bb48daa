"""Bring the sensor's tables in docs in line with the code: `python -m validation pages`."""

from pathlib import Path

from vibrissa.design.materials import MATERIALS, Material
from vibrissa.sensor.given.tolerances import TOLERABLE, Tolerable, told
from vibrissa.sensor.quantities import Units
from vibrissa.sensor.transducer import PRESETS, Transducer
from vibrissa.wording import markdown_table

DOCS = Path(__file__).parent
END = "<!-- end of what python -m validation pages made -->"


def assumed(name: str, one: Tolerable) -> str:
    """Write the size of a tolerance that is assumed."""
    if one.assumed.of_noise:
        return f"{one.assumed.size:g} deviations of the noise"
    size, unit = told(name, one.assumed.size, Units())
    own = f"{size:.6g} {unit}".strip()
    return f"{1e3 * one.assumed.si:g} mm, or {own}" if one.assumed.si else own


def tolerances() -> str:
    """Write the table of tolerances."""
    rows = [
        (f"`{n}`", one.what, assumed(n, one), one.assumed.reason) for n, one in TOLERABLE.items()
    ]
    return markdown_table(("name", "of", "assumed", "where it is from"), rows)


def material(name: str, one: Material) -> tuple[str, ...]:
    """Cells of a material."""
    strain, density = f"{one.yield_strain:.2%}", f"{one.density:g}"
    return f"`{name}`", f"{one.modulus / 1e9:.4g}", strain, density, f"{one.name}. {one.source}"


def materials() -> str:
    """Write the table of materials."""
    head = ("preset", "E / GPa", "yield strain", "density / kg/m³", "what it is, and source")
    return markdown_table(head, [material(name, one) for name, one in MATERIALS.items()])


def transducer(name: str, one: Transducer) -> tuple[str, ...]:
    """Cells of a transducer."""
    x, y, z = one.noise
    limit = "{:g} N, {:g} N, {:g} N·m".format(*one.limit)
    return f"`{name}`", limit, f"{1e3 * x:.3g} mN, {1e3 * y:.3g} mN, {1e3 * z:.3g} N·mm", one.source


def transducers() -> str:
    """Write the table of transducers."""
    head = ("preset", "largest force_x, force_y, moment_z", "noise", "source")
    return markdown_table(head, [transducer(name, one) for name, one in PRESETS.items()])


# Page and writer of each table.
TABLES = {
    "tolerances": ("tolerances.md", tolerances),
    "materials": ("design.md", materials),
    "transducers": ("design.md", transducers),
}


def replaced(page: str, what: str) -> str:
    """Put a table between its marks in a page."""
    begin = f"<!-- {what}, made by python -m validation pages -->\n"
    before, _, rest = page.partition(begin)
    return before + begin + TABLES[what][1]() + "\n" + END + rest.partition(END)[2]


if __name__ == "__main__":
    for what, (name, _) in TABLES.items():
        page = DOCS / name
        page.write_text(replaced(page.read_text(encoding="utf-8"), what), encoding="utf-8")
