"""The whole ledger of the paper's study: no verdict, reason or number in it changes unnoticed.

What the claims compute is tested in test_claims.py. Here stands what a reader of claims.md reads.
"""

import pytest

from known import Known
from vibrissa.paper.claims import CLAIMS

KNOWN = Known(__file__)


def answered(claim, evidence):
    finding = claim.judge(evidence)
    return {
        "section": claim.section,
        "statement": claim.statement,
        "computed": claim.computed,
        "verdict": finding.verdict.value,
        "reason": finding.reason,
        "quantities": {
            f"{name} [{unit}]": value for name, (value, unit) in finding.quantities.items()
        },
    }


def test_the_ledger_has_the_same_statements():
    assert {claim.name for claim in CLAIMS} == KNOWN.known.keys()


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.name)
def test_a_statement_is_answered_with_the_same_words_and_numbers(claim, evidence):
    KNOWN.check(claim.name, answered(claim, evidence))
