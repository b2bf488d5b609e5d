"""Arrays from the device to the host and back. Taichi's own ways launch a kernel; the memory of a CPU is at hand."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from taichi.lang import impl
from taichi.lang.util import to_numpy_type

from porous_swim.engine import backend

_views: WeakKeyDictionary[Any, np.ndarray] = WeakKeyDictionary()


def on_host(table: Any, part: Any = slice(None)) -> np.ndarray:
    """A copy of an array on the device, or of a `part` of it, an index of NumPy."""
    if not backend.ensure_any().is_cpu:
        return np.asarray(table.to_numpy()[part])
    return np.array(_memory(table)[part])


def to_device(values: np.ndarray, table: Any) -> None:
    """Overwrite an array on the device."""
    if backend.ensure_any().is_cpu:
        _memory(table)[:] = values
    else:
        table.from_numpy(values)


def _memory(table: Any) -> np.ndarray:
    """An array of the CPU as NumPy sees it, while `table` lives. A launch there returns when its kernel has ended."""
    if table not in _views:  # to make one takes as long as to copy some thousand numbers
        kind = np.ctypeslib.as_ctypes_type(to_numpy_type(table.dtype))
        address = impl.get_runtime().prog.get_ndarray_data_ptr_as_int(table.arr)
        n = int(np.prod(table.shape))
        _views[table] = np.ctypeslib.as_array((kind * n).from_address(address)).reshape(table.shape)
    return _views[table]
