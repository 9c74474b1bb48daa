"""Every statement of the paper that a computation can decide, in the paper's order."""

from vibrissa.paper import conclusion, modeling, results
from vibrissa.paper.ledger import Claim

CLAIMS: tuple[Claim, ...] = tuple(
    value
    for section in (modeling, results, conclusion)
    for value in vars(section).values()
    if isinstance(value, Claim)
)
