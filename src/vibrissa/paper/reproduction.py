"""Comparison of the paper's figures, as printed and described, with a study that repeats them."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from vibrissa.paper.claims import CLAIMS
from vibrissa.paper.evidence import Evidence
from vibrissa.paper.judging import EXAMPLE
from vibrissa.paper.modeling import EXAMPLE_F, EXAMPLE_FORCE

NOT_PRINTED = "not known: the paper prints no result in numbers"


@dataclass(frozen=True, kw_only=True)
class Reproduced:
    """How a part of the paper, such as a figure, is reproduced, and the statements about it.

    Attributes
    ----------
    outcome : str
        Text that says whether the part is reproduced, and gives the computed result.
    difference : str
        Text about the largest difference from the printed result, if the paper prints one.
    """

    name: str
    outcome: str
    difference: str
    claims: Sequence[str]


def reproduced(evidence: Evidence) -> list[Reproduced]:
    """Compare Figures 3 to 8 of the paper, and the force of its example rod, with the study."""
    first = evidence.scan.query("theta == 2 and mu0 == 0.4 and cycle == 1 and phase == 'stick'")
    tapers, slips = evidence.taper, evidence.slipping()
    force, phi1 = EXAMPLE_F * EXAMPLE.force_unit, evidence.state["phi1"]
    off, sign = force - EXAMPLE_FORCE, "agrees" if phi1 < 0.0 else "differs"
    outcomes = {
        3: f"yes: x0,max = {first['x0'].max():.3f} L",
        4: _cycles(evidence.scan, 0.3),
        5: _cycles(evidence.scan, 0.4),
        6: f"yes, at θ of our choice: {len(tapers)} points at {tapers['mu0'].nunique()} μ0",
        7: f"yes, at μ0 of our choice: {len(slips)} points slip, {len(evidence.locking())} lock",
        8: f"yes: φ1 = {phi1:.3f} rad".replace("-", "−"),
    }
    of_figure_8 = f"the sign of φ1, negative, {sign}; the paper prints no number"
    rows = [
        Reproduced(
            name=f"Figure {number}",
            outcome=outcome,
            difference=of_figure_8 if number == 8 else NOT_PRINTED,
            claims=[claim.name for claim in CLAIMS if number in claim.texts["figures"]],
        )
        for number, outcome in outcomes.items()
    ]
    share = f"{off:.1f} N of {EXAMPLE_FORCE:.0f} N ({100 * off / EXAMPLE_FORCE:.2f} %), by rounding"
    example = Reproduced(
        name="Force on the example rod (Section III)",
        outcome=f"yes: {force:.1f} N",
        difference=share.replace("-", "−"),
        claims=["force unit", "example rod"],
    )
    return [*rows, example]


def _cycles(scan: pd.DataFrame, mu0: float) -> str:
    """Count rods and cycles in the scans with the friction coefficient `mu0`, as a text."""
    rows = scan[scan["mu0"] == mu0]
    return f"yes: {rows['theta'].nunique()} rods, {rows['cycle'].max()} cycles each"
