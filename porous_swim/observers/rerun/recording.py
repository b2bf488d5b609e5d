"""The recording of a run: a Rerun file to look at. The tables of the run are for science.

Positions in a, wrapped into the periodic box and in single precision; series and distributions in um and s where those
are known, else in a and a/U.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
import rerun as rr

from porous_swim.core.console import printable
from porous_swim.core.errors import RunError
from porous_swim.core.scales import Scales
from porous_swim.core.state import Remembers, State, restore_parts, state_of
from porous_swim.observers.base import Every, Frame, Observer
from porous_swim.observers.rerun.about import About
from porous_swim.observers.rerun.above import log_camera, log_scale_bar
from porous_swim.observers.rerun.blueprint import Layout
from porous_swim.observers.rerun.bodies import Body
from porous_swim.observers.rerun.colloids import MAX_TRANSLUCENT, log_endless, log_translucent, log_world
from porous_swim.observers.rerun.followed import FollowedTrack
from porous_swim.observers.rerun.network import HopTrack
from porous_swim.observers.rerun.pictures import Pictures
from porous_swim.observers.rerun.space import Space
from porous_swim.observers.rerun.statistics import DISTRIBUTIONS, DistributionTrack, SeriesTrack
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.observers.rerun.summary_page import SummaryPage
from porous_swim.observers.rerun.swimmers import SwimmerTrack
from porous_swim.observers.rerun.timeline import TimeLine
from porous_swim.observers.rerun.view import Scenery
from porous_swim.obstacles.field import ObstacleField


class Track(Remembers, Protocol):
    """One part of a recording; its state is asked for when nothing waits."""

    def observe(self, frame: Frame) -> None:
        """Take in one frame."""

    def finish(self) -> None:
        """Send what waits; a picture, drawn anew, only at the end."""


class Recording(Observer):
    """Writes `path` while the run goes on, under the name with `.part` appended until `finish`.

    `swimmers` are the ids recorded, `trails` those of them with director, trail and lane of states; the first of
    these is followed on a page of its own. `RunError` where the file cannot be written.
    """

    schedule: Every
    wants_events = True

    def __init__(
        self, path: Path | str, schedule: Every, field: ObstacleField, about: About, *, swimmers: np.ndarray,
        trails: np.ndarray,
    ) -> None:  # fmt: skip
        self.schedule = schedule
        self._path, self._field, self._about = Path(path), field, about
        self._scales = None if about.units is None else Scales(*about.units)
        self._timeline = TimeLine(about.time_step, None if about.units is None else about.units[1])
        self._swimmers, self._trails = (
            np.asarray(swimmers, dtype=np.int64),
            np.asarray(trails, dtype=np.int64),
        )
        self._page = SummaryPage(
            about.name, about.description, field, len(self._swimmers), self._timeline, self._scales
        )
        self._file: RecordingFile | None = None
        self._last: Frame | None = None
        self._start: np.ndarray | None = None  # (n_recorded, 3)
        self._results: str | None = None
        self._tracks: dict[str, Track] = {}
        self._before: State = {}  # of the recording that this one goes on from
        self._follower: FollowedTrack | None = None
        self._visited: set[int] = set()
        self._failed = False
        self._finished = False

    def set_summary(self, markdown: str) -> None:
        """Tables of results for the page of text; to be given before `finish`."""
        self._results = markdown

    @property
    def events_due(self) -> bool:
        """Whether the next frame is to tell what is new; the others need not."""
        return self._file is None or any(picture.due for picture in self._pictures)

    @property
    def is_behind(self) -> bool:
        """Whether the last frame was seen without its events, which the pictures of the end need: see `catch_up`."""
        return self._last is not None and not self._last.has_events

    def catch_up(self, frame: Frame) -> None:
        """Take in the events alone of the last frame, which is `frame`."""
        for picture in self._pictures:
            picture.take(frame)

    def observe(self, frame: Frame) -> None:
        """Take in one frame; the first one opens the file."""
        try:
            if self._file is None:
                self._open(frame)
            for track in self._tracks.values():
                track.observe(frame)
        except RunError:
            self._failed = True
            raise
        self._last = frame
        if self._crowded:
            self._visited |= set(frame.colloid[self._trails].tolist()) - {-1}

    def keep(self) -> None:
        """Write the rows that wait: what is on disk outlives a run that is killed."""
        if self._file is None or self._failed or self._finished:
            return
        try:
            for track in self._tracks.values():
                if not isinstance(track, Pictures):
                    track.finish()
            self._file.flush()
        except RunError:
            self._failed = True
            raise

    def drop(self) -> None:
        """Give the recording up, and the room on the disk that it takes."""
        self._failed = True
        if self._file is not None:
            self._file.drop()

    def finish(self, *, interrupted: bool) -> None:
        """Send what waits, write the page of text, close and check the file, and give it its name."""
        if self._file is None or self._last is None or self._failed or self._finished:
            return
        self._finished = True
        step, time = self._last.step, self._page.time(self._last.time)
        for track in self._tracks.values():
            track.finish()
        if self._crowded and len(self._trails):
            log_translucent(
                self._file,
                "world/visited",
                self._field,
                self._layout(self._last, self._distributions.drawn).space.scenery,
                which=np.array(sorted(self._visited)[:MAX_TRANSLUCENT]),
            )
        if interrupted:
            status = f"**Interrupted** at step {step:,} of {self._about.n_steps:,} (time {time})."
            self._say(f"interrupted at step {step} of {self._about.n_steps}", "WARN", self._last)
        else:
            status = f"Finished: {step:,} steps, to time {time}."
            self._say(f"finished at step {step}", "INFO", self._last)
        self._write_page(self._page.text(self._last, status=status, results=self._results))
        layout = self._layout(self._last, self._distributions.drawn)
        self._draw_surroundings(layout.space)
        self._file.lay_out(layout.blueprint())
        self._file.close()

    def state(self) -> dict[str, np.ndarray]:
        """All that pictures, trails and layout need of what was seen. The rows themselves are in the file."""
        if self._file is None or self._start is None:
            return dict(self._before)
        self.keep()
        return {
            "start": self._start, "visited": np.array(sorted(self._visited), dtype=np.int64),
            **state_of(self._tracks),
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """Go on, in a file that begins with the next frame, from the `state` of the recording of what was before."""
        self._before = dict(state)

    @property
    def _pictures(self) -> list[Pictures]:
        return [track for track in self._tracks.values() if isinstance(track, Pictures)]

    @property
    def _crowded(self) -> bool:
        return len(self._field.centers) > MAX_TRANSLUCENT

    def _open(self, frame: Frame) -> None:
        before = self._before
        self._start = before["start"].copy() if before else frame.position[self._swimmers]
        layout = self._layout(frame, self._possible)
        self._file = file = RecordingFile(self._path, recording_id=self._about.recording_id, timeline=self._timeline)
        file.lay_out(layout.blueprint())
        file.describe(self._page.name, self._about.provenance)
        log_world(file, self._field, layout.space.scenery)
        self._draw_surroundings(layout.space)
        self._tracks = self._make_tracks(file, layout.space.scenery.body(self._about.aspect_ratio))
        if before:
            self._visited = set(before["visited"].tolist())
            restore_parts(self._tracks, before)
        self._write_page(self._page.text(frame, status="*Cut short: the run was under way when this was written.*"))
        begun = "resumed" if before else "started"
        self._say(f"{begun}: {frame.ensemble.n_swimmers} swimmers, {len(self._field.centers)} colloids", "INFO", frame)
        file.flush()

    def _make_tracks(self, file: RecordingFile, body: Body) -> dict[str, Track]:
        n_frames = self._about.n_steps // self.schedule.period + 1
        self._distributions = DistributionTrack(
            file, names=self._possible, time_step=self._about.time_step, n_frames=n_frames, scales=self._scales
        )
        swimmers = SwimmerTrack(
            file, swimmers=self._swimmers, trails=self._trails, followed=self._followed, box=self._field.box,
            body=body,
        )  # fmt: skip
        tracks: dict[str, Track] = {
            "swimmers": swimmers,
            "series": SeriesTrack(file, self._scales),
            "distributions": self._distributions,
        }
        if self._followed is not None:
            self._follower = FollowedTrack(file, self._field, self._followed, self._scales)
            tracks["followed"] = self._follower
        if "hop_time" in self._possible:
            duration = self._about.n_steps * self._about.time_step
            tracks["hops"] = HopTrack(file, self._field, n_frames=n_frames, duration=duration)
        return tracks

    @property
    def _followed(self) -> int | None:
        """The first swimmer with a trail, so that nothing is known of it beforehand; none where nothing is near."""
        return int(self._trails[0]) if len(self._trails) and len(self._field.centers) else None

    @property
    def _possible(self) -> tuple[str, ...]:
        """The distributions that the field allows: nobody winds around what has no other side, nor hops alone."""
        n_colloids = len(self._field.centers)
        missing = set(DISTRIBUTIONS) if n_colloids == 0 else set()
        if not self._field.is_round:
            missing.add("winding")
        if n_colloids == 1 and not self._field.periodic:  # in a box there is its own image
            missing.add("hop_time")
        return tuple(name for name in DISTRIBUTIONS if name not in missing)

    def _layout(self, frame: Frame, distributions: tuple[str, ...]) -> Layout:
        # around spheres, show these and the release; else wherever the swimmers went
        start = self._start if self._start is not None else frame.position[self._swimmers]
        scenery = Scenery.of(self._field, start if self._field.bounded else frame.position[self._swimmers])
        space = Space(
            scenery=scenery,
            # in open space a lone swimmer may go far
            close=self._follower.scenery() if self._follower is not None and self._field.periodic else scenery,
            timeline=self._timeline,
            duration=max(self._about.n_steps * self._about.time_step, frame.time),
            periodic=self._field.periodic,
            flat=self._field.dimensions == 2 or not self._field.is_round,
            crowded=self._crowded,
        )
        return Layout(
            space,
            self._timeline,
            self._scales,
            has_colloids=len(self._field.centers) > 0,
            has_trails=len(self._trails) > 0,
            followed=self._followed,
            distributions=distributions,
        )

    def _draw_surroundings(self, space: Space) -> None:
        """What follows from the scenery: a part of endless bodies; in a plane the camera above it and scale bars."""
        assert self._file is not None
        log_endless(self._file, self._field, space.scenery)
        if self._field.dimensions == 2:
            log_camera(self._file, space.scenery)
            log_scale_bar(self._file, "world/scale", space.scenery, self._scales)
            log_scale_bar(self._file, "world/followed/scale", space.close, self._scales)

    def _write_page(self, text: str) -> None:
        assert self._file is not None
        self._file.log("summary", rr.TextDocument(printable(text), media_type=rr.MediaType.MARKDOWN))

    def _say(self, text: str, level: str, frame: Frame) -> None:
        assert self._file is not None
        self._file.log_at("log", rr.TextLog(printable(text), level=level), step=frame.step, time=frame.time)
