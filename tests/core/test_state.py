"""States of several parts, as one."""

from __future__ import annotations

import numpy as np
import pytest

from porous_swim.core.errors import RunError
from porous_swim.core.state import State, fitting, restore_parts, state_of


class Number:
    """Remembers a number."""

    def __init__(self, value: int) -> None:
        self.value = value

    def state(self) -> dict[str, np.ndarray]:
        return {"value": np.array(self.value)}

    def restore(self, state: State) -> None:
        self.value = int(state["value"])


class Pair:
    """Two numbers."""

    def __init__(self, one: int, other: int) -> None:
        self.parts = {"one": Number(one), "other": Number(other)}

    def state(self) -> dict[str, np.ndarray]:
        return state_of(self.parts)

    def restore(self, state: State) -> None:
        restore_parts(self.parts, state)


def test_parts_of_parts_get_their_own_arrays_back():
    state = state_of({"pair": Pair(1, 2), "pairs": Number(3)})
    assert {name: int(array) for name, array in state.items()} == {"pair/one/value": 1, "pair/other/value": 2,
                                                                   "pairs/value": 3}  # fmt: skip
    pair, number = Pair(0, 0), Number(0)
    restore_parts({"pair": pair, "pairs": number}, state)
    assert (pair.parts["one"].value, pair.parts["other"].value, number.value) == (1, 2, 3)


@pytest.mark.parametrize("found", [np.zeros((2, 3)), np.zeros((3, 2), np.float32), None])
def test_an_array_of_another_shape_or_type_is_refused(found):
    like = np.zeros((3, 2))
    state = {} if found is None else {"real": found}
    with pytest.raises(RunError, match=r"this state is of another run: expected real of float64 \(3, 2\), found"):
        fitting(state, "real", like)
    assert fitting({"real": like}, "real", like) is like
