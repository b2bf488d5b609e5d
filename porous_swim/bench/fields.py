"""Many colloids, everything on: against blocked C with one colloid, and against fewer colloids."""

from __future__ import annotations

from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting, compared
from porous_swim.bench.job import crystal, lattice, packing
from porous_swim.bench.timing import take_turns
from porous_swim.bench.works import Placed

TARGETS = {"2-D crystal": 2.0, "3-D fcc lattice": 2.5, "3-D packing": 2.7}


def against_c(setting: Setting) -> Sequence[Figure]:
    """Three fields over the job of one colloid in blocked C."""
    counts, n, blocked = setting.counts, setting.counts.n_swimmers, setting.references.blocked
    if blocked is None:
        return []
    scenes = dict(zip(TARGETS, (crystal(n), lattice(n), packing(n)), strict=True))
    placed = {name: Placed.of(scene) for name, scene in scenes.items()}
    works = {name: one.work(counts.n_steps) for name, one in placed.items()}
    times = take_turns({**works, "blocked C": blocked.work(n, counts.n_steps)}, counts.rounds)

    def where(name: str) -> Conditions:
        dimensions = scenes[name].domain.dimensions
        return Conditions("f32", 1, n, placed[name].n_colloids, counts.n_steps, dimensions, counts.rounds)

    return [
        compared(f"{name}, everything on, over blocked C", times, name, "blocked C", where(name), target=target)
        for name, target in TARGETS.items()
    ]


def more_colloids(setting: Setting) -> Sequence[Figure]:
    """The fcc lattice from 10^2 to 10^5 colloids, each over 10^3."""
    counts, n = setting.counts, setting.counts.n_swimmers
    placed = {cells: Placed.of(lattice(n, cells=cells)) for cells in counts.lattices}
    works = {str(cells): one.work(counts.n_steps) for cells, one in placed.items()}
    times = take_turns(works, counts.rounds)
    base, last = str(counts.lattices[1]), counts.lattices[-1]
    return [
        compared(
            f"{one.n_colloids} colloids over {placed[counts.lattices[1]].n_colloids}", times, str(cells), base,
            Conditions("f32", 1, n, one.n_colloids, counts.n_steps, rounds=counts.rounds),
            target=1.1 if cells == last else None,
        )
        for cells, one in placed.items() if str(cells) != base
    ]  # fmt: skip
