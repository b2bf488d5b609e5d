"""The pitch at which a pusher in contact with a colloid starts to leave it: dh/dt = 0 at the height of contact.

With s the sine of the pitch that reads s + K (3 s^2 - 1) = 0, K = 3 alpha A R/(2 H^2), R = A + h and H = h (2 A + h),
or 3 alpha/(8 h^2) at a plane wall: the image of a force dipole at a no-slip surface (Soft Matter 11, 3396,
Appendix B). Lengths in a.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model

FLAT = 0.5773502691896258  # 1/sqrt(3): at this sine the flow has no part along the normal
N_HALVINGS = {ti.f32: 26, ti.f64: 54}  # of [0, FLAT], to rounding


@cache
def make_lift_off_sine(model: Model):
    """Return `lift_off_sine(A, alpha, gamma)`, for alpha >= 0: the sine of that pitch, from 0 to 1/sqrt(3).

    It is the only root there: the contact height of a rod grows with its pitch, so K falls and dh/dt rises.
    """
    real, contact_height = model.real, HardContact.make_rolled_height(model)

    @ti.func
    def strength(A, alpha, h):
        K = real(0.375) * alpha / (h * h)
        if ti.static(model.surface == "sphere"):
            R, H = A + h, h * (real(2.0) * A + h)
            K = real(1.5) * alpha * A * R / (H * H)
        return K

    @ti.func
    def lift_off_sine(A, alpha, gamma):
        s = real(0.0)
        if ti.static(model.sphere):
            K = strength(A, alpha, real(1.0))
            s = real(2.0) * K / (real(1.0) + ti.sqrt(real(1.0) + real(12.0) * K * K))  # nothing cancels
        else:
            low, high = real(0.0), real(FLAT)
            for _ in range(N_HALVINGS[real]):
                s = real(0.5) * (low + high)
                rise = s + strength(A, alpha, contact_height(s, gamma, A)) * (real(3.0) * s * s - real(1.0))
                low, high = ti.select(rise < real(0.0), s, low), ti.select(rise < real(0.0), high, s)
        return s

    return lift_off_sine
