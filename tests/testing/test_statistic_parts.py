"""Every public statistic that takes tables passes the check of `porous_swim.testing`."""

from __future__ import annotations

import pytest

from porous_swim.testing import check_statistic
from tests.analysis.test_columns import arguments, functions

ORDERED = {  # a row for each swimmer, encounter or hop, in the order of swimmers
    "by_column", "by_radius", "flight_lifetimes", "hop_table", "hops", "moves", "persistence", "residence_lifetimes",
    "returns", "scattering", "straightness", "time_averaged_director_correlation", "time_averaged_msd", "tracks",
    "travel_times",
}  # fmt: skip


@pytest.mark.parametrize("name", functions())
def test_a_statistic_is_one(name: str) -> None:
    function = functions()[name]
    given = arguments(function) | ({"name": "from_colloid"} if name == "by_column" else {})
    check_statistic(function, given, ordered=name in ORDERED)
