"""Limits that batch systems set to a process. What starts below them dies in libraries, or hangs: say so before."""

from __future__ import annotations

import threading
from contextlib import suppress

from porous_swim.core.errors import DeviceError
from porous_swim.core.machine import address_space

# Address space is reserved, for the most part, and never used: 1 GB by Rerun's allocator, 1 GB by Taichi's, and more
# for the stacks of threads. Measured: 5.0 GB at 1 thread, 5.1 at 2; 1.95 GB of it when a device starts; 1.2 without.
FOR_A_RUN, FOR_A_DEVICE, FOR_TABLES = 5.2e9, 2.0e9, 2.5e9
LEAST_FILES, MANY_FILES = 24, 256  # open at once; a run needs 14
OTHER_THREADS = 16  # besides those that swim: of libraries


def require(*, address: float, threads: int) -> None:
    """Raise the limit of open files as far as is allowed; `DeviceError` where a limit is too low.

    `address` are bytes of address space that are to be taken, `threads` those that are to be started.
    """
    _require_files()
    left = address_space()
    if left is not None and left < address:
        raise DeviceError(
            f"limits: only {left / 1e9:.3g} GB of address space are left (ulimit -v), and {address / 1e9:.3g} GB are "
            "reserved at the start, most of which is never used: raise this limit, or limit memory itself instead"
        )
    started = _can_start(threads)
    if started < threads:
        raise DeviceError(
            f"limits: only {started} more threads can be started (ulimit -u, or the limit on processes of a control "
            f"group), and up to {threads} are needed: raise this limit, or lower run.threads"
        )


def _require_files() -> None:
    try:
        import resource
    except ImportError:  # no such limits on Windows
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY or soft >= MANY_FILES:
        return
    wanted = MANY_FILES if hard == resource.RLIM_INFINITY else min(hard, MANY_FILES)
    with suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
    allowed = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if allowed < LEAST_FILES:
        raise DeviceError(
            f"limits: only {allowed} files may be open at once (ulimit -n), and up to {LEAST_FILES} are needed: "
            "raise this limit"
        )


def _can_start(wanted: int) -> int:
    """How many threads, up to `wanted`, can run beside each other: by starting them."""
    done, running = threading.Event(), []
    try:
        for _ in range(wanted):
            thread = threading.Thread(target=done.wait, daemon=True)
            thread.start()
            running.append(thread)
    except (RuntimeError, MemoryError):
        pass
    done.set()
    for thread in running:
        thread.join()
    return len(running)
