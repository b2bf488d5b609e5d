"""The one place that starts Taichi."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass
from io import StringIO

import taichi as ti
from taichi.lang import impl

from porous_swim.core import kernel_cache
from porous_swim.core import process_limits as limits
from porous_swim.core.console import tell
from porous_swim.core.errors import DeviceError
from porous_swim.core.machine import usable_processors

ti.set_logging_level(ti.ERROR)  # looking for a device that is not there is no reason to warn

DEVICES = ("cpu", "cuda", "vulkan", "metal")
# Threads of a group: at most one vector of the CPU. Taichi puts a memory barrier before each atomic operation, which
# llvmpipe (Mesa 22.3) takes for a barrier of the whole group: a vector that never gets there ends all the others.
VULKAN_GROUP = 8
AUTO_ORDER = ("cuda", "metal", "cpu")  # Vulkan may be a software driver, so it is used on demand only


@dataclass(frozen=True)
class Backend:
    """A started device."""

    device: str
    threads: int | None  # of the CPU; None on other devices

    @property
    def is_cpu(self) -> bool:
        """Whether blocks of lanes pay."""
        return self.device == "cpu"


_current: Backend | None = None
_forked = False  # this process is the copy of one in which a device ran


def _after_fork() -> None:
    global _forked
    if _current is not None and not _forked:
        _forked = True
        # freed at the end of the process, the device would wait for threads that only the parent has: never free it
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(impl.get_runtime().prog))


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def available(device: str) -> bool:
    """Whether Taichi can start `device` here."""
    from taichi._lib import core

    checks = {"cuda": core.with_cuda, "vulkan": core.with_vulkan, "metal": core.with_metal}
    return device == "cpu" or bool(checks[device]())


def choose(device: str) -> str:
    """The device that `device` means here; `auto` takes the fastest kind there is.

    Raises:
        DeviceError: the device that was asked for is not there.
    """
    if device == "auto":
        return next(name for name in AUTO_ORDER if available(name))
    if not available(device):
        here = ", ".join(name for name in DEVICES if available(name))
        raise DeviceError(f"device: no {device} device was found on this machine; here are: {here}")
    return device


def ensure(device: str = "auto", threads: int | None = None) -> Backend:
    """Start Taichi on `device`, unless it runs there already. Arrays of an earlier device are lost by a change.

    `threads` are those of the CPU, by default as many as this process may use.

    Raises:
        DeviceError: the device is not there, the limits of this process are too low for it, or this process was forked
            from one in which a device had been started.
    """
    global _current
    check_alive()
    name = choose(device)
    wanted = Backend(name, (threads or usable_processors()) if name == "cpu" else None)
    if _current == wanted:
        return wanted
    limits.require(address=limits.FOR_A_DEVICE, threads=(wanted.threads or 0) + limits.OTHER_THREADS // 2)
    for warning in kernel_cache.warnings():
        tell(warning, sys.stderr)
    kernel_cache.check()
    # an array that is freed after a restart frees whatever has its address by then: free what nobody holds before
    gc.collect()
    options = {"cpu_max_num_threads": wanted.threads} if wanted.threads else {}
    if wanted.device == "vulkan":
        options["default_gpu_block_dim"] = VULKAN_GROUP
    with redirect_stdout(StringIO()):  # Taichi greets on stdout, which is for results
        ti.init(
            arch=getattr(ti, wanted.device), default_fp=ti.f32, default_ip=ti.i32, fast_math=False,
            log_level=ti.ERROR, offline_cache=kernel_cache.keeps(), unrolling_limit=0, **options,
        )  # fmt: skip
    if impl.current_cfg().arch != getattr(ti, wanted.device) and not wanted.is_cpu:
        raise DeviceError(f"device: {wanted.device} was found but could not be started")
    _drop_compiled()
    _current = wanted
    return wanted


def check_alive() -> None:
    """Raise a `DeviceError` in a process that was forked after a device was started: its threads are not there."""
    if _forked:
        raise DeviceError(
            "device: this process was forked from one in which a device had been started, and that does not survive "
            "a fork: start workers with multiprocessing.get_context('spawn') or 'forkserver', or before the first run"
        )


@contextmanager
def whole_vectors(on: bool) -> Iterator[None]:
    """Compile kernels within with `ti.types.vector` as vectors of the processor, of any width.

    By default Taichi takes vectors apart, and leaves it to LLVM's vectoriser to find them again, which for processors
    newer than itself (LLVM 15) does so in pieces of four. Small vectors in space then must not occur: see
    `physics.vectors`.
    """
    settings = impl.current_cfg()
    before, settings.real_matrix_scalarize = settings.real_matrix_scalarize, not on
    try:
        yield
    finally:
        settings.real_matrix_scalarize = before


def ensure_any() -> Backend:
    """The device that runs, or the CPU started."""
    check_alive()
    return _current if _current is not None else ensure("cpu")


def _drop_compiled() -> None:
    """Forget the kernels compiled for an earlier device."""
    for name, module in list(sys.modules.items()):
        if name.startswith("porous_swim."):
            for value in vars(module).values():
                if callable(clear := getattr(value, "cache_clear", None)):
                    clear()
