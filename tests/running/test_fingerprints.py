"""Results do not change by accident, whatever is moved about in the code."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support import fingerprints


@pytest.mark.parametrize("name", fingerprints.RUNS)
def test_a_run_leaves_what_it_left_before(name):
    found, kept = fingerprints.RUNS[name](), fingerprints.stored()[name]
    assert fingerprints.differences(found, kept) == []


def test_one_bit_of_one_number_changes_an_exact_fingerprint_and_no_rounded_one():
    column = np.linspace(0.0, 1.0, 7)
    other = column.copy()
    other[3] = np.nextafter(other[3], 1.0)
    assert fingerprints.exact(column) != fingerprints.exact(other)
    assert fingerprints.rounded(column) == fingerprints.rounded(other)
    other[3] += 1e-7
    assert fingerprints.rounded(column) != fingerprints.rounded(other)
