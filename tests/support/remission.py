"""Remission of leukaemia under 6-mercaptopurine, in weeks. Source: Freireich et al., Blood 21, 699 (1963)."""

from __future__ import annotations

import numpy as np

from porous_swim.analysis.lifetimes.lifetimes import Lifetimes

_ENDED = [6, 6, 6, 7, 10, 13, 16, 22, 23]
_CUT_OFF = [6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35]

REMISSION = Lifetimes(
    length=np.array(_ENDED + _CUT_OFF, float), ended=np.arange(21) < 9, start_seen=np.ones(21, bool),
    limit=np.full(21, np.inf), swimmer=np.arange(21),
)  # fmt: skip
