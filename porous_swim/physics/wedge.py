"""Contact with two spheres at once: where both contact surfaces meet, and how hard each one pushes.

At a director that is given, the centres from which a swimmer overlaps a sphere fill a convex body (the sphere and the
swimmer added point by point, after Minkowski). In the half-plane that the line of two centres bounds and the swimmer is
in, the surfaces of two such bodies meet once on either side of the line. Newton's method on R/(A + h), which is convex
and 1 on the surface, never comes to lie inside of a body and goes monotonically to the nearer one of these points, when
it begins where both surfaces meet for the largest contact height, 1. Contact pushes along the line of centres and
without torque, so that a swimmer held by both spheres stays in its half-plane.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from types import SimpleNamespace

import taichi as ti

from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model

LONGEST = 1.0  # a, the largest contact height
N_STEPS = 40  # of Newton's method, at most; it halves what is left at worst, and squares it near the end


@cache
def make_aside(model: Model):
    """Return `aside_of(across, axis, e)`, the unit vector of the half-plane that the swimmer is in.

    Where the swimmer is on its edge, its director or any direction says.
    """
    real = model.real

    @ti.func
    def aside_of(across, axis, e):
        w = across.variable()
        if w.dot(w) <= real(1e-30):
            w = e - axis * e.dot(axis)
        if w.dot(w) <= real(1e-12):
            first = ti.select(ti.abs(axis[0]) < real(0.75), real(1.0), real(0.0))
            w = axis * real(0.0)
            w[0], w[1] = first, real(1.0) - first
            w = w - axis * w.dot(axis)
        return w / ti.sqrt(w.dot(w))

    return aside_of


@cache
def make_wedge(model: Model) -> SimpleNamespace:
    """Return a namespace of functions about two spheres, of radii A and A1, the second at d from the first.

    `corner(v, e, d, A, A1, gamma)` is the offset from the first sphere's centre of the point where both contact
    surfaces meet that is nearest to offset v, and whether there is one. `pushes(moved, v, v1)` are the lengths along
    the two normals, at offsets v and v1 from the two centres, that add up to a displacement in their plane.
    """
    real, height_and_slope = model.real, HardContact.make_rolled_height_and_slope(model)
    aside_of, exact = make_aside(model), 4e-16 if real == ti.f64 else 2e-7

    @ti.func
    def wall(a, s, along, aside, A, gamma):
        """Gap above contact with a sphere at offset (a, s) in the half-plane, and the gradient of the gauge."""
        R = ti.sqrt(a * a + s * s)
        na, ns = a / R, s / R
        sine = along * na + aside * ns
        h, slope = height_and_slope(sine, gamma, A)
        bend = slope / (A + h)
        return R - A - h, na - bend * (along - sine * na), ns - bend * (aside - sine * ns)

    @ti.func
    def newton(a, s, rho, along, aside, A, A1, gamma):
        """One step to where both gaps are 0."""
        gap, ga, gs = wall(a, s, along, aside, A, gamma)
        gap1, ga1, gs1 = wall(a - rho, s, along, aside, A1, gamma)
        det = ga * gs1 - gs * ga1
        return (gap1 * gs - gap * gs1) / det, (gap * ga1 - gap1 * ga) / det

    @ti.func
    def meet(a0, s0, rho, along, aside, A, A1, gamma):
        """The corner that Newton's method finds from (a0, s0)."""
        a, s, left = a0, s0, N_STEPS
        while left > 0:
            da, ds = newton(a, s, rho, along, aside, A, A1, gamma)
            a, s = a + da, s + ds
            done = ti.abs(da) + ti.abs(ds) <= real(exact) * (rho + ti.abs(s))
            left = ti.select(done, 0, left - 1)
        return a, s

    @ti.func
    def corner(v, e, d, A, A1, gamma):
        rho = ti.sqrt(d.dot(d))
        axis = d / rho
        w = aside_of(v - axis * v.dot(axis), axis, e)
        far, far1 = A + real(LONGEST), A1 + real(LONGEST)
        a0 = real(0.5) * (rho + (far * far - far1 * far1) / rho)
        square = far * far - a0 * a0
        a, s = a0, real(0.0)
        if square > real(0.0):
            along, aside, here = e.dot(axis), e.dot(w), v.dot(w)
            s0 = ti.sqrt(square)
            for side in range(2):  # one copy of the code for both: copies take long to compile
                # the other side may be nearer: the surfaces overlap off the line of centres
                if (side == 0) | (here < real(0.5) * s):
                    start = ti.select(side == 0, s0, -s0)
                    a1, s1 = meet(a0, start, rho, along, aside, A, A1, gamma)
                    nearer = (side == 0) | (here - s1 < s - here)
                    a, s = ti.select(nearer, a1, a), ti.select(nearer, s1, s)
        return axis * a + w * s, (square > real(0.0)) & (a * a + s * s < real(1e30))  # false for what is no number

    @ti.func
    def pushes(moved, v, v1):
        n, n1 = v / ti.sqrt(v.dot(v)), v1 / ti.sqrt(v1.dot(v1))
        along, along1, c = moved.dot(n), moved.dot(n1), n.dot(n1)
        det = ti.max(real(1.0) - c * c, real(1e-12))
        return (along - c * along1) / det, (along1 - c * along) / det

    return SimpleNamespace(corner=corner, pushes=pushes, newton=newton)
