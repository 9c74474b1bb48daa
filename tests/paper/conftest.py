import pytest

from vibrissa.paper.evidence import gather


@pytest.fixture(scope="session")
def evidence(paper, study_tables):
    """What the paper's statements are judged by."""
    return gather(study_tables, dict(paper.claims))
