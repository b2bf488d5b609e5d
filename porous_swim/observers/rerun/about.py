"""What a recording says of its run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class About:
    """What run it is, and what it takes to show it. Lengths in a, times in a/U."""

    name: str
    description: str
    recording_id: str
    time_step: float
    n_steps: int  # that the run is meant to have
    aspect_ratio: float  # of the swimmers
    provenance: Mapping[str, object]
    units: tuple[float, float] | None = None  # the length a in um and the time a/U in s
