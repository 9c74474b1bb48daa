"""Proved numbers: equilibria of the rod, enclosed with every error of rounding and truncation."""

from vibrissa.extras import require

require("proof", "flint")

from vibrissa.proof.digits import decimals, spelled  # noqa: E402
from vibrissa.proof.flow import Effort  # noqa: E402
from vibrissa.proof.period import ProvedLock, ProvedOnset, lock, onset  # noqa: E402

__all__ = ["Effort", "ProvedLock", "ProvedOnset", "decimals", "lock", "onset", "spelled"]
