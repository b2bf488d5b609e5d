"""Many colloids, everything on: against blocked C with one colloid, and against fewer colloids."""

from __future__ import annotations

from collections.abc import Sequence

from porous_swim.bench.figure import Conditions, Figure, Setting, compared
from porous_swim.bench.job import crystal, lattice, packing
from porous_swim.bench.timing import take_turns
from porous_swim.bench.works import Placed

TARGETS = {"2-D crystal": 2.0, "3-D fcc lattice": 2.5, "3-D packing": 2.7}


def against_c(setting: Setting) -> Sequence[Figure]:
    """Three fields over the job of one colloid in blocked C, with the widest vectors and with Taichi's."""
    counts, n, blocked = setting.counts, setting.counts.n_swimmers, setting.references.blocked
    if blocked is None:
        return []
    scenes = dict(zip(TARGETS, (crystal(n), lattice(n), packing(n)), strict=True))
    placed = {name: Placed.of(scene) for name, scene in scenes.items()}
    works = {name: one.work(counts.n_steps) for name, one in placed.items()}
    works |= {"blocked C": blocked.work(n, counts.n_steps)}
    narrow = setting.references.narrow
    if narrow is not None:
        works["narrow C"] = narrow.work(n, counts.n_steps)
    times = take_turns(works, counts.rounds)

    def where(name: str) -> Conditions:
        dimensions = scenes[name].domain.dimensions
        return Conditions("f32", 1, n, placed[name].n_colloids, counts.n_steps, dimensions, counts.rounds)

    wide = [
        compared(f"{name}, everything on, over blocked C", times, name, "blocked C", where(name), target=target)
        for name, target in TARGETS.items()
    ]
    return wide + [
        compared(f"{name}, everything on, over narrow C", times, name, "narrow C", where(name))
        for name in TARGETS if "narrow C" in times
    ]  # fmt: skip


def more_colloids(setting: Setting) -> Sequence[Figure]:
    """The fcc lattice from 10^2 to 10^5 colloids, each over 10^3."""
    counts, n = setting.counts, setting.counts.n_swimmers
    every = [Placed.of(lattice(n, cells=cells)) for cells in counts.lattices]
    placed = {f"{one.n_colloids} colloids": one for one in every}
    times = take_turns({name: one.work(counts.n_steps) for name, one in placed.items()}, counts.rounds)
    names = list(placed)
    base, most = names[1], names[-1]
    return [
        compared(
            f"{name} over {base}", times, name, base,
            Conditions("f32", 1, n, one.n_colloids, counts.n_steps, rounds=counts.rounds),
            target=1.1 if name == most else None,
        )
        for name, one in placed.items() if name != base
    ]  # fmt: skip
