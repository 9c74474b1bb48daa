"""The paper's example rod against its limits, and the best rod of each material instead.

A Nano17 SI-12-0.12 reads it, the stage moves in steps of 50 µm, and friction is from 0.2 to 0.4.
"""

import argparse
import multiprocessing

from vibrissa.design import MATERIALS, DesignStatus, Requirements, design

STEEL, WIRE = "steel-s235", "music-wire"
TAPERS = (1, 2, 4)


def asked(material, **others):
    """Ask for a rod made of a material."""
    usual = {"transducer": "nano17-si-12-0.12", "step": "50 um", "mu0": "0.2 to 0.4"}
    return Requirements.read(material=material, **usual, **others)


def paper(theta):
    """Row of the paper's rod with one taper."""
    size = {"eta": "0.85", "diameter": "5 mm", "length": "100 mm"}
    rod = design(asked(STEEL, theta=str(theta), **size))
    value = {check.name: check.value for check in rod.checks}
    strain, steel = value["strain"], MATERIALS[STEEL]
    thickest = (rod.diameter * MATERIALS[name].yield_strain / strain for name in (STEEL, WIRE))
    thick = " | ".join(f"{1e3 * d:.2f} mm" for d in thickest)
    return (
        f"| {theta} | {strain:.1%} | {strain / steel.yield_strain:.0f} times "
        f"| {strain * steel.modulus / 1e9:.1f} GPa | {value['force_y']:.0f} N "
        f"| {value['moment_z']:.0f} N·m | {thick} |"
    )


def row(case):
    """Row of the best rod of a material."""
    name, others = case
    best = design(asked(name, **others))
    if best.status is not DesignStatus.FOUND:
        violated = ", ".join(f"{c.name} {c.use:.2f} times" for c in best.checks if c.use > 1.001)
        return f"| {name} | none | | | | | {violated} | |"
    cylinder = [other.uncertainty for other in best.alternatives if other.theta == 1.0]
    more = f"{cylinder[0] / best.largest - 1.0:.0%} more" if cylinder else "none"
    return (
        f"| {name} | {best.theta:g} | {best.eta:.3f} | {1e3 * best.diameter:g} mm "
        f"| {1e3 * best.length:.0f} mm | {best.largest:.1e} "
        f"| {', '.join(best.active_constraints)} | {more} |"
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
    paper_length = {"length": "100 mm"}
    cases = [(name, others) for others in ({}, paper_length) for name in MATERIALS]
    print("| material | θ | η | d0 | L | uncertainty | active constraints | a cylinder |")
    print("| --- " * 8 + "|")
    with multiprocessing.Pool(arguments.workers) as pool:
        for line in pool.imap(row, cases):
            print(line, flush=True)
