"""Precision of the proofs in these tests."""

import pytest

from validation.proof.flow import Effort


@pytest.fixture(scope="module", autouse=True)
def _precision():
    with Effort(bits=96, order=24, steps=16).spent():
        yield
