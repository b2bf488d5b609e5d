"""Drift of a force-dipole swimmer caused by the nearest colloid, a sphere or a plane wall.

Lengths in half-lengths a, speeds in U. Source: Spagnolie, Moreno-Flores, Bartolo, Lauga, Soft Matter 11,
3396 (2015), Appendix B, in the form without square roots; Gamma enters with the sign of Appendix B.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from typing import Literal

import taichi as ti

from porous_swim.core.registry import add
from porous_swim.physics.flow import Flow as Flow  # with those below
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface


@cache
def make_plane_drift(model: Model):
    """Return `drift(x, e, A, law) -> velocity, director rate` at a plane wall, the exact image of the dipole.

    The limit of large A of that at a sphere, A being of no concern, and the flow of Blake's images:
    k [(3 q - 1) n + 2 s (e - s n)] and -(k/h) [1 + (Gamma/2)(1 + q)] s (n - s e) with k = 3 alpha/(8 h^2), s = e.n,
    q = s^2 and n the normal.
    """
    real, to = model.real, make_surface(model)

    @ti.func
    def drift(x, e, A, law):
        alpha, Gamma = law.alpha, law.bretherton
        h = to.distance(x)
        n, s = to.normal(x, h), to.sine(x, e, h)
        q = s * s
        k = real(0.375) * alpha / (h * h)
        velocity = (n * (real(3.0) * q - real(1.0)) + (e - n * s) * (real(2.0) * s)) * k
        turn = real(-1.0) * k / h * (real(1.0) + real(0.5) * Gamma * (real(1.0) + q)) * s
        return velocity, (n - e * s) * turn

    return drift


class NoHydrodynamics(Flow):
    """A swimmer that feels no flow: it swims, turns by noise, and is stopped by walls."""

    kind: Literal["none"] = "none"

    @staticmethod
    @cache
    def make_drift(model: Model):
        """Return `drift(x, e, A, law) -> velocity, director rate`, both zero here."""
        real = model.real

        @ti.func
        def drift(x, e, A, law):
            return x * real(0.0), e * real(0.0)

        return drift


class ImageDipole(Flow):
    """The flow that the nearest colloid reflects: the exact image of a force dipole at a no-slip sphere."""

    kind: Literal["image_dipole"] = "image_dipole"

    @staticmethod
    @cache
    def make_drift(model: Model):
        """Return `drift(x, e, A, law) -> velocity, director rate` at offset x from a sphere of radius A.

        The swimmer's own speed is not in the velocity. One division, no square root, no branch. At a plane wall it is
        that of `make_plane_drift`.
        """
        if model.surface == "plane":
            return make_plane_drift(model)
        real = model.real

        @ti.func
        def drift(x, e, A, law):
            alpha, Gamma = law.alpha, law.bretherton
            rho = x.dot(x)
            s = x.dot(e)
            H = rho - A * A  # h (2 A + h)
            i = real(1.0) / (rho * H)  # the one division: 1/rho = i H, 1/H = i rho
            i_rho, i_H = i * H, i * rho
            a = A * A * i_rho
            b = a * (real(3.0) - a)
            q = s * s * i_rho
            k = real(1.5) * alpha * A * i_H * i_H
            velocity = (x * (real(3.0) * q - real(1.0) - b * q) + e * (b * s)) * k
            P = ((real(5.0) * a - real(17.0)) * a + real(22.0)) * a - real(6.0)
            P += q * (((real(29.0) - real(9.0) * a) * a - real(34.0)) * a + real(18.0))
            w = k * rho * i_H * (b + real(0.25) * Gamma * P)
            return velocity, (e * q - x * (s * i_rho)) * w

        return drift


class NearWall(Flow):
    """The paper's reduced model: the image flow to leading order in height over radius, as if the wall were plane."""

    kind: Literal["near_wall"] = "near_wall"

    @staticmethod
    @cache
    def make_drift(model: Model):
        """Return `drift(x, e, A, law) -> velocity, director rate` at offset x from a sphere of radius A.

        The velocity is that at a plane wall. The director's rate makes height and pitch obey, with nothing left out,
        dh/dt = s - (3 alpha/(8 h^2)) (1 - 3 s^2) and
        dtheta/dt = cos(theta)/A - (3 alpha/(64 h^3)) [4 + Gamma (3 - cos 2 theta)] sin 2 theta, whose 1/A stands for
        the turn of the wall under a swimmer that moves along it; the sphere's own turn, v/(A + h), is taken off. At a
        plane wall, where 1/A = 0, it is the exact drift of `make_plane_drift`.
        """
        if model.surface == "plane":
            return make_plane_drift(model)
        real = model.real

        @ti.func
        def drift(x, e, A, law):
            alpha, Gamma = law.alpha, law.bretherton
            R = ti.sqrt(x.dot(x))
            n = x / R
            s, h = n.dot(e), R - A
            q = s * s
            k = real(0.375) * alpha / (h * h)
            velocity = (n * (real(3.0) * q - real(1.0)) + (e - n * s) * (real(2.0) * s)) * k
            turn = real(1.0) / A - (real(1.0) + real(2.0) * k * s) / R
            # not `-=`: Taichi cannot take a wide value from another in place, and LLVM then ends the process
            turn = turn - k / h * (real(1.0) + real(0.5) * Gamma * (real(1.0) + q)) * s
            return velocity, (n - e * s) * turn

        return drift


add(NoHydrodynamics, ImageDipole, NearWall)
