"""Two threads against one: the engine's gain over that of C. A process for each number of threads, which take turns."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from os import cpu_count

from porous_swim.bench.figure import Conditions, Figure, Setting
from porous_swim.bench.job import OneColloid, lattice
from porous_swim.bench.reference import Reference
from porous_swim.bench.timing import Ratio, Work, take_turns
from porous_swim.bench.works import Placed

SHARE = 8  # times as many swimmers as elsewhere, so that threads have enough to do
LEAST = 1024  # swimmers to a thread: whole blocks


def figures(setting: Setting) -> Sequence[Figure]:
    """Wall time: gains of the engine and of C, and their ratio."""
    if (cpu_count() or 1) < 2:
        return []
    counts, blocked = setting.counts, setting.references.blocked
    n = max(SHARE * counts.n_swimmers, 2 * LEAST)
    with _engine(n, counts.n_steps, 1) as one, _engine(n, counts.n_steps, 2) as two, ThreadPoolExecutor(2) as pool:
        works = {"engine, 1 thread": one, "engine, 2 threads": two}
        if blocked is not None:
            works |= {f"C, {k} threads": _c_work(blocked, n, counts.n_steps, k, pool) for k in (1, 2)}
        times = take_turns(works, counts.rounds, clock=time.perf_counter)
    where = Conditions("f32", 2, n, 864, counts.n_steps, rounds=counts.rounds)
    gains = {"engine": times["engine, 1 thread"] / times["engine, 2 threads"]}
    if blocked is not None:
        gains["C"] = times["C, 1 threads"] / times["C, 2 threads"]
        gains["engine over C"] = gains["engine"] / gains["C"]
    made = []
    for name, gain in gains.items():
        ratio = Ratio.of(gain)
        target = 0.95 if name == "engine over C" else None
        quartiles = ratio.low, ratio.high
        best = {contender: float(taken.min()) for contender, taken in times.items()}
        made.append(Figure(f"gain of two threads, {name}", ratio.median, where, target, True, "ratio", quartiles, best))
    return made


def _c_work(reference: Reference, n_swimmers: int, n_steps: int, threads: int, pool: ThreadPoolExecutor) -> Work:
    job = OneColloid()
    state = job.start(n_swimmers, "f32")
    share = n_swimmers // threads
    parts = [slice(k * share, (k + 1) * share) for k in range(threads)]

    def work() -> int:
        list(pool.map(lambda part: reference.advance(state, part, first=0, n_steps=n_steps, job=job), parts))
        return n_swimmers * n_steps

    return work


@contextmanager
def _engine(n_swimmers: int, n_steps: int, threads: int) -> Iterator[Work]:
    """The lattice in a process of its own; the work runs there."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, n_swimmers, threads), daemon=True)
    process.start()
    there.close()
    here.recv()

    def work() -> int:
        here.send(n_steps)
        here.recv()
        return n_swimmers * n_steps

    try:
        yield work
    finally:
        here.send(0)
        process.join()


def _serve(connection: Connection, n_swimmers: int, threads: int) -> None:
    """Advance by as many steps as asked, until none is."""
    placed = Placed.of(lattice(n_swimmers, run__threads=threads), settling=100)
    connection.send("ready")
    while (n_steps := connection.recv()) > 0:
        placed.simulation.advance(n_steps)
        connection.send("done")
