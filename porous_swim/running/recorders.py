"""Our own observers of a run: what every run leaves is made of what they saw."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from porous_swim.observers.base import Every
from porous_swim.observers.lags import Lags
from porous_swim.observers.progress import Clock, make_progress
from porous_swim.observers.rerun.about import About
from porous_swim.observers.rerun.recording import Recording
from porous_swim.observers.rerun.recording_size import recording_warning
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.results.manifest import RECORDING
from porous_swim.running.audience import Seat
from porous_swim.running.outputs import TRAJECTORY
from porous_swim.running.provenance import provenance_of
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene


@dataclass(eq=False)
class Recorders:
    """One of each; no recording without a folder."""

    lags: Lags
    series: TimeSeries
    trajectory: Trajectory
    clock: Clock
    recording: Recording | None

    @classmethod
    def of(cls, simulation: Simulation, folder: Path | None, *, progress: bool, recording: bool) -> Recorders:
        """Those of a run that writes into `folder`, if it has one; `progress` and `recording` as in `run`."""
        scene = simulation.scene
        schedule = Every(scene.record_period)
        return cls(
            Lags(simulation.survey.group_sizes, period=scene.record_period, burn_in=scene.burn_in_frames),
            TimeSeries(schedule),
            Trajectory(schedule, swimmers=np.arange(scene.n_recorded), path=folder and folder / TRAJECTORY),
            make_progress(
                schedule, n_steps=scene.n_steps, n_swimmers=scene.swimmers.count, quiet=not progress,
                seconds=None if scene.unit_system is None else scene.unit_system.time,
            ),
            _recording(simulation, folder / RECORDING) if folder is not None and recording else None,
        )  # fmt: skip

    def seats(self) -> list[Seat]:
        """Their places in the audience."""
        seats = [
            Seat(self.lags, "statistics", name="lags"),
            Seat(self.series, "recording", name="timeseries"),
            Seat(self.trajectory, "recording", TRAJECTORY, name="trajectory"),
            Seat(self.clock, "recording", name="progress"),
        ]
        if self.recording is not None:
            seats.append(Seat(self.recording, "recording", RECORDING, name="recording"))
        return seats


def size_warning(scene: Scene) -> str | None:
    """A sentence where the recording of a scene would be large."""
    return recording_warning(
        n_frames=scene.n_steps // scene.record_period + 1, n_swimmers=scene.n_recorded, n_trails=scene.n_trails,
        rods=scene.swimmers.aspect_ratio < 1.0,
    )  # fmt: skip


def _recording(simulation: Simulation, path: Path) -> Recording:
    scene, recorded = simulation.scene, np.arange(simulation.scene.n_recorded)
    units = scene.unit_system
    about = About(
        scene.name, scene.description, f"{scene.scene_id}-{scene.run.seed}", scene.run.time_step, scene.n_steps,
        scene.swimmers.aspect_ratio, provenance_of(simulation), None if units is None else (units.length, units.time),
    )  # fmt: skip
    trails = recorded[: scene.n_trails]
    return Recording(path, Every(scene.record_period), simulation.field, about, swimmers=recorded, trails=trails)
