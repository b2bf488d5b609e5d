"""How much memory and disk a run takes, from its counts alone: before anything is placed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from porous_swim.core.errors import SceneError
from porous_swim.core.machine import available_memory
from porous_swim.engine.kernel.state import Long, n_ints, real_rows
from porous_swim.engine.spill import AT_ONCE, PIECE
from porous_swim.engine.windows import n_levels
from porous_swim.observers.rerun.recording_size import recording_size
from porous_swim.physics.contact import shape_of
from porous_swim.physics.model import has_partners
from porous_swim.scene.scene import Scene

# Measured as peaks of resident memory: see docs/performance.md.
_PROGRAM = 350e6  # Python, libraries, a compiled kernel
_SWIMMER = 48.0 + 110.0  # bytes of the host beside copies of the state: the start, and what searches and frames take
_COLLOID = {2: 2.6e3, 3: 7.0e3}  # the cell index while it is made
_ROW = 60.0  # of the trajectory, on the disk
_ENCOUNTER = 200.0  # on the disk
_PACE = 40.0  # a/U from encounter to encounter of a swimmer among colloids, to within a factor of three
_WAITING, _TABLED = 2 * 200.0, 1.0e3  # of the host, for each encounter that waits for the disk, or becomes a table
_REAL = {"f32": 4, "f64": 8}


@dataclass(frozen=True)
class Footprint:
    """Bytes, at the peak."""

    host: float  # all of it, where the device is the CPU: resident memory
    device: float  # the swimmers on the device, a part of the former on a CPU
    swimmers: float  # what of `host` grows with their number
    colloids: float  # likewise
    disk: float  # in the end


def footprint(scene: Scene) -> Footprint:
    """What a run of a scene takes. How many encounters there will be is guessed; few of them are in memory at once."""
    n = scene.swimmers.count
    state, origins = bytes_per_swimmer(scene)
    swimmers = n * (state + origins + state + _SWIMMER)  # the state twice, as it is made and looked at on the host
    colloids = scene.n_colloids * _COLLOID[scene.domain.dimensions]
    encounters = n * scene.run.duration / _PACE if scene.n_colloids else 0.0
    rows = _WAITING * min(encounters, PIECE) + _TABLED * min(encounters, AT_ONCE)
    n_frames = scene.n_steps // scene.record_period + 1
    disk = recording_size(n_frames=n_frames, n_swimmers=scene.n_recorded, n_trails=scene.n_trails)
    return Footprint(
        _PROGRAM + swimmers + colloids + rows, n * (state + origins), swimmers, colloids,
        disk + _ROW * n_frames * scene.n_recorded + _ENCOUNTER * encounters,
    )  # fmt: skip


def bytes_per_swimmer(scene: Scene) -> tuple[int, int]:
    """On the device, of its state and of its origins in time of displacements."""
    d, real = scene.domain.dimensions, _REAL[scene.precision]
    located = scene.integrator == "located"
    is_round = scene.obstacles.ROUND  # whatever their radii: they are not placed yet
    partners = has_partners(shape_of(scene.swimmers.aspect_ratio, 1.0 if is_round else math.inf), scene.integrator)
    rows = real_rows(d, located=located).n_memory, n_ints(located=located, partners=partners, n_sets=1)
    origins = n_levels(scene.n_frames, burn_in=scene.burn_in_frames) * (3 * d * real + 4 * 4)
    return rows[0] * real + rows[1] * 4 + len(Long) * 8, origins


def require_memory(scene: Scene) -> None:
    """Raise a `SceneError` with the key to change where a run of the scene cannot fit into memory."""
    found, free = footprint(scene), available_memory()
    if found.host <= free.n_bytes:
        return
    if found.swimmers >= found.colloids:
        room = max(0.0, free.n_bytes - found.host + found.swimmers) / found.swimmers
        key, what, most = "swimmers.count", f"{scene.swimmers.count:,} swimmers", int(room * scene.swimmers.count)
    else:
        room = max(0.0, free.n_bytes - found.host + found.colloids) / found.colloids
        key, what, most = "obstacles", f"{scene.n_colloids:,} colloids", int(room * scene.n_colloids)
    raise SceneError(
        f"{key}: a run with {what} takes about {amount(found.host)} of memory, and {amount(free.n_bytes)} are "
        f"{free.source}: expected at most some {_rounded(most):,}"
    )


def amount(n_bytes: float) -> str:
    """Bytes in words, in two or three digits."""
    for size, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if n_bytes >= size:
            return f"{n_bytes / size:.2g} {unit}" if n_bytes < 100 * size else f"{n_bytes / size:.0f} {unit}"
    return f"{n_bytes:.0f} bytes"


def _rounded(count: int) -> int:
    """Down to two digits."""
    digits = max(0, len(str(count)) - 2)
    return count // 10**digits * 10**digits
