"""The colloids on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import taichi as ti

from porous_swim.obstacles.cells import FIXED_BITS, CellIndex
from porous_swim.obstacles.search import Medium

_TAICHI_TYPES = {np.dtype(name): getattr(ti, short) for name, short in
                 {"float32": "f32", "float64": "f64", "int32": "i32", "int64": "i64"}.items()}  # fmt: skip


def on_device(array: np.ndarray) -> Any:
    """A copy of `array` on the device that runs."""
    copy = ti.ndarray(_TAICHI_TYPES[array.dtype], array.shape)
    copy.from_numpy(np.ascontiguousarray(array))
    return copy


def load_medium(cells: CellIndex, real: np.dtype) -> Medium:
    """The cell index on the device, lengths in the precision `real`."""
    grid = np.concatenate([cells.n_cells, cells.periodic, [len(cells.radius)]]).astype(np.int32)
    scale = np.stack([cells.edge / 2.0**FIXED_BITS, 2.0**FIXED_BITS / cells.edge]).astype(real)
    candidate = np.stack([cells.candidate, cells.shift], axis=1)
    arrays = (
        cells.center, cells.radius.astype(real), cells.first, candidate, cells.least.astype(real), grid, scale,
    )  # fmt: skip
    return Medium(*(on_device(array) for array in arrays))
