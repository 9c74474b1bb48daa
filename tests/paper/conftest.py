import pytest

from vibrissa.paper.claims import CLAIMS
from vibrissa.paper.evidence import gather
from vibrissa.paper.ledger import claims_table


@pytest.fixture(scope="session")
def evidence(paper, study_tables):
    """What the paper's statements are judged by."""
    return gather(study_tables, dict(paper.claims))


@pytest.fixture(scope="session")
def ledger(evidence, kept):
    """The verdicts on the paper's study."""
    return kept(lambda: claims_table(CLAIMS, evidence, study="paper", method="collocation"))
