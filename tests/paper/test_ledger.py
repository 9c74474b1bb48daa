"""The whole ledger of the paper's study: no verdict, reason or number in it changes unnoticed.

What the claims compute is tested in test_claims.py. Here stands what a reader of claims.md reads.
"""

from pathlib import Path

import pytest
import yaml

from vibrissa.paper.claims import CLAIMS

LEDGER = Path(__file__).with_name("ledger.yaml")
KNOWN = yaml.safe_load(LEDGER.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def now(tmp_path_factory):
    """The answers as they are now, and a file for them."""
    return dict(KNOWN), tmp_path_factory.mktemp("ledger") / LEDGER.name


def answered(claim, evidence):
    finding = claim.judge(evidence)
    return {
        "section": claim.section,
        "statement": claim.statement,
        "computed": claim.computed,
        "verdict": finding.verdict.value,
        "reason": finding.reason,
        "quantities": {
            name: f"{float(value):.6g} {unit}" for name, (value, unit) in finding.quantities.items()
        },
    }


def test_the_ledger_has_the_same_statements():
    assert [claim.name for claim in CLAIMS] == list(KNOWN)


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.name)
def test_a_statement_is_answered_with_the_same_words_and_numbers(claim, evidence, now):
    answers, new = now
    answers[claim.name] = answer = answered(claim, evidence)
    new.write_text(yaml.safe_dump(answers, allow_unicode=True, sort_keys=False, width=100))
    print(f"If the ledger was meant to change: review {new} and copy it over {LEDGER}.")
    known = KNOWN[claim.name]
    quantities, numbers = answer["quantities"], known["quantities"]
    assert answer | {"quantities": {}} == known | {"quantities": {}}
    assert list(quantities) == list(numbers)
    for what, text in quantities.items():
        (value, unit), (number, its) = text.split(" "), numbers[what].split(" ")
        # What is zero but for rounding is another number on another machine.
        assert float(value) == pytest.approx(float(number), rel=2e-5, abs=1e-9), what
        assert unit == its
