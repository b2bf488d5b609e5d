"""What this process may use of the machine: processors and memory, as affinity, control groups and limits allow.

Control groups (Linux, version 1 or 2) set a limit for a group and for each group that it is in: the least holds.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

GROUPS = Path("/sys/fs/cgroup")
PROC = Path("/proc")


@dataclass(frozen=True)
class Memory:
    """Bytes that this process can still take, and whose word that is."""

    n_bytes: float
    source: str  # completes "12 GB ..."


def usable_processors() -> int:
    """How many threads can run at once: what a job was given, not what the machine has."""
    affinity = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quota = min(_quotas(), default=math.inf)
    return affinity if math.isinf(quota) else max(1, min(affinity, math.ceil(quota)))


def bound_libraries(n_threads: int) -> None:
    """Let BLAS and its like start at most so many threads, unless the user says otherwise; before NumPy is loaded."""
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, str(n_threads))


def available_memory() -> Memory:
    """The least of what the machine has free and of what the limits of this process leave; inf where nobody knows."""
    found = [Memory(math.inf, "known")]
    with suppress(OSError, ValueError, StopIteration):
        line = next(row for row in (PROC / "meminfo").read_text().splitlines() if row.startswith("MemAvailable:"))
        found.append(Memory(1024.0 * float(line.split()[1]), "free on this machine"))
    found += [Memory(n_bytes, "left to its control group") for n_bytes in _group_memory()]
    if (limit := address_space()) is not None:
        found.append(Memory(limit, "left of the limit on address space (ulimit -v)"))
    return min(found, key=lambda memory: memory.n_bytes)


def address_space() -> float | None:
    """Bytes of address space that this process can still take; None without a limit."""
    try:
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        pages = int((PROC / "self/statm").read_text().split()[0])
    except (ImportError, OSError, ValueError):
        return None
    return None if limit == resource.RLIM_INFINITY else max(0.0, float(limit - pages * resource.getpagesize()))


def _quotas() -> Iterator[float]:
    """Processors that each control group of this process may keep busy."""
    for folder in _folders("cpu"):
        with suppress(OSError, ValueError):
            quota, period = (folder / "cpu.max").read_text().split()
            if quota != "max":
                yield float(quota) / float(period)
        with suppress(OSError, ValueError):
            quota, period = ((folder / f"cpu.cfs_{name}_us").read_text() for name in ("quota", "period"))
            if float(quota) > 0.0:
                yield float(quota) / float(period)


def _group_memory() -> Iterator[float]:
    """Bytes that each control group of this process can still take. Files that are cached make room."""
    for folder in _folders("memory"):
        for limit, usage, cached in (
            ("memory.max", "memory.current", "inactive_file"),
            ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
        ):
            with suppress(OSError, ValueError):
                most, used = (float((folder / name).read_text()) for name in (limit, usage))  # "max" is no number
                rows = (row.split() for row in (folder / "memory.stat").read_text().splitlines())
                yield most - used + sum(float(row[1]) for row in rows if row[0] == cached)


def _folders(controller: str) -> Iterator[Path]:
    """The folders of this process's control group that `controller` keeps, and of all groups that it is in."""
    try:
        rows = [row.split(":", 2) for row in (PROC / "self/cgroup").read_text().splitlines()]
    except OSError:
        return
    for number, names, group in (row for row in rows if len(row) == 3):
        if number != "0" and controller not in names.split(","):
            continue
        mounts = [GROUPS, GROUPS / "unified"] if number == "0" else [GROUPS / names, GROUPS / controller]
        for mount in mounts:
            inside = mount / group.lstrip("/")  # in a container the path may be that of the host, and not be there
            yield from (folder for folder in (inside, *inside.parents) if folder.is_relative_to(mount))
