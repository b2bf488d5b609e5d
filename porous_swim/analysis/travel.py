"""How long swimmers take to get a distance away along an axis: first passage, or breakthrough. Times in a/U."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.lifetimes import Lifetimes
from porous_swim.analysis.transport import tracks


def travel_times(trajectory: pa.Table, *, distance: float, direction: tuple[float, float, float]) -> Lifetimes:
    """Time from the start until each swimmer is first `distance` (a) further along `direction` (any length).

    One minus `survival()` is the breakthrough curve; `summary()` has the means. Swimmers that do not get there are
    censored at the end of the run. Between frames the way is taken for straight: an excursion that comes and goes
    within one is missed, so that frames must be close beside the time that the distance takes.

    Raises:
        ValueError: a distance that is not above 0, or a direction of length 0.
    """
    axis = np.asarray(direction, float)
    if not (distance > 0.0 and np.linalg.norm(axis) > 0.0):
        raise ValueError(f"travel_times: found distance {distance:g} along {direction}; both must differ from 0")
    recorded = tracks(trajectory)
    n = len(recorded.swimmer)
    if len(recorded.time) == 0:
        return Lifetimes(np.zeros(0), np.zeros(0, bool), np.zeros(0, bool), np.zeros(0), np.zeros(0, int))
    way = (recorded.position - recorded.position[:1]) @ (axis / np.linalg.norm(axis))  # (n_frames, n_swimmers)
    beyond = way >= distance
    there = beyond.any(axis=0)
    # Never in the first frame, where the way is 0; swimmers that do not get there are read at frame 1 and cut below.
    frame = np.where(there, beyond.argmax(axis=0), min(1, len(recorded.time) - 1))
    number = np.arange(n)
    last, first = way[frame - 1, number], way[frame, number]
    part = np.divide(distance - last, first - last, out=np.zeros(n), where=there)
    passage = recorded.time[frame - 1] + part * (recorded.time[frame] - recorded.time[frame - 1])
    duration = float(recorded.time[-1] - recorded.time[0])
    length = np.where(there, passage - recorded.time[0], duration)
    return Lifetimes(length, there, np.ones(n, bool), np.full(n, duration), recorded.swimmer)
