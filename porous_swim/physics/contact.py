"""Hard contact: how near a swimmer's centre may come to a colloid's surface.

Lengths in half-lengths a. A sphere keeps h >= 1. A rod (aspect ratio gamma < 1) keeps
h >= sqrt(sin^2 theta + gamma^2 cos^2 theta), which is exact for a plane wall and 2 to 3 % high
against a sphere of radius 20 at gamma = 0.25 (more against smaller spheres).
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from typing import Literal

import taichi as ti

from porous_swim.parts import Part


class HardContact(Part):
    """A wall that stops the swimmer without torque or friction."""

    kind: Literal["hard"] = "hard"

    @staticmethod
    @cache
    def make_height(real, sphere: bool):
        """Return `contact_height(s, gamma)`: the least height at sine s of the pitch."""

        @ti.func
        def contact_height(s, gamma):
            h = real(1.0)
            if ti.static(not sphere):
                h = ti.sqrt(s * s + gamma * gamma * (real(1.0) - s * s))
            return h

        return contact_height
