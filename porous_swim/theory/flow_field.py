"""The flow around a swimmer near a sphere or a wall: the free dipole and its exact image, at any point outside.

With y the swimmer seen from the sphere's centre, e its director, k = A/|y|, y* = A^2 y/|y|^2, d = x - y* and
D = |x||d| + x.d the image is (Soft Matter 11, 3396, Appendix A, in a form without its spurious singularity)

    u = alpha [-(x - y) q - (|x|^2 - A^2) V],   q = (k/|d|)'',   V = F1'' + F2'
    F1 = -((1/k - k)/2) d/|d|^3 - ((3 k - 1/k)/2) (x/|x| + d/|d|)/D
    F2 = -k [(e - d (e.d)/|d|^2)/(|d| D) - |x| w (e.w)/D^2],   w = x/|x| + d/|d|

where ' is the derivative to t along y(t) = y + t e: here by second-order Taylor series. At a plane wall it is the first
such derivative of the image of a point force e (J. R. Blake, Math. Proc. Camb. Phil. Soc. 70, 303, 1971).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True, eq=False)
class Jet:
    """A Taylor series to second order in t, of numbers (n, 1) or vectors (n, 3)."""

    c0: Any
    c1: Any = 0.0
    c2: Any = 0.0

    def __add__(self, other: Jet) -> Jet:
        return Jet(self.c0 + other.c0, self.c1 + other.c1, self.c2 + other.c2)

    def __sub__(self, other: Jet) -> Jet:
        return Jet(self.c0 - other.c0, self.c1 - other.c1, self.c2 - other.c2)

    def __mul__(self, other: Jet) -> Jet:
        return Jet(
            self.c0 * other.c0,
            self.c0 * other.c1 + self.c1 * other.c0,
            self.c0 * other.c2 + self.c1 * other.c1 + self.c2 * other.c0,
        )

    def scaled(self, factor: Any) -> Jet:
        """The series times a number that does not depend on t."""
        return Jet(factor * self.c0, factor * self.c1, factor * self.c2)

    def dot(self, other: Jet) -> Jet:
        """The scalar product of two vectors, (n, 1)."""
        product = self * other
        return Jet(*(np.sum(c + np.zeros(3), axis=-1, keepdims=True) for c in (product.c0, product.c1, product.c2)))

    def power(self, exponent: float) -> Jet:
        """A number above zero to a power."""
        first, second = self.c1 / self.c0, self.c2 / self.c0
        square = 0.5 * exponent * (exponent - 1.0) * first**2
        return Jet(1.0, exponent * first, exponent * second + square).scaled(self.c0**exponent)


def flow_field(points: Any, position: Any, director: Any, *, radius: float, dipole_strength: float) -> np.ndarray:
    """Velocity (n, 3) of the fluid, in U, at `points` (n, 3) around a force-dipole swimmer near a no-slip sphere.

    Args:
        points: (n, 3) seen from the sphere's centre, a, outside of the sphere and not at the swimmer; at a wall seen
            from its point nearest to the swimmer.
        position: (3,) of the swimmer seen from the same, a, outside of the sphere; at a wall it is along the normal.
        director: (3,) unit vector.
        radius: of the sphere, a; infinite for a plane wall, exactly.
        dipole_strength: alpha.

    Raises:
        ValueError: a shape that does not fit, or a point or the swimmer inside the sphere or behind the wall.

    On the surface the flow vanishes to rounding. Behind it there is none.
    """
    x = np.atleast_2d(np.asarray(points, dtype=float))
    y, e = (np.asarray(v, dtype=float) for v in (position, director))
    if x.ndim != 2 or x.shape[1] != 3 or y.shape != (3,) or e.shape != (3,):
        raise ValueError(
            f"points, position, director: expected (n, 3), (3,), (3,), found {x.shape}, {y.shape}, {e.shape}"
        )
    if radius == np.inf:
        return dipole_strength * (_free(x - y, e) + _wall_image(_in_front(x, y), y, e))
    if np.linalg.norm(y) <= radius:
        raise ValueError(
            f"position: at {np.linalg.norm(y):g} from the centre it is inside the sphere of radius {radius:g}"
        )
    # a point put on the surface by its user is there but for rounding
    if np.any(np.linalg.norm(x, axis=1) < radius * (1.0 - 1e-12)):
        raise ValueError(f"points: some are inside the sphere of radius {radius:g}")
    return dipole_strength * (_free(x - y, e) + _image(x, y, e, radius))


def _free(r: np.ndarray, e: np.ndarray) -> np.ndarray:
    """S_D = r/|r|^3 (3 (e.r)^2/|r|^2 - 1)."""
    distance = np.linalg.norm(r, axis=1, keepdims=True)
    along = (r @ e)[:, None] / distance
    return np.asarray(r / distance**3 * (3.0 * along**2 - 1.0))


def _image(x: np.ndarray, y0: np.ndarray, e: np.ndarray, A: float) -> np.ndarray:
    y, point, director = Jet(y0[None, :], e[None, :]), Jet(x), Jet(e[None, :])
    rho = y.dot(y)
    k = rho.power(-0.5).scaled(A)
    inverse_k = rho.power(0.5).scaled(1.0 / A)
    d = point - (y * rho.power(-1.0)).scaled(A * A)
    d_size, x_size = d.dot(d).power(0.5), np.linalg.norm(x, axis=1, keepdims=True)
    d_unit, x_unit = d * d_size.power(-1.0), Jet(x / x_size)
    D = d_size.scaled(x_size) + d.dot(point)
    w = x_unit + d_unit
    F1 = (inverse_k - k).scaled(-0.5) * d * d_size.power(-3.0)
    F1 = F1 - (k.scaled(3.0) - inverse_k).scaled(0.5) * w * D.power(-1.0)
    across = (director - d_unit * director.dot(d_unit)) * (d_size * D).power(-1.0)
    F2 = k.scaled(-1.0) * (across - (w * director.dot(w) * D.power(-2.0)).scaled(x_size))
    q = (k * d_size.power(-1.0)).c2 * 2.0
    V = F1.c2 * 2.0 + F2.c1
    return np.asarray(-(x - y0) * q - (x_size**2 - A * A) * V)


def _in_front(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The points, where swimmer and points are before the wall."""
    h = np.linalg.norm(y)
    if h == 0.0:
        raise ValueError("position: it is on the wall, from which it is seen")
    # a point put on the wall by its user is there but for rounding
    if np.any(x @ y < -1e-12 * h * (h + np.linalg.norm(x, axis=1))):
        raise ValueError("points: some are behind the wall")
    return x


def _wall_image(x: np.ndarray, y0: np.ndarray, e: np.ndarray) -> np.ndarray:
    """The derivative of the image of a point force e at y0 + t e, with the wall at the origin and normal to y0."""
    height = float(np.linalg.norm(y0))
    n = y0 / height
    across = Jet(np.array([[e @ n]]))
    normal, director = Jet(n[None, :]), Jet(e[None, :])
    mirrored = Jet((e - 2.0 * (e @ n) * n)[None, :])  # the director in the mirror, along which the image moves
    h = Jet(np.array([[height]]), np.array([[e @ n]]))
    d = Jet(x + y0, -mirrored.c0)
    Z = d.dot(normal)
    size = d.dot(d).power(0.5)
    near, cube = size.power(-1.0), size.power(-3.0)
    forward = d.dot(mirrored)
    u = (director * near + d * d.dot(director) * cube).scaled(-1.0)
    slope = (mirrored * cube - (d * forward * size.power(-5.0)).scaled(3.0)) * (h - Z)
    slope = slope + (normal * forward + d * across) * cube
    return np.asarray((u + (h * slope).scaled(2.0)).c1)
