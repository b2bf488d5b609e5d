"""The same source on a Vulkan device, one lane to a thread: the same bits as on the CPU.

Run with `python -m pytest -m vulkan`; Debian's software driver (mesa-vulkan-drivers) will do.
"""

from __future__ import annotations

import numpy as np
import pytest

from porous_swim.engine import backend
from tests.engines import fcc, fingerprint, hexagonal, make_engine, released

pytestmark = pytest.mark.vulkan


@pytest.mark.parametrize("name", ["hexagonal", "fcc"])
def test_swimmers_and_encounters_are_those_of_the_cpu_to_the_bit(name):
    field, law = {
        "hexagonal": (hexagonal(cells=(2, 1)), dict(alpha=4.0, D=0.05)),
        "fcc": (fcc(cells=1), dict(alpha=0.8, D=0.05)),
    }[name]
    position, director = released(field, 48)
    prints, ended = {}, {}
    for device in ("cpu", "vulkan"):
        # long steps, so that encounters begin, end and hop within the few steps that a software driver affords
        engine = make_engine(field, position, director, device=device, time_step=0.04, escape_sine=0.3, **law)
        engine.advance(160)
        prints[device], ended[device] = fingerprint(engine), engine.counts()
    assert prints["vulkan"] == prints["cpu"]
    assert ended["vulkan"] == ended["cpu"]
    assert min(ended["cpu"][:3]) > 0


def test_the_device_that_was_asked_for_is_the_one_that_runs():
    assert backend.ensure("vulkan").device == "vulkan"
    field = hexagonal(cells=(2, 1))
    engine = make_engine(field, *released(field, 8), device="vulkan", alpha=4.0, D=0.006)
    assert engine.lanes == 1
    engine.advance(3)
    assert np.isfinite(engine.snapshot().position).all()
