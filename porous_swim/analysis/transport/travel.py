"""How long swimmers take to get a distance away along an axis: first passage, or breakthrough. Times in a/U."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import PLACES, needs
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.transport.transport import tracks


@needs(trajectory=PLACES)
def travel_times(trajectory: pa.Table, *, distance: float, direction: tuple[float, float, float]) -> Lifetimes:
    """Time from the start until each swimmer is first `distance` (a) further along `direction` (any length).

    One minus `survival()` is the breakthrough curve; `summary()` has the means. Swimmers that do not get there are
    censored at the end of the run. Between frames the way is taken for straight: an excursion that comes and goes
    within one is missed, so that frames must be close beside the time that the distance takes. Each swimmer starts
    where it is first seen; where frames are missing the way is straight from the one before to the one after.

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
    seen = ~np.isnan(recorded.position[..., 0])  # (n_frames, n_swimmers)
    first, end = seen.argmax(axis=0), len(seen) - 1 - seen[::-1].argmax(axis=0)
    number = np.arange(n)
    way = (recorded.position - recorded.position[first, number]) @ (axis / np.linalg.norm(axis))
    beyond = way >= distance  # never where a swimmer is missing, nor in its first frame, where the way is 0
    there = beyond.any(axis=0)
    frame = np.where(there, beyond.argmax(axis=0), end)  # swimmers that do not get there are cut below
    before = np.where(seen, np.arange(len(seen))[:, None], 0)
    before = np.maximum.accumulate(before, axis=0)[np.maximum(frame - 1, 0), number]  # the last one seen before it
    last, now = way[before, number], way[frame, number]
    part = np.divide(distance - last, now - last, out=np.zeros(n), where=there)
    passage = recorded.time[before] + part * (recorded.time[frame] - recorded.time[before])
    limit = recorded.time[end] - recorded.time[first]
    length = np.where(there, passage - recorded.time[first], limit)
    return Lifetimes(length, there, np.ones(n, bool), limit, recorded.swimmer)
