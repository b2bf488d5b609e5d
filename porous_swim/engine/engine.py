"""The engine: swimmers on the device, advanced launch by launch; the encounter log comes back in between."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from taichi.lang.util import to_numpy_type

from porous_swim.core.errors import DeviceError, RunError
from porous_swim.core.state import Remembers, State, fitting, restore_parts, state_of
from porous_swim.engine.backend import Backend, check_alive, whole_vectors
from porous_swim.engine.dynamics import Dynamics, Tuning
from porous_swim.engine.encounter_log import Records
from porous_swim.engine.kernel.advance import make_advance
from porous_swim.engine.kernel.device_log import N_LOG_INTS, Log, LogLong, log_columns
from porous_swim.engine.kernel.ensemble_sums import EnsembleSums, make_ensemble_sums
from porous_swim.engine.kernel.resolve_contacts import MAX_IMAGE
from porous_swim.engine.kernel.state import Event, Int, Total
from porous_swim.engine.kernel.swimmers import Rules, Swimmers
from porous_swim.engine.limits import LONGEST_LAUNCH
from porous_swim.engine.medium import load_medium, on_device
from porous_swim.engine.parameters import Parameters
from porous_swim.engine.probe import height_at_sine
from porous_swim.engine.recent_events import EventsDesk, RecentEvents
from porous_swim.engine.snapshot import HostState, Snapshot
from porous_swim.engine.transfer import on_host, to_device
from porous_swim.obstacles.cells import build_cells
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.located import tableau

LANES = {"f32": 32, "f64": 16}  # on a CPU: two of its widest vectors; a thread of a GPU is one lane
SHARE = 16  # times its lanes: swimmers that a block takes one after the other; fewer where there are few blocks
BLOCKS = 8  # at least, to a thread
CHUNK = 6  # steps between looks at events
LOG_ROWS = 1 << 15  # at least: the host takes them when half of them are used
SWIMMERS_TO_A_ROW = 16
TASK = 512  # Taichi gives a CPU thread at least so many iterations of the outer loop
# Threads of a group on a GPU; the last group is filled with lanes that idle. In a group filled in part llvmpipe
# (Mesa 22.3) stops every thread behind its first loop that holds an atomic operation.
GROUP = 128
PATIENCE = 8  # launches without any progress, which a device that keeps its word never needs
WORD = 0xFFFFFFFF
NOT_FINITE = "its position or director is not a finite number: the time step is too long for the flow there"
OUTSIDE = "it has left the range of periodic images that can be counted"


def check_flights(backend: Backend, ticks: int) -> None:
    """Raise a DeviceError where flights of so many steps are longer than a launch may be."""
    longest = LONGEST_LAUNCH[backend.device]
    if ticks > longest:
        raise DeviceError(
            f"run.flight_step: on {backend.device} a flight has at most {longest:,} steps, found {ticks:,}"
        )


class Engine:
    """Advances swimmers through a field; the state lives on the device, steps are counted here."""

    def __init__(
        self, backend: Backend, field: ObstacleField, position: np.ndarray, director: np.ndarray, *,
        dynamics: Dynamics, tuning: Tuning = Tuning(), news: bool = False, log_path: Path | None = None,  # noqa: B008
    ) -> None:  # fmt: skip
        """Place swimmers at `position` (n, 3), a, with unit `director` (n, 3).

        `news` keeps what `news()` tells; many encounters wait in the file `log_path`, without one in memory.
        """
        self.n_swimmers, self.step = len(position), 0
        numbers, integrator, parameters = dynamics.numbers, dynamics.integrator, dynamics.parameters
        self._field, self._numbers, self._chunk = field, numbers, tuning.chunk or CHUNK
        self._real, self._integrator = dynamics.real, integrator
        self._device, self._longest_launch = backend.device, LONGEST_LAUNCH[backend.device]
        lanes = 1 if integrator == "located" else tuning.lanes  # its steps are as long as each swimmer needs
        self.lanes = lanes or (LANES[dynamics.precision] if backend.is_cpu else 1)
        group = 1 if backend.is_cpu else GROUP
        n_threads = backend.threads or 1
        most = -(-self.n_swimmers // (self.lanes * BLOCKS * n_threads))
        self._share = self.lanes * max(1, min(SHARE, most)) if backend.is_cpu else 1
        self._n_blocks = -(-self.n_swimmers // (self._share * group)) * group
        self._stride = TASK // max(1, min(4, self._n_blocks // (4 * BLOCKS * n_threads))) if backend.is_cpu else 1
        check_flights(backend, numbers.flight_ticks)
        self._model = dynamics.model(field, self.lanes)
        self._advance = make_advance(self._model)
        table = tableau() if integrator == "located" else np.zeros((1, 1))
        self._tableau = on_device(table.astype(self._real))
        cells = build_cells(field, reach=numbers.escape_height, threads=backend.threads)
        rounding = float(np.finfo(self._real).eps)
        self.tolerance = max(1e-6, 2.0 * rounding * (float(cells.radius.max()) + 1.0))
        self._margin = 4.0 * rounding * cells.longest
        self._medium = load_medium(cells, self._real)
        set_of = np.zeros(self.n_swimmers, np.int32) if dynamics.set_of is None else dynamics.set_of
        self._load(position, director, parameters, set_of)
        columns = log_columns(field.dimensions)
        shapes = ((columns.n_real, self._real), (N_LOG_INTS, np.int32), (len(LogLong), np.int64))
        self._log_rows = tuning.log_rows or max(LOG_ROWS, self.n_swimmers // SWIMMERS_TO_A_ROW)
        self._log = Log(*(on_device(np.zeros((self._log_rows, n), t)) for n, t in shapes))
        self._aspect_ratio = parameters["gamma"], set_of
        in_contact = None if integrator == "located" else self._in_contact  # which integrates
        self._records = Records(field, numbers.time_step, self.n_swimmers, log_path, in_contact=in_contact)
        self._desk = EventsDesk(field.dimensions, numbers.time_step, self.n_swimmers) if news else None
        self._launch(0)  # finds every swimmer's colloid and opens the encounters of those released in contact

    def advance(self, n_steps: int) -> None:
        """Move all swimmers by `n_steps`; how the steps are cut into launches does not change a bit.

        With flights it is a whole number of these.

        Raises:
            RunError: a swimmer cannot go on; the message says which, where and why.
        """
        unit = self._numbers.flight_ticks
        if n_steps % unit:
            raise ValueError(f"n_steps: expected a multiple of the {unit} steps of a flight, found {n_steps}")
        while n_steps > 0:
            now = min(n_steps, max(1, self._longest_launch // unit) * unit)
            self._launch(now)
            self.step += now
            n_steps -= now

    @property
    def bytes_per_swimmer(self) -> int:
        """Memory of a swimmer on the device: its state, without colloids and log."""
        return sum(array.shape[0] * to_numpy_type(array.dtype)().itemsize for array in self._swimmers[:3])

    def counts(self) -> tuple[int, int, int, int]:
        """Captures, escapes, hops and returns so far, over all swimmers."""
        captures, escapes, hops, returns = self._total[: Total.LOGGED].tolist()
        return captures, escapes, hops, returns

    @property
    def jammed(self) -> int:
        """Steps of swimmers so far, over all of them, at which no place was found that obeys every contact."""
        return int(self._total[Total.JAMMED])

    def snapshot(self, n: int | None = None) -> Snapshot:
        """Where the first `n` swimmers are, by default all."""
        return self._host(n).snapshot()

    def news(self) -> tuple[RecentEvents, np.ndarray]:
        """What happened since this was last asked for; and how long, in steps, the encounters under way have lasted."""
        assert self._desk is not None
        self._drain()
        who, host, start = self._host().under_way()
        return self._desk.take(who, host, start), self.step - start

    def survey(self, *, n_levels: int) -> EnsembleSums:
        """What is summed over all swimmers, with the present for its origin: see `survey`."""
        kernel = make_ensemble_sums(self._model.at_rest)
        band = max(self._numbers.contact_band, self.tolerance)
        return EnsembleSums(
            self._swimmers, self._medium, kernel, dimensions=self._field.dimensions, real=self._real, band=band,
            n_levels=n_levels,
        )  # fmt: skip

    def encounter_parts(self) -> Iterator[dict[str, np.ndarray]]:
        """Columns of the encounter table up to now, in parts of whole swimmers: see `Records.parts`.

        Encounters under way are included as censored.
        """
        self._drain()
        yield from self._records.parts(*self._host().open_rows(self.step))

    def encounters(self) -> dict[str, np.ndarray]:
        """The same as one."""
        parts = list(self.encounter_parts())
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def state(self) -> dict[str, np.ndarray]:
        """All swimmers and what is kept of their encounters, between two launches."""
        self._drain()
        arrays = {name: on_host(getattr(self._swimmers, name)) for name in ("real", "int", "long")}
        return {"step": np.array(self.step), "total": self._total.copy(), **arrays, **state_of(self._remembers)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another engine of the same swimmers in the same field.

        Raises:
            RunError: the state is of another run, or rows of encounters are missing on disk.
        """
        for name in ("real", "int", "long"):
            table = getattr(self._swimmers, name)
            to_device(fitting(state, name, on_host(table)), table)
        self._total = fitting(state, "total", np.zeros(len(Total), np.int64)).copy()
        to_device(self._total, self._swimmers.total)
        restore_parts(self._remembers, state)
        self.step = int(state["step"])

    def close(self) -> None:
        """Forget what lies on disk."""
        self._records.close()

    @property
    def _remembers(self) -> dict[str, Remembers]:
        return {"encounters": self._records} | ({} if self._desk is None else {"desk": self._desk})

    def _in_contact(self, swimmer: np.ndarray, height: np.ndarray, sine: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Which swimmers, (m,) bool, are in the contact band at heights above colloids, sines of the pitch, radii."""
        ratios, set_of = self._aspect_ratio
        of_each, least = ratios[set_of[swimmer]], np.ones(len(swimmer))
        for ratio in np.unique(of_each):
            rows = of_each == ratio
            least[rows] = height_at_sine(sine[rows], radius[rows], aspect_ratio=float(ratio))
        return height <= least + max(self._numbers.contact_band, self.tolerance)

    def _load(self, position: np.ndarray, director: np.ndarray, parameters: Parameters, set_of: np.ndarray) -> None:
        state = HostState.placed(
            self._field, self._integrator, position, director, set_of, self._real,
            n_sets=len(parameters), partners=self._model.partners,
        )  # fmt: skip
        table = parameters.table.astype(self._real)
        arrays = (state.real, state.int, state.long, table, np.zeros(len(Total), np.int64))
        self._swimmers = Swimmers(*(on_device(array) for array in arrays))

    def _launch(self, n_steps: int) -> None:
        """Run the kernel until every swimmer has made its steps, draining the log whenever it is full."""
        check_alive()
        seed, first, numbers = self._numbers.seed, self.step, self._numbers
        rules = Rules(
            numbers.time_step, numbers.escape_height, numbers.contact_band, self.tolerance, self._margin,
            first, first & WORD, first >> 32, seed & WORD, seed >> 32,
            numbers.flight_ticks, numbers.flight_height, self._tableau,
        )  # fmt: skip
        fresh, finished, idle = 1, 0, 0
        while finished < self.n_swimmers:
            before = finished
            with whole_vectors(self.lanes > 1):
                self._advance(
                    *self._swimmers, *self._medium, *self._log, *rules,
                    n_steps, fresh, self._n_blocks, self._share, self._stride, self._chunk,
                )  # fmt: skip
            self._total = total = on_host(self._swimmers.total)
            finished, fresh = int(total[Total.FINISHED]), 0
            if total[Total.HALTED] > 0:
                raise self._complaint()
            full = total[Total.LOGGED] >= self._log_rows // 2
            idle = 0 if full or finished > before else idle + 1
            if idle >= PATIENCE:
                raise DeviceError(
                    f"device: {self._device} makes no progress; its driver may be a software driver: use cpu"
                )
            total[Total.FINISHED] = 0
            to_device(total, self._swimmers.total)
            if full:
                self._drain()

    def _drain(self) -> None:
        """Take the rows of the log to the host."""
        n = min(int(self._total[Total.LOGGED]), self._log_rows)
        if n > 0:
            logged = [on_host(array, np.s_[:n]) for array in self._log]
            self._total[Total.LOGGED] = 0
            to_device(self._total, self._swimmers.total)
            rows = self._records.add(*logged)
            if self._desk is not None:
                self._desk.note(rows)

    def _host(self, n: int | None = None) -> HostState:
        return HostState(self._field, self._integrator, *(on_host(array, np.s_[:, :n]) for array in self._swimmers[:3]))

    def _complaint(self) -> RunError:
        """The sentence about the first swimmer that cannot go on."""
        state = self._host()
        i = int(np.flatnonzero(state.int[Int.EVENT] & int(Event.HALT))[0])
        step = self.step + int(state.int[Int.STEP, i])
        place = ", ".join(f"{x:.6g}" for x in state.snapshot().position[i])
        far = np.abs(state.int[Int.IMAGE : Int.IMAGE + 3, i]).max() > MAX_IMAGE
        when = f"step {step} (time {step * self._numbers.time_step:g})"
        return RunError(f"swimmer {i} stopped at {when} near ({place}): {OUTSIDE if far else NOT_FINITE}")
