"""The state of all swimmers on the host: how it is first made, and what it says of the swimmers."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from porous_swim.engine.kernel.device_log import CLOCKS, N_LOG_INTS, LogLong, kept, log_columns
from porous_swim.engine.kernel.state import PHASE_BIT, Event, Int, Long, Phase, clock_of_events, n_ints, real_rows
from porous_swim.obstacles.field import ObstacleField

_HAPPENED = {name: Long[step.name] for name, step in CLOCKS.items()}  # the same steps, as the state numbers them


@dataclass(frozen=True, eq=False)
class Snapshot:
    """All swimmers at one step."""

    position: np.ndarray  # (n, 3) float64, a, unwrapped
    director: np.ndarray  # (n, 3) float64, unit
    colloid: np.ndarray  # (n,) int32, the nearest; -1 in an empty field
    image: np.ndarray  # (n, 3) int32, periodic image of that colloid
    bound: np.ndarray  # (n,) bool, in an encounter
    host: np.ndarray  # (n, 4) int32, colloid and image of the present or latest encounter
    start: np.ndarray  # (n,) float64, steps, when that began
    height: np.ndarray  # (n,) float64, a, above the colloid of the encounter, else above the nearest
    pitch_sine: np.ndarray  # (n,) float64, of the pitch there; 0 in an empty field
    radius: np.ndarray  # (n,) float64, a, of that colloid; infinite where it is flat and in an empty field


@dataclass(frozen=True, eq=False)
class HostState:
    """Copies of the arrays of `swimmers.Swimmers`, and the field they live in."""

    field: ObstacleField
    integrator: str
    real: np.ndarray  # (n_memory, n) rows of `real_rows`
    int: np.ndarray  # (n_ints, n) int32
    long: np.ndarray  # (len(Long), n) int64

    @classmethod
    def placed(
        cls, field: ObstacleField, integrator: str, position: np.ndarray, director: np.ndarray, set_of: np.ndarray,
        real: np.dtype, *, n_sets: int, partners: bool,
    ) -> HostState:  # fmt: skip
        """Swimmers at absolute `position` (n, 3) with unit `director` (n, 3), free, and waiting to be located."""
        located = integrator == "located"
        rows, d, n = real_rows(field.dimensions, located=located), field.dimensions, len(position)
        state = cls(
            field,
            integrator,
            np.zeros((rows.n_memory, n), real),
            np.zeros((n_ints(located=located, partners=partners, n_sets=n_sets), n), np.int32),
            np.full((len(Long), n), -1, np.int64),
        )
        colloid, image, _ = field.nearest(position)
        state.int[Int.COLLOID], state.int[Int.IMAGE : Int.IMAGE + 3] = np.maximum(colloid, 0), image.T
        state.int[Int.BOUND], state.int[Int.TOUCHED], state.int[Int.EVENT] = -1, -1, int(Event.LOCATE)
        if n_sets > 1:
            state.int[Int.SET] = set_of
        if located or partners:
            state.int[Int.PARTNER] = -1
        seen_from = state.int[Int.COLLOID]
        offset = field.to_device(position - state._center(Int.COLLOID, Int.IMAGE), seen_from)
        director = field.to_device(director, seen_from)
        state.real[rows.x : rows.x + d] = offset.T[:d]
        state.real[rows.rest : rows.rest + d] = offset.T[:d] - state.real[rows.x : rows.x + d].astype(np.float64)
        state.real[rows.e : rows.e + d] = director.T[:d]
        return state

    def snapshot(self) -> Snapshot:
        """Where all swimmers are, in absolute terms."""
        rows, d = self._rows, self.field.dimensions
        offset, director = np.zeros((2, self.int.shape[1], 3))
        offset[:, :d] = self.real[rows.x : rows.x + d].T.astype(np.float64) + self.real[rows.rest : rows.rest + d].T
        director[:, :d] = self.real[rows.e : rows.e + d].T
        seen_from = self.int[Int.COLLOID]
        position = self._center(Int.COLLOID, Int.IMAGE) + self.field.from_device(offset, seen_from)
        director = self.field.from_device(director, seen_from)
        bound = self.bound
        r = position - np.where(
            bound[:, None], self._center(Int.BOUND, Int.BOUND_IMAGE), self._center(Int.COLLOID, Int.IMAGE)
        )
        empty = len(self.field.radii) == 0
        colloid = np.full_like(self.int[Int.COLLOID], -1) if empty else self.int[Int.COLLOID]
        host = np.where(bound, self.int[Int.BOUND], colloid)
        radius = height = np.full(len(r), np.inf)
        sine = np.zeros(len(r))
        if not empty:
            radius = self.field.radii[host]
            height, sine = self.field.stance(r, director, host)
        return Snapshot(
            position, director, colloid.copy(), self.int[Int.IMAGE : Int.IMAGE + 3].T.copy(), bound,
            self.int[Int.BOUND : Int.BOUND + 4].T.copy(),
            self.long[Long.START] + self._clock("start_clock"), height, sine, radius,
        )  # fmt: skip

    def open_rows(self, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows of the log (reals, integers, steps) for the encounters under way at `step`."""
        rows, columns, d = self._rows, log_columns(self.field.dimensions), self.field.dimensions
        who = np.flatnonzero(self.bound)
        real, names, steps = (np.zeros((len(who), n), t) for n, t in
                              ((columns.n_real, float), (N_LOG_INTS, np.int32), (len(LogLong), np.int64)))  # fmt: skip
        shift = self._center(Int.COLLOID, Int.IMAGE) - self._center(Int.BOUND, Int.BOUND_IMAGE)
        real[:, columns.exit_x : columns.exit_x + d] = self.real[rows.x : rows.x + d, who].T + shift[who, :d]
        for column, row in ((columns.entry_x, rows.entry_x), (columns.entry_e, rows.entry_e), (columns.exit_e, rows.e)):
            real[:, column : column + d] = self.real[row : row + d, who].T
        for name in kept(d, located=self.integrator == "located"):
            real[:, getattr(columns, name)] = self.real[getattr(rows, name), who]
        for name in CLOCKS:
            real[:, getattr(columns, name)] = self._clock(name)[who]
        names[:, 0], names[:, 1:] = who, self.int[Int.BOUND : Int.BOUND + 4, who].T
        for column, row in ((LogLong.START, Long.START), (LogLong.RELEASE, Long.RELEASE),
                            (LogLong.PITCH, Long.PITCH), (LogLong.N_CONTACT, Long.N_CONTACT)):  # fmt: skip
            steps[:, column] = self.long[row, who]
        steps[:, LogLong.END] = step
        return real, names, steps

    def under_way(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of the encounters under way: swimmer (m,), colloid and image (m, 4), start (m,) in steps."""
        who = np.flatnonzero(self.bound)
        start = self.long[Long.START, who] + self._clock("start_clock")[who]
        return who, self.int[Int.BOUND : Int.BOUND + 4, who].T, start

    @property
    def bound(self) -> np.ndarray:
        """Which swimmers, (n,), are in an encounter."""
        return np.asarray(self.int[Int.EVENT] >> PHASE_BIT == int(Phase.BOUND))

    @property
    def _rows(self) -> SimpleNamespace:
        return real_rows(self.field.dimensions, located=self.integrator == "located")

    def _clock(self, name: str) -> np.ndarray:
        """What the whole steps of an event lack, (n,)."""
        middle = clock_of_events(self.integrator)
        if middle is None:
            return np.asarray(self.real[getattr(self._rows, name)].astype(np.float64))
        return np.where(self.long[_HAPPENED[name]] > 0, middle, 0.0)

    def _center(self, colloid: Int, image: Int) -> np.ndarray:
        """(n, 3) centres, in absolute terms, of the colloids that two sets of rows name."""
        centers = self.field.centers if len(self.field.radii) else np.zeros((1, 3))
        return np.asarray(centers[self.int[colloid]] + self.int[image : image + 3].T * self.field.box)
