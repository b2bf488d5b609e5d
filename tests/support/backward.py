"""Encounters of a swimming sphere with one colloid from the backward Kolmogorov equation, without any path.

In space height h and pitch theta of a swimmer that diffuses are a Markov process by themselves: with R = A + h the
generator is D (d_hh + (2/R) d_h) + (D_r + D/R^2) (d_tt - tan(theta) d_t) + h' d_h + theta' d_t, where h' and theta' are
the rates without noise. The wall at h = 1 reflects, the height 1.5 is where an encounter ends. Central differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

ESCAPE = 1.5  # a


@dataclass(frozen=True)
class OneSphere:
    """A colloid of radius A and swimmers with diffusivities D and D_r = 3 D/4."""

    rates: Callable[[float, float, float, float], tuple[float, float]]  # (pitch, height, A, alpha) -> (h', theta')
    radius: float
    dipole_strength: float
    diffusion: float
    n_heights: int = 100
    n_pitches: int = 300

    @cached_property
    def height(self) -> np.ndarray:
        """(n_heights,) from the wall on; the end of encounters is the next one."""
        return np.linspace(1.0, ESCAPE, self.n_heights + 1)[:-1]

    @cached_property
    def pitch(self) -> np.ndarray:
        """(n_pitches,) middles of intervals."""
        return (np.arange(self.n_pitches) + 0.5) * pi / self.n_pitches - 0.5 * pi

    def mean_sum(self, of: Callable[[np.ndarray], np.ndarray]) -> float:
        """Mean integral of a function of the height over an encounter that begins in contact with pitch 0."""
        source = np.broadcast_to(of(self.height)[:, None], (self.n_heights, self.n_pitches))
        return self._at_start(self._solved(-source))

    def last_touch(self, of: Callable[[np.ndarray], np.ndarray]) -> float:
        """Mean of a function of the pitch where the wall is last touched.

        The wall is left for good at the rate D dq/dh times the local time there, with q the probability to get away
        before the next touch.
        """
        to_end = np.zeros((self.n_heights, self.n_pitches))
        to_end[-1] = -self._up[-1]
        inner = splu(self._generator[self.n_pitches :, self.n_pitches :].tocsc())
        q = inner.solve(to_end[1:].ravel()).reshape(-1, self.n_pitches)
        # second order on one side; q is 0 on the wall
        step = self.height[1] - self.height[0]
        leaving = self.diffusion * (4.0 * q[0] - q[1]) / (2.0 * step)
        # a flux at the wall is a source 2/step times as strong in the cell of half a step there, less the drift of the
        # mirrored node
        source = np.zeros((self.n_heights, self.n_pitches))
        source[0] = -leaving * of(self.pitch) * 2.0 * step * self._down[0] / self.diffusion
        return self._at_start(self._solved(source))

    @cached_property
    def _coefficients(self) -> tuple[np.ndarray, ...]:
        drift = np.array(
            [[self.rates(t, h, self.radius, self.dipole_strength) for t in self.pitch] for h in self.height]
        )
        R = (self.radius + self.height)[:, None]
        turning = 0.75 * self.diffusion + self.diffusion / R**2
        rise = drift[..., 0] + 2.0 * self.diffusion / R
        return rise, drift[..., 1] - turning * np.tan(self.pitch), np.broadcast_to(turning, rise.shape)

    @property
    def _up(self) -> np.ndarray:
        step = self.height[1] - self.height[0]
        return np.asarray(self.diffusion / step**2 + self._coefficients[0] / (2.0 * step))

    @property
    def _down(self) -> np.ndarray:
        step = self.height[1] - self.height[0]
        return np.asarray(self.diffusion / step**2 - self._coefficients[0] / (2.0 * step))

    @cached_property
    def _generator(self) -> sparse.csc_matrix:
        number = np.arange(self.n_heights * self.n_pitches).reshape(self.n_heights, self.n_pitches)
        _, turn, turning = self._coefficients
        step = self.pitch[1] - self.pitch[0]
        more, less = turning / step**2 + turn / (2.0 * step), turning / step**2 - turn / (2.0 * step)
        parts = [
            (number, number, -(self._up + self._down + more + less)),
            (number[:-1], number[1:], self._up[:-1]),
            (number[1:], number[:-1], self._down[1:]),
            (number[0], number[1], self._down[0]),  # the wall is a mirror
            (number[:, :-1], number[:, 1:], more[:, :-1]),
            (number[:, 1:], number[:, :-1], less[:, 1:]),
            (number[:, -1], number[:, -1], more[:, -1]),  # so are the poles
            (number[:, 0], number[:, 0], less[:, 0]),
        ]
        rows, columns, values = (np.concatenate([part[k].ravel() for part in parts]) for k in range(3))
        return sparse.csc_matrix((values, (rows, columns)), shape=(number.size,) * 2)

    def _solved(self, source: np.ndarray) -> np.ndarray:
        return np.asarray(splu(self._generator).solve(source.ravel())).reshape(source.shape)

    def _at_start(self, values: np.ndarray) -> float:
        return float(np.interp(0.0, self.pitch, values[0]))
