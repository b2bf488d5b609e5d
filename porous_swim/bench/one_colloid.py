"""One colloid: the engine's parts, and the engine whole, against C."""

from __future__ import annotations

from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting, compared
from porous_swim.bench.job import single
from porous_swim.bench.reference import BLOCKS
from porous_swim.bench.timing import fastest, take_turns
from porous_swim.bench.works import Placed, bare_work


def figures(setting: Setting) -> Sequence[Figure]:
    """Ratios to scalar and to blocked C, each by the compiler and the width that are fastest here."""
    counts, n = setting.counts, setting.counts.n_swimmers
    c = setting.references
    bare = {f"bare, blocks of {lanes}": bare_work(n, counts.n_steps, "f32", lanes) for lanes in (1, *BLOCKS)}
    engine = Placed.of(single(n), settling=0)
    references = {"blocked C": c.blocked, "narrow C": c.narrow, "scalar C": c.scalar}
    there = {name: made.work(n, counts.n_steps) for name, made in references.items() if made is not None}
    times = take_turns({**bare, "engine": engine.work(counts.n_steps), **there}, counts.rounds)
    one_lane = "bare, blocks of 1"
    ours = fastest({name: times[name] for name in bare})
    where = Conditions("f32", 1, n, 1, counts.n_steps, rounds=counts.rounds)

    def over(name: str, left: str, right: str, target: float | None = None) -> list[Figure]:
        return [compared(name, times, left, right, where, target=target)] if right in times else []

    return [
        *over("one colloid, no records, over blocked C", ours, "blocked C", 1.15),
        *over("the same, over narrow C", ours, "narrow C"),
        *over("the same, over scalar C", ours, "scalar C", 0.35),
        *over("the same, over one lane", ours, one_lane),
        *over("one colloid, everything on, over blocked C", "engine", "blocked C"),
        *over("one colloid, everything on, over no records", "engine", ours),
    ]
