"""Every statement of the paper that a computation can decide, in its order."""

from vibrissa import claims_conclusion, claims_model, claims_results
from vibrissa.ledger import Claim

CLAIMS: tuple[Claim, ...] = tuple(
    value
    for section in (claims_model, claims_results, claims_conclusion)
    for value in vars(section).values()
    if isinstance(value, Claim)
)
