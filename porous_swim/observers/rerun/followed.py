"""The swimmer that a recording follows: its height above the nearest colloid and its pitch there, over time."""

from __future__ import annotations

import numpy as np
import rerun as rr

from porous_swim.core.scales import Scales, shown_in
from porous_swim.core.state import State
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.colloids import log_translucent
from porous_swim.observers.rerun.palette import HEIGHT_COLOR, PITCH_COLOR
from porous_swim.observers.rerun.stream import BATCH_ROWS, Moments, RecordingFile
from porous_swim.observers.rerun.trails import wrapped
from porous_swim.observers.rerun.view import Scenery
from porous_swim.obstacles.field import ObstacleField

_MARGIN = 2.0  # a, around the path beside the colloid there


class FollowedTrack:
    """Height of the centre above the surface, a or um, and pitch, rad, of one `swimmer`; as the trajectory has them."""

    def __init__(self, file: RecordingFile, field: ObstacleField, swimmer: int, scales: Scales | None) -> None:
        self._file, self._field, self._swimmer = file, field, swimmer
        self._length, _ = shown_in("a", scales)
        self._moments = Moments()
        self._rows: dict[str, list[np.ndarray]] = {}
        self._visited: set[int] = set()
        self._corners = np.zeros((0, 3))  # of a box around where it was, and the colloids there
        for name, color in (("height", HEIGHT_COLOR), ("pitch", PITCH_COLOR)):
            line = rr.SeriesLines(colors=[color], names=[f"{name} of swimmer {swimmer}"], widths=[1.5])
            file.log(f"followed/{name}", line)

    def observe(self, frame: Frame) -> None:
        """Take in one frame; send the batch when it is full."""
        for name in ("position", "director", "colloid", "image"):
            self._rows.setdefault(name, []).append(getattr(frame, name)[self._swimmer].copy())
        self._moments.add(frame)
        if len(self._moments) >= BATCH_ROWS:
            self._send()

    def scenery(self) -> Scenery:
        """The part of the box where it was so far."""
        lower, upper = self._corners
        return Scenery(lower, upper, self._field.dimensions)

    def finish(self) -> None:
        """Send the rows that wait; log the colloids that it was near, where all of them would hide it."""
        if len(self._moments):
            self._send()
        if self._field.dimensions == 3 and self._field.is_round:  # else nothing hides it
            visited = np.array(sorted(self._visited))
            log_translucent(self._file, "world/followed/colloids", self._field, self.scenery(), which=visited)

    def state(self) -> dict[str, np.ndarray]:
        """Where it was, and the colloids there; what waits is to be sent first."""
        return {"visited": np.array(sorted(self._visited), dtype=np.int64), "corners": self._corners}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such recording."""
        self._visited, self._corners = set(state["visited"].tolist()), state["corners"].copy()

    def _send(self) -> None:
        position, director, colloid, image = (np.stack(rows) for rows in self._rows.values())
        center = self._field.centers[colloid] + image * self._field.box
        height, sine = self._field.stance(position - center, director, colloid)
        shown = wrapped(position, self._field.box)
        room = self._field.at_surface[colloid, None] + _MARGIN
        corners = np.concatenate([self._corners, shown - room, shown + room])
        self._corners = np.stack([corners.min(axis=0), corners.max(axis=0)])
        self._visited |= set(colloid.tolist())
        for name, values in (("height", height * self._length), ("pitch", np.arcsin(np.clip(sine, -1.0, 1.0)))):
            self._file.send(f"followed/{name}", rr.Scalars.columns(scalars=values), self._moments)
        self._moments, self._rows = Moments(), {}
        self._file.flush()
