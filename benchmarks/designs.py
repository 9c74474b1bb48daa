"""The paper's example rod against its limits, and the best rod of each material instead.

A Nano17 SI-12-0.12 reads it, the stage moves in steps of 50 µm, and friction is from 0.2 to 0.4.
"""

import argparse
import multiprocessing

from vibrissa.sensor.design import Verdict, design
from vibrissa.sensor.identification import Method
from vibrissa.sensor.materials import MATERIALS
from vibrissa.sensor.requirements import Requirements
from vibrissa.sensor.transducer import preset

SENSOR = preset("nano17-si-12-0.12")
TAPERS = (1.0, 2.0, 4.0)
STEEL = "steel-s235"
WIRE = "music-wire"
METHODS = (Method.FORCES, Method.MOMENT)


def asked(name, **others):
    """Ask for a rod made of a material."""
    stuff = MATERIALS[name]
    return Requirements(
        modulus=stuff.modulus,
        yield_strain=stuff.yield_strain,
        density=stuff.density,
        mu0=(0.2, 0.4),
        step=50e-6,
        noise=SENSOR.deviation,
        range=SENSOR.limit,
        **others,
    )


def paper(theta):
    """Row of the paper's rod with one taper."""
    size = {"diameter": (5e-3, 5e-3), "length": (0.1, 0.1)}
    rod = design(asked(STEEL, theta=(theta, theta), eta=(0.85, 0.85), **size))
    value = {check.name: check.value for check in rod.checks}
    strain, stress = value["strain"], value["strain"] * MATERIALS[STEEL].modulus
    thickest = (5e-3 * MATERIALS[name].yield_strain / strain for name in (STEEL, WIRE))
    thick = " | ".join(f"{1e3 * d:.2f} mm" for d in thickest)
    return (
        f"| {theta:g} | {strain:.1%} | {strain / MATERIALS[STEEL].yield_strain:.0f} times "
        f"| {stress / 1e9:.1f} GPa | {value['force_y']:.0f} N | {value['moment_z']:.0f} N·m "
        f"| {thick} |"
    )


def row(case):
    """Row of the best rod of a material."""
    name, method, others = case
    best = design(asked(name, method=method, **others))
    if best.verdict is not Verdict.FOUND:
        nearest = ", ".join(f"{c.name} {c.use:.2f} times" for c in best.checks if c.use > 1.001)
        return f"| {name} | {method} | none | | | | | {nearest} | | |"
    return (
        f"| {name} | {method} | {best.theta:.2f} | {best.eta:.3f} | {1e3 * best.diameter:.2f} mm "
        f"| {1e3 * best.length:.0f} mm | {best.deviation:.1e} | {', '.join(best.limited_by)} "
        f"| {best.helps['step']:.1e} | {best.helps['noise']:.1e} |"
    )


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=None)
    arguments = parser.parse_args()
    print(
        "| θ | largest strain | of S235's yield | E times strain | force_y | moment_z "
        "| thickest S235 | thickest music wire |"
    )
    print("| --- " * 8 + "|")
    for theta in TAPERS:
        print(paper(theta))
    print()
    # Of the paper's length, and of any length from 20 to 200 mm.
    paper_length = {"length": (0.1, 0.1)}
    cases = [(name, method, {}) for method in METHODS for name in MATERIALS]
    cases += [(name, method, paper_length) for method in METHODS for name in MATERIALS]
    print(
        "| material | method | θ | η | d0 | L | deviation | limited by | half the step "
        "| half the noise |"
    )
    print("| --- " * 10 + "|")
    with multiprocessing.Pool(arguments.workers) as pool:
        for line in pool.imap(row, cases):
            print(line, flush=True)


if __name__ == "__main__":
    main()
