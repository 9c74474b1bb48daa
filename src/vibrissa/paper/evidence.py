"""Evidence for the paper's statements, from the tables of a study that repeats the paper."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pandas as pd

from vibrissa.errors import TableError
from vibrissa.mechanics.bending import Bending, measure
from vibrissa.outcomes import Status
from vibrissa.tables import query

# Table and column of each part of the evidence, and the statuses that its rows may have.
SOURCES = {
    "state": ("states", "state", {Status.SOLVED}),
    "taper": ("stiction", "grid", {Status.SLIP}),
    "friction": ("stiction", "grid", {Status.SLIP, Status.LOCK}),
    "scan": ("scans", "scan", {Status.SLIP}),
}
# Least number of points of Figure 7 that slip: fewer have no trend.
FEWEST_SLIPS = 3


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """Parts of the tables of a study that repeats the paper, as the claims need them.

    Attributes
    ----------
    taper : DataFrame
        Grid points of Figure 6, ordered by μ0, then θ.
    friction : DataFrame
        Grid points of Figure 7, ordered by μ0.
    scan : DataFrame
        Steps of the scans of Figures 3 to 5.
    state : mapping
        Equilibrium of Figure 8.
    """

    taper: pd.DataFrame
    friction: pd.DataFrame
    scan: pd.DataFrame
    state: Mapping[str, Any]

    @property
    def eta(self) -> float:
        """Height of the surface in Figures 3 to 7 (L)."""
        return float(self.taper["eta"].iloc[0])

    @property
    def dx0(self) -> float:
        """Step of the clamp in Figures 3 to 7 (L)."""
        return float(self.taper["dx0"].iloc[0])

    def by_theta(self, column: str) -> pd.DataFrame:
        """Arrange a column of Figure 6 with a row for each θ and a column for each μ0."""
        return self.taper.pivot(index="theta", columns="mu0", values=column)

    def slipping(self) -> pd.DataFrame:
        """Grid points of Figure 7 at which the tip slips."""
        return self.friction[self.friction["status"] == "slip"]

    def locking(self) -> pd.DataFrame:
        """Grid points of Figure 7 where the rod buckles laterally and trails until its tip slips.

        The added column ``dragged`` is the distance (L) that the clamp moves in each period of
        sticking after the first one. In these periods the rod trails from the beginning.
        """
        rows = self.friction[self.friction["status"] == "lock"]
        return rows.assign(dragged=rows["x0_trail"] - 2.0 * rows["x0_end"])

    def scans(self) -> list[pd.DataFrame]:
        """Split the steps into one table for each scan, ordered by θ, then μ0."""
        return [rows for _, rows in self.scan.groupby(["theta", "mu0"])]

    def first_periods(self) -> list[pd.DataFrame]:
        """Return the steps of the first period of sticking, in one table for each scan."""
        return [rows[(rows["cycle"] == 1) & (rows["phase"] == "stick")] for rows in self.scans()]

    def of_scans(self, value: Callable[[pd.DataFrame], float]) -> pd.DataFrame:
        """Apply `value` to the steps of each scan: a row for each θ, a column for each μ0."""
        return self.scan.groupby(["theta", "mu0"])[self.scan.columns].apply(value).unstack()

    def bending_of(self, steps: pd.DataFrame) -> Bending:
        """Return the bending of the rod in some of the steps of the scans."""
        return self._bending_of_scan.take(self.scan.index.get_indexer(steps.index))

    @cached_property
    def _bending_of_scan(self) -> Bending:
        """Bending of the rod in all steps, measured once for all statements."""
        rows = self.scan
        return _bending(rows, rows["f"], rows["alpha"], rows["x1"] - rows["footpoint"])

    def scan_lengths(self) -> pd.DataFrame:
        """Distance that the clamp moves in each scan (L)."""
        return self.of_scans(lambda rows: rows["footpoint"].iloc[-1])

    def cycle_counts(self) -> pd.DataFrame:
        """Count the stick-slip cycles of each scan."""
        return self.of_scans(lambda rows: rows["cycle"].iloc[-1])

    def slip_lengths(self) -> pd.DataFrame:
        """Distance that the tip moves in the first slip of each scan (L)."""
        return self.of_scans(lambda rows: rows["x1"].diff()[rows["phase"] == "slip"].iloc[0])


def gather(tables: Mapping[str, query.Readable], names: Mapping[str, str]) -> Evidence:
    """Select the evidence from a study's tables.

    Parameters
    ----------
    tables : mapping
        Tables of the study by name.
    names : mapping
        Names of the grids, the scan and the state, as in `vibrissa.study.claims.Claims`.

    Raises
    ------
    TableError
        If a row has a status that `SOURCES` does not allow; if Figure 7 has fewer than
        `FEWEST_SLIPS` points below μ_lock, or no point above μ_lock; or if the slip of the
        trailing rod is not known at a point above μ_lock.
    """
    found = {}
    for key, (table, column, allowed) in SOURCES.items():
        where = query.one_of(column, [names[key]])
        found[key] = query.frame(tables[table], tables[table].schema.names, where)
        if others := set(found[key]["status"]) - allowed:
            raise TableError(
                f"the paper's statements cannot be judged: rows of the {column} "
                f"{names[key]!r} have the status {', '.join(sorted(others))}"
            )
    friction = found["friction"].sort_values("mu0", ignore_index=True)
    beyond = friction.loc[friction["status"] == Status.LOCK, "x0_trail"]
    few = len(friction) - len(beyond) < FEWEST_SLIPS
    if few or beyond.empty or beyond.isna().any():
        raise TableError(
            f"the paper's statements cannot be judged: the grid {names['friction']!r} needs at "
            f"least {FEWEST_SLIPS} values of μ0 below μ_lock, one above it, and none above 3"
        )
    return Evidence(
        taper=found["taper"].sort_values(["mu0", "theta"], ignore_index=True),
        friction=friction,
        scan=found["scan"],
        state=found["state"].iloc[0].to_dict(),
    )


def bending_at_the_end_of_trailing(rows: pd.DataFrame) -> Bending:
    """Measure the bending of trailing rods in the last state in which their tip sticks.

    It is measured in the mirror image of this state, a state with the clamp pulled back (x0 < 0).
    """
    x0 = 2.0 * rows["x0_end"] - rows["x0_trail"]
    return _bending(rows, rows["f_trail"], -rows["alpha_trail"], rows["x1_init"] - x0)


def bending_at_the_last_state(rows: pd.DataFrame) -> Bending:
    """Measure the bending of the rod at each grid point in its last sticking state."""
    return _bending(rows, rows["f_last"], rows["alpha_last"], rows["x1_init"] - rows["x0_max"])


def _bending(rows: pd.DataFrame, f: pd.Series, alpha: pd.Series, x1: pd.Series) -> Bending:
    """Measure the bending; x1 is the distance of the tip from the clamp along the surface."""
    state = (rows["theta"], f, alpha, x1, rows["eta"])
    return measure(*(values.to_numpy() for values in state))
