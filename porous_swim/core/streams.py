"""The random streams of the host, in one place and by name. Kicks are drawn on the device, not here."""

from __future__ import annotations

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What a stream of random numbers is for. A value is never used again for another purpose."""

    PLACEMENT = 1
    RELEASE = 2


def generator(seed: int, stream: Stream) -> np.random.Generator:
    """Return the generator of one stream; it depends on `seed` and `stream` only."""
    return np.random.default_rng(np.random.SeedSequence([seed, int(stream)]))
