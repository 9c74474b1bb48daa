"""Proved numbers on the page: which rows have them, and their digits."""

from collections.abc import Mapping, Sequence
from decimal import ROUND_DOWN, Decimal, localcontext
from itertools import takewhile

from vibrissa.tables.proofs import KEYS, Proof, spell_key
from vibrissa.wording import counted

# Further off than `make check` allows of any column of one state: the proof is of something else.
AGREES = Decimal("1e-8")
# Digits of a number that are shown at most.
MOST_DIGITS = 20


class Proved:
    """The proofs of a study, by row.

    Parameters
    ----------
    proofs : sequence of Proof
    """

    def __init__(self, proofs: Sequence[Proof]) -> None:
        self._rows: dict[tuple[str, str], list[Proof]] = {}
        for proof in proofs:
            key = proof.table, spell_key(proof.row.values())
            self._rows.setdefault(key, []).append(proof)

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._rows)

    def of(self, table: str, row: Mapping[str, object]) -> dict[str, Proof]:
        """Return the proofs of a row that its numbers do not contradict, by column.

        A proof without a number, that the tip locks, has the empty name.
        """
        key = table, spell_key(row[name] for name in KEYS[table])
        found = {proof.quantity: proof for proof in self._rows.get(key, ())}
        numbers = [proof for name, proof in found.items() if name in row]
        return found if all(_agrees(proof, row[proof.quantity]) for proof in numbers) else {}

    def summary(self) -> dict[str, str]:
        """Say in a few words what is proved."""
        numbers = sum(bool(proof.quantity) for proofs in self._rows.values() for proof in proofs)
        rows = counted(len(self._rows), "row")
        return {"Proved": f"{counted(numbers, 'number')} in {rows}"} if self else {}


def mark(proofs: Mapping[str, Proof]) -> str:
    """Mark a row with proofs: all of them, or without the one that it is the first on its path."""
    if not any(proof.quantity or proof.on_path for proof in proofs.values()):
        return "–"
    return "✓" if all(proof.on_path for proof in proofs.values()) else "✓ (state)"


def digits(proof: Proof | None) -> str:
    """Spell the digits of a number that are proved, cut off behind the last."""
    if proof is None:
        return "–"
    if not proof.radius:
        return f"{proof.midpoint.normalize():f}".replace("-", "−")
    with localcontext(prec=4 * MOST_DIGITS):
        unit = Decimal(1).scaleb(proof.midpoint.adjusted() - MOST_DIGITS + 1)
        ends = (proof.midpoint - proof.radius, proof.midpoint + proof.radius)
        texts = [f"{end.quantize(unit, ROUND_DOWN):f}" for end in ends]
    same = takewhile(lambda pair: pair[0] == pair[1], zip(*texts, strict=False))
    return f"{''.join(first for first, _ in same)}…".replace("-", "−")


def _agrees(proof: Proof, value: object) -> bool:
    try:
        return abs(Decimal(float(value)) - proof.midpoint) <= AGREES  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
