"""What the paper's statements are judged by: its study's tables, as the claims need them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from vibrissa.bending import Bending, measure, solve_and_measure
from vibrissa.status import Status
from vibrissa.tables import Stored, TableError, frame


@dataclass(frozen=True, eq=False)
class Evidence:
    """Tables of the paper's study.

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
        """Values of Figure 6: a row for each θ, a column for each μ0."""
        return self.taper.pivot(index="theta", columns="mu0", values=column)

    def slipping(self) -> pd.DataFrame:
        """Grid points of Figure 7 at which the tip slips."""
        return self.friction[self.friction["status"] == "slip"]

    def scans(self) -> list[tuple[tuple[float, float], pd.DataFrame]]:
        """Return the steps of each scan with its θ and μ0."""
        return [
            ((float(t), float(m)), rows) for (t, m), rows in self.scan.groupby(["theta", "mu0"])
        ]

    def slip_lengths(self) -> pd.DataFrame:
        """Way of the tip in the first slip of each scan (L): a row for each θ, a column for μ0."""
        found = {}
        for key, rows in self.scans():
            slips = (rows["phase"] == "slip").to_numpy()
            found[key] = np.diff(rows["x1"])[slips[1:]][0]
        return pd.Series(found).unstack()

    def at_end(self, column: str) -> pd.DataFrame:
        """Last value of a column in each scan: a row for each θ, a column for each μ0."""
        return pd.Series({key: rows[column].iloc[-1] for key, rows in self.scans()}).unstack()


def gather(
    stiction: pa.Table | Stored,
    scans: pa.Table | Stored,
    states: pa.Table | Stored,
    names: Mapping[str, str],
) -> Evidence:
    """Pick the evidence out of a study's tables.

    Parameters
    ----------
    stiction, scans, states : pyarrow.Table or Stored
    names : mapping
        Which grids, scan and state are Figures 6, 7, 3 to 5, and 8: ``taper``, ``friction``,
        ``scan`` and ``state``.

    Returns
    -------
    Evidence

    Raises
    ------
    TableError
        If something of it failed, or locks where the paper has a period of sticking.
    """

    def grid(name: str) -> pd.DataFrame:
        rows = frame(stiction, stiction.schema.names, {"grid": name})
        return rows.sort_values(["mu0", "theta"], ignore_index=True)

    evidence = Evidence(
        grid(names["taper"]),
        grid(names["friction"]),
        frame(scans, scans.schema.names, {"scan": names["scan"]}),
        frame(states, states.schema.names, {"state": names["state"]}).iloc[0].to_dict(),
    )
    found = {
        f"state {names['state']}": {evidence.state["status"]} - {Status.SOLVED},
        f"grid {names['taper']}": set(evidence.taper["status"]) - {Status.SLIP},
        f"grid {names['friction']}": set(evidence.friction["status"]) - {Status.SLIP, Status.LOCK},
        f"scan {names['scan']}": set(evidence.scan["status"]) - {Status.SLIP},
    }
    for where, others in found.items():
        if others:
            raise TableError(
                f"the paper's statements cannot be judged: {where} has rows with status "
                f"{', '.join(sorted(others))}"
            )
    return evidence


def bending_of_steps(rows: pd.DataFrame) -> Bending:
    """Bending of the shapes of a scan's steps."""
    return measure(
        rows["theta"].to_numpy(),
        rows["f"].to_numpy(),
        rows["alpha"].to_numpy(),
        rows["x1"].to_numpy(),
        rows["eta"].to_numpy(),
        rows["shape_s"].iloc[0],
        np.stack(rows["shape_x"].to_list()),
        np.stack(rows["shape_y"].to_list()),
        rows["phi1"].to_numpy(),
    )


def bending_at_the_last_state(rows: pd.DataFrame) -> Bending:
    """Bending of grid points at their last state of stiction."""
    return solve_and_measure(
        rows["theta"].to_numpy(),
        rows["f_last"].to_numpy(),
        rows["alpha_last"].to_numpy(),
        (rows["x1_init"] - rows["x0_max"]).to_numpy(),
        rows["eta"].to_numpy(),
    )
