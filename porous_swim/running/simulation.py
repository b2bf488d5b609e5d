"""A scene placed on a device, and moved on from step to step."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.core.errors import RunError
from porous_swim.core.state import Remembers, State, restore_parts, state_of
from porous_swim.engine import backend
from porous_swim.engine.backend import Backend
from porous_swim.engine.dynamics import Tuning
from porous_swim.engine.engine import Engine
from porous_swim.engine.kernel.ensemble_sums import Groups
from porous_swim.engine.probe import height_at_sine
from porous_swim.engine.recent_events import RecentEvents
from porous_swim.engine.windows import Windows, n_levels
from porous_swim.observers.base import BOUND, CONTACT, FREE, Counts, Ensemble, Frame
from porous_swim.obstacles.field import ObstacleField
from porous_swim.results.tables import TableInfo
from porous_swim.running.dynamics import dynamics_of
from porous_swim.scene.scene import Scene
from porous_swim.swimmers.placement import Swimmers


@dataclass(frozen=True, eq=False)
class Start:
    """A device that runs, and what stands at t = 0: all that can fail by the user's hand, and quick to make."""

    backend: Backend
    field: ObstacleField
    swimmers: Swimmers

    @classmethod
    def of(cls, scene: Scene) -> Start:
        """Start the device and place colloids and swimmers. SceneError, DeviceError as the scene deserves."""
        started = backend.ensure(scene.run.device, scene.run.threads)
        field = scene.place_obstacles()
        gamma = scene.swimmers.aspect_ratio
        return cls(started, field, scene.place_swimmers(field, lambda s, A: height_at_sine(s, A, aspect_ratio=gamma)))


class Simulation:
    """A scene placed on a device: advance it step by step with `advance` and look at `frame`."""

    def __init__(
        self, scene: Scene, start: Start | None = None, *, lanes: int | None = None, events: bool = True,
        log_path: Path | None = None,
    ) -> None:  # fmt: skip
        """Compile the kernel for a scene and its start, by default `Start.of(scene)`.

        `lanes` is the number of swimmers to a block; it changes the speed only. `events` keeps what frames tell of the
        encounters since the last. Many encounters wait in the file `log_path`, without one in memory.
        """
        start = Start.of(scene) if start is None else start
        self.scene, self.backend, self.field, self._keeps_events = scene, start.backend, start.field, events
        self.engine = Engine(
            self.backend, self.field, start.swimmers.position, start.swimmers.director, dynamics=dynamics_of([scene]),
            tuning=Tuning(lanes), news=events, log_path=log_path,
        )  # fmt: skip
        frames = {"n_frames": scene.n_frames, "burn_in": scene.burn_in_frames}
        self.survey = self.engine.survey(n_levels=n_levels(**frames))
        self._windows = Windows(self.survey, period=scene.record_period, **frames)

    @property
    def step(self) -> int:
        """Steps made so far."""
        return self.engine.step

    @property
    def time(self) -> float:
        """Time reached, a/U."""
        return self.step * self.scene.run.time_step

    def advance(self, n_steps: int) -> None:
        """Move all swimmers by `n_steps`, whole flights of them. RunError where a swimmer cannot go on."""
        self.engine.advance(n_steps)

    def everyone(self) -> Ensemble:
        """All swimmers together as they are now; at a new frame of the record, windows of its lags end and begin."""
        start, windows = self._windows.look(self.step)
        return _ensemble(start, windows)

    def frame(self, n: int | None = None, *, everyone: Ensemble | None = None, events: bool | None = None) -> Frame:
        """The first `n` swimmers as they are now, by default all, and what is new since the last frame with `events`.

        `everyone` is what `everyone()` says, where that has been asked already; `events` is by default what the
        simulation keeps.
        """
        events = self._keeps_events if events is None else events and self._keeps_events
        everyone = self.everyone() if everyone is None else everyone
        now = self.engine.snapshot(n)
        new, under_way = self.engine.news() if events else (RecentEvents.joined([]), np.zeros(0))
        least = height_at_sine(now.pitch_sine, now.radius, aspect_ratio=self.scene.swimmers.aspect_ratio)
        low = now.height <= least + max(self.scene.encounter.contact_band, self.engine.tolerance)
        state = np.where(now.bound, np.where(low, CONTACT, BOUND), FREE).astype(np.uint8)
        return Frame(
            step=self.step, time=self.time, position=now.position, director=now.director, colloid=now.colloid,
            image=now.image, state=state, ensemble=everyone, has_colloids=len(self.field.radii) > 0,
            counts=Counts(*self.engine.counts()),
            residence=new.residence, winding=new.winding, hop_time=new.hop_time, hops=new.hops,
            under_way=under_way * self.scene.run.time_step, has_events=events,
        )  # fmt: skip

    def state(self) -> dict[str, np.ndarray]:
        """Where the run stands, as arrays: all that `restore` needs to go on from here, to the bit."""
        return {"scene_id": np.array(self.scene.scene_id), **state_of(self._parts)}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another simulation of the same scene; RunError where it is of another one."""
        if str(state.get("scene_id")) != self.scene.scene_id:
            raise RunError(
                f"this state is of another scene: expected that of {self.scene.name} with the scene_id "
                f"{self.scene.scene_id}, found {state.get('scene_id')}"
            )
        restore_parts(self._parts, state)

    @property
    def _parts(self) -> dict[str, Remembers]:
        return {"engine": self.engine, "windows": self._windows}

    def table_info(self, provenance: dict[str, Any]) -> TableInfo:
        """What holds for all tables of this run, as of now."""
        scene, units = self.scene, self.scene.unit_system
        return TableInfo(
            n_swimmers=self.engine.n_swimmers, dimensions=self.field.dimensions, box=tuple(self.field.box.tolist()),
            first_time=0.0, last_time=self.time, time_step=scene.run.time_step, provenance=provenance,
            units=None if units is None else {"length_um": units.length, "time_s": units.time},
            burn_in=scene.record.burn_in, spacing=self.field.spacing,
        )  # fmt: skip


def _ensemble(groups: Groups, windows: Sequence[tuple[int, Groups]]) -> Ensemble:
    """All swimmers together, from sums over groups of them, since the start and over windows."""
    n = int(groups.n.sum())
    msd = float(groups.n @ groups.square) / n
    squares = float(np.sum(groups.spread + groups.n * (groups.square - msd) ** 2))
    error = math.sqrt(squares / ((n - 1) * n)) if n > 1 else math.nan
    return Ensemble(n, float(groups.bound.sum()) / n, float(groups.contact.sum()) / n, msd, error, windows)
