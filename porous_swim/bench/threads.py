"""Two threads against one: the engine's gain over that of C. A process for each number of threads, which take turns."""

from __future__ import annotations

import math
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
from porous_swim.bench.timing import Work, take_turns
from porous_swim.bench.works import Placed

SHARE = 8  # times as many swimmers as elsewhere, so that threads have enough to do
LEAST = 1024  # swimmers to a thread: whole blocks
SHORTER = 20  # turns than those of other figures: some find both cores free
MORE = 20  # times as many
PAUSE = 0.02  # seconds
FREE = 1.5  # gain of C below which there was no second core to be had, and nothing is learnt
BUSY = 1.1  # wall time over CPU time of one thread, above which it had no core to itself


def figures(setting: Setting) -> Sequence[Figure]:
    """Gains of the engine and of C in wall time, best of many turns, and their ratio."""
    if (cpu_count() or 1) < 2:
        return []
    counts, blocked = setting.counts, setting.references.blocked
    n, n_steps, rounds = (
        max(SHARE * counts.n_swimmers, 2 * LEAST),
        max(1, counts.n_steps // SHORTER),
        MORE * counts.rounds,
    )
    with _engine(n, n_steps, 1) as one, _engine(n, n_steps, 2) as two, ThreadPoolExecutor(2) as pool:
        works = {"engine, 1 thread": one.work, "engine, 2 threads": two.work}
        if blocked is not None:
            works |= {
                "C, 1 thread": _c_work(blocked, n, n_steps, 1, pool),
                "C, 2 threads": _c_work(blocked, n, n_steps, 2, pool),
            }
        times = take_turns(works, rounds, clock=time.perf_counter, pause=PAUSE)
    best = {name: float(taken.min()) for name, taken in times.items()}
    gains = {name: best[f"{name}, 1 thread"] / best[f"{name}, 2 threads"] for name in ("engine", "C")[: len(best) // 2]}
    where = Conditions("f32", 2, n, 864, n_steps, rounds=rounds)

    def figure(name: str, value: float, target: float | None = None) -> Figure:
        return Figure(f"gain of two threads, {name}", value, where, target, at_least=True, nanoseconds=best)

    made = [figure(name, gain) for name, gain in gains.items()]
    if "C" in gains:
        quiet = gains["C"] > FREE and best["engine, 1 thread"] < BUSY * one.least
        made.append(figure("engine over C", gains["engine"] / gains["C"], 0.95 if quiet else None))
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


class _Engine:
    """The lattice in a process of its own, where the work runs."""

    def __init__(self, connection: Connection, n_swimmers: int, n_steps: int) -> None:
        self._connection, self._n_steps, self._n = connection, n_steps, n_swimmers * n_steps
        self.least = math.inf  # CPU time, ns per swimmer-step

    def work(self) -> int:
        """A turn."""
        self._connection.send(self._n_steps)
        self.least = min(self.least, self._connection.recv() / self._n * 1e9)
        return self._n


@contextmanager
def _engine(n_swimmers: int, n_steps: int, threads: int) -> Iterator[_Engine]:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_serve, args=(there, n_swimmers, threads), daemon=True)
    process.start()
    there.close()
    here.recv()
    try:
        yield _Engine(here, n_swimmers, n_steps)
    finally:
        here.send(0)
        process.join()


def _serve(connection: Connection, n_swimmers: int, threads: int) -> None:
    """Advance by as many steps as asked, until none is; answer with the CPU time that it took."""
    placed = Placed.of(lattice(n_swimmers, run__threads=threads), settling=100)
    connection.send("ready")
    while (n_steps := connection.recv()) > 0:
        begin = time.process_time()
        placed.simulation.advance(n_steps)
        connection.send(time.process_time() - begin)
