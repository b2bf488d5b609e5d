"""How long a run will take, before it is made. In seconds of an idle CPU, within a factor of two."""

from __future__ import annotations

import math
from dataclasses import dataclass

from porous_swim.core.machine import usable_processors
from porous_swim.engine.engine import LANES
from porous_swim.obstacles.field import ObstacleField
from porous_swim.physics.contact import shape_of
from porous_swim.physics.model import Shape
from porous_swim.running.whereabouts import far_share, pair_share
from porous_swim.scene.scene import Scene

# A swimmer-step on one thread of a present-day x86-64 CPU whose other threads swim too, measured in a crystal.
NANOSECONDS: dict[tuple[str, str], dict[Shape, float]] = {
    ("euler", "f32"): {"sphere": 11.0, "flat": 11.0, "rod": 18.0, "needle": 48.0},
    ("euler", "f64"): {"sphere": 14.0, "flat": 14.0, "rod": 34.0, "needle": 100.0},
    ("reflected", "f32"): {"sphere": 18.0, "flat": 18.0, "rod": 28.0, "needle": 80.0},
    ("reflected", "f64"): {"sphere": 24.0, "flat": 24.0, "rod": 60.0, "needle": 170.0},
    ("located", "f64"): {"sphere": 900.0, "flat": 900.0, "rod": 4400.0, "needle": 15000.0},
}
# Times the same, for rods: where any of a block of lanes is near two colloids; and for each that is.
_PAIR, _SETTLE = 1.8, 1.5
_COMPILING, _COMPILING_PAIRS = 10.0, 30.0  # of a kernel that is not in the cache; where rods may touch two spheres
_STARTING = 2.5  # Python, placing, a kernel from the cache, tables and summary of few encounters
_FRAME, _FRAME_SWIMMER, _FRAME_RECORDED = 2.2e-3, 0.04e-6, 1.6e-6  # a look; each swimmer; each recorded


@dataclass(frozen=True)
class Seconds:
    """Where the time of a run will go."""

    swimming: float
    recording: float  # frames, tables
    n_threads: int  # that swim

    @property
    def total(self) -> float:
        """All of a run whose kernel is in the cache."""
        return _STARTING + self.swimming + self.recording


def compiling_seconds(scene: Scene) -> float:
    """Of a kernel that is not in the cache yet."""
    pairs = scene.swimmers.aspect_ratio < 1.0 and scene.obstacles.ROUND
    return _COMPILING_PAIRS if pairs and scene.integrator != "located" else _COMPILING


def expected_seconds(scene: Scene, field: ObstacleField) -> Seconds:
    """The time of a run on the threads of its scene. A thread has a block of lanes at a time."""
    n, shape = scene.swimmers.count, shape_of(scene.swimmers.aspect_ratio, float(field.radii.min(initial=math.inf)))
    lanes = 1 if scene.integrator == "located" else LANES[scene.precision]
    n_blocks = math.ceil(n / lanes)
    n_threads = min(scene.run.threads or usable_processors(), n_blocks)
    lane_steps: float = lanes * math.ceil(n_blocks / n_threads) * scene.n_steps
    lane_steps *= 1.0 - far_share(scene, field) * (1.0 - 1.0 / scene.flight_ticks)
    pairs = 0.0 if scene.integrator == "located" else pair_share(scene, field)
    times = 1.0 + _PAIR * (1.0 - (1.0 - pairs) ** lanes) + _SETTLE * pairs
    n_frames = scene.n_steps // scene.record_period + 1
    return Seconds(
        swimming=1e-9 * NANOSECONDS[scene.integrator, scene.precision][shape] * lane_steps * times,
        recording=n_frames * (_FRAME + _FRAME_SWIMMER * n + _FRAME_RECORDED * scene.n_recorded),
        n_threads=n_threads,
    )
