"""Points that are solved in both kinds of contact, as a table."""

from collections.abc import Mapping
from typing import Any

import pyarrow as pa

from vibrissa.outcomes import Solver
from vibrissa.tables.rows import table_of
from vibrissa.tables.schemas import COMPARISONS


def comparison_table(name: str, compared: Mapping[str, Any], study: str) -> pa.Table:
    """Make the table of the points that `vibrissa.sticking.comparison.compare` returns."""
    same = {"comparison": name, "study": study, "method": Solver.COLLOCATION}
    repeated = {key: [value] * len(compared["theta"]) for key, value in same.items()}
    return table_of(COMPARISONS, {**compared, **repeated})
