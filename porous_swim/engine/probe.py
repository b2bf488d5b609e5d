"""The engine's own functions on arrays: for tests, for placing swimmers, for curious users."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import math
from functools import cache

import numpy as np
import taichi as ti

from porous_swim.core.numbers import Given
from porous_swim.core.registry import parts_of
from porous_swim.engine import backend
from porous_swim.engine.dynamics import REALS
from porous_swim.engine.medium import on_device
from porous_swim.obstacles.wall import wall_axes
from porous_swim.physics.contact import HardContact, shape_of
from porous_swim.physics.drift import make_drift
from porous_swim.physics.hydrodynamics import Flow
from porous_swim.physics.law import make_named
from porous_swim.physics.model import Model, Surface
from porous_swim.physics.motility import Steady, make_swim
from porous_swim.physics.vectors import vec


@cache
def _drift_kernel(model: Model):
    real, drift, swim, named = model.real, make_drift(model), make_swim(model), make_named(model)
    Vectors, Numbers = ti.types.ndarray(real, ndim=2), ti.types.ndarray(real, ndim=1)

    @ti.kernel
    def probe(x: Vectors, e: Vectors, A: Numbers, numbers: Numbers, velocity: Vectors, rate: Vectors):
        for i in range(A.shape[0]):
            r, d = vec(x[i, 0], x[i, 1], x[i, 2]), vec(e[i, 0], e[i, 1], e[i, 2])
            law = named(*[numbers[k] for k in ti.static(range(len(model.numbers)))])
            v = swim(d, law)
            u, w = drift(((r, A[i]),), d, law)
            for k in ti.static(range(3)):
                velocity[i, k], rate[i, k] = v[k] + u[k], w[k]

    return probe


@cache
def _height_kernel(model: Model):
    contact_height = HardContact.make_height(model)
    Numbers = ti.types.ndarray(ti.f64, ndim=1)

    @ti.kernel
    def probe(s: Numbers, A: Numbers, gamma: ti.f64, height: Numbers):
        for i in range(s.shape[0]):
            height[i] = contact_height(s[i], gamma, A[i])

    return probe


def drift_of(offset, director, radius, *, dipole_strength, bretherton, hydrodynamics, precision):
    """Velocity and director rate (n, 3), with the Bretherton constant given; see `drift`."""
    flow = _flow_of(hydrodynamics)
    numbers = flow.numbers(Given(dipole_strength, 1.0, 3, math.nan))
    return _drift(offset, director, radius, flow, numbers | {"bretherton": bretherton}, precision)


def _flow_of(hydrodynamics):
    """The flow that is meant; one given by its kind has the defaults of its keys."""
    if isinstance(hydrodynamics, Flow):
        return hydrodynamics
    flows = parts_of(Flow)
    if hydrodynamics not in flows:
        raise ValueError(f"hydrodynamics: expected one of {', '.join(flows)}, found {hydrodynamics!r}")
    return flows[hydrodynamics](**{Flow.TAG: hydrodynamics})


def _drift(offset, director, radius, flow, numbers, precision):
    """Velocity and director rate (n, 3) of swimmers with these numbers, by name."""
    if precision not in REALS:
        raise ValueError(f"precision: expected f32 or f64, found {precision!r}")
    backend.ensure_any()
    real, dtype = REALS[precision]
    x, e = (np.atleast_2d(np.asarray(a, dtype=np.float64)) for a in (offset, director))
    x, e = np.broadcast_arrays(x, e)
    if x.ndim != 2 or x.shape[1] != 3:
        raise ValueError(
            f"offset and director: expected shape (n, 3), found {np.shape(offset)} and {np.shape(director)}"
        )
    A = np.broadcast_to(np.asarray(radius, dtype=np.float64), (len(x),))
    velocity, rate = np.zeros((2, *x.shape), dtype)
    for rows in _by_surface(A):
        axes = _axes(x[rows], A[rows])
        offset, turned = ((v[rows][:, None] @ axes.mT)[:, 0] for v in (x, e))
        arrays = [on_device(np.array(a, dtype=dtype)) for a in (offset, turned, A[rows])]
        results = [on_device(np.zeros(offset.shape, dtype)) for _ in range(2)]
        surface: Surface = "plane" if A[rows[0]] == np.inf else "sphere"
        model = Model(real, surface=surface, flows=(type(flow),), motility=Steady, numbers=tuple(numbers))
        _drift_kernel(model)(*arrays, on_device(np.array(list(numbers.values()), dtype)), *results)
        velocity[rows], rate[rows] = ((array.to_numpy()[:, None] @ axes)[:, 0] for array in results)
    return velocity, rate


def _by_surface(radius):
    """Indices of the spheres and of the walls, those of the two that occur."""
    return [rows for rows in (np.flatnonzero(radius != np.inf), np.flatnonzero(radius == np.inf)) if len(rows)]


def _axes(offset, radius):
    """Axes (n, 3, 3) in which the device has offsets (n, 3) of swimmers: those of space, or of the wall below each."""
    if radius[0] != np.inf:
        return np.broadcast_to(np.eye(3), (len(offset), 3, 3))
    return np.stack([wall_axes(x / np.linalg.norm(x), 3) for x in offset])


def drift(
    offset, director, *, radius, dipole_strength, aspect_ratio=1.0, hydrodynamics="image_dipole", precision="f64"
):
    """Velocity (e + u) and rate of the director of swimmers near a sphere or a wall, by the engine's own functions.

    Args:
        offset: (n, 3) swimmer centres minus the sphere's centre, a; minus the nearest point of a plane wall.
        director: (n, 3) unit vectors.
        radius: of the sphere, a; a number or (n,); infinite for a plane wall, exactly.
        dipole_strength: alpha.
        aspect_ratio: gamma in (0, 1].
        hydrodynamics: `image_dipole`, `near_wall`, `none`, or the kind of a flow that was registered; or a `Flow`.
        precision: `f64` or `f32`.

    Returns:
        velocity (n, 3) in U and director rate (n, 3) in U/a. Source: Soft Matter 11, 3396 (2015), App. B.
    """
    flow = _flow_of(hydrodynamics)
    numbers = flow.numbers(Given(dipole_strength, aspect_ratio, 3, math.nan))
    return _drift(offset, director, radius, flow, numbers, precision)


def contact_height(pitch, *, radius, aspect_ratio=1.0):
    """Least height of a swimmer's centre above a sphere of `radius`, a (infinite: a plane), at `pitch` (n,) rad.

    For a prolate spheroid with semi-axes 1, gamma and gamma (`aspect_ratio`), exact; 1 for a spherical swimmer.
    """
    return height_at_sine(np.sin(np.asarray(pitch, dtype=np.float64)), np.asarray(radius), aspect_ratio=aspect_ratio)


def height_at_sine(sine, radius, *, aspect_ratio):
    """The same, at sines of the pitch; broadcast with `radius`, above 0."""
    if not 0.0 < aspect_ratio <= 1.0:
        raise ValueError(f"aspect_ratio: expected 0 < gamma <= 1, found {aspect_ratio!r}")
    if aspect_ratio == 1.0:  # at every frame: worth no launch
        return np.ones(np.broadcast_shapes(np.shape(sine), np.shape(radius)))
    backend.ensure_any()
    s, A = np.broadcast_arrays(np.asarray(sine, dtype=np.float64), np.asarray(radius, dtype=np.float64))
    height = np.zeros(s.size)
    for rows in _by_surface(A.ravel()):
        sines, radii = s.ravel()[rows], A.ravel()[rows]
        result = on_device(np.zeros(len(rows)))
        shape = shape_of(aspect_ratio, float(radii.min()))
        _height_kernel(Model(ti.f64, shape=shape))(on_device(sines), on_device(radii), aspect_ratio, result)
        height[rows] = result.to_numpy()
    return height.reshape(s.shape)
