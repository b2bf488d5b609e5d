"""How large a recording will be."""

from __future__ import annotations

LARGE_RECORDING = 50e6  # bytes; beyond it a recording is slow to send and to open
# measured, a row of one frame: position and state; of a trail: also director, segment and a second point
_SWIMMER_BYTES, _TRAIL_BYTES = 12.9, 67.0
_ROD_BYTES = 12.0  # more for a rod, drawn twice where it leaves a trail: how it is turned, or a second end


def recording_size(*, n_frames: int, n_swimmers: int, n_trails: int, rods: bool = False) -> float:
    """Expected size of a recording, in bytes."""
    more = _ROD_BYTES if rods else 0.0
    return n_frames * ((_SWIMMER_BYTES + more) * n_swimmers + (_TRAIL_BYTES + more) * n_trails)


def recording_warning(*, n_frames: int, n_swimmers: int, n_trails: int, rods: bool = False) -> str | None:
    """One sentence where a recording would be larger than `LARGE_RECORDING`, else None."""
    size = recording_size(n_frames=n_frames, n_swimmers=n_swimmers, n_trails=n_trails, rods=rods)
    if size <= LARGE_RECORDING:
        return None
    return (
        f"the recording will take about {size / 1e6:.0f} MB ({n_swimmers:,} swimmers, {n_frames:,} frames): "
        f"lower record.swimmers or raise record.every to stay under {LARGE_RECORDING / 1e6:.0f} MB"
    )
