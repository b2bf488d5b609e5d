"""Draw the scaling curves of a benchmark and print its table: `python tools/bench/plot.py bench.json [picture.png]`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from porous_swim.bench.report import text

ROOT = Path(__file__).resolve().parents[2]


def curve(figures: list[dict[str, Any]]) -> tuple[list[int], list[float]]:
    """Counts and nanoseconds of all contenders of a group, whose names begin with the count."""
    times = {int(name.split()[0]): taken for figure in figures for name, taken in figure["nanoseconds"].items()}
    counts = sorted(times)
    return counts, [times[count] for count in counts]


def bars(figures: dict[str, list[dict[str, Any]]]) -> dict[str, float]:
    """Nanoseconds of the programs, slowest first."""
    times: dict[str, float] = {}
    for group in ("one_colloid", "fields", "peers"):
        for figure in figures[group]:
            times = figure["nanoseconds"] | times  # C is measured with several groups: beside the bare kernel
    return dict(sorted(times.items(), key=lambda item: -item[1]))


def draw(found: dict[str, Any], path: Path) -> None:
    figures = found["figures"]
    picture, (programs, swimmers, colloids, threads) = plt.subplots(
        1, 4, figsize=(16, 3.8), constrained_layout=True, width_ratios=(1.7, 1, 1, 0.8)
    )
    times = bars(figures)
    ours = ["tab:gray" if any(word in name for word in ("C", "NumPy", "LAMMPS")) else "tab:blue" for name in times]
    programs.barh(list(times), list(times.values()), color=ours)
    programs.bar_label(programs.containers[0], fmt="%.1f", padding=2)
    programs.set(xscale="log", xlabel="ns per swimmer-step, one thread", xlim=(1.5, 400))
    for axes, group, label in ((swimmers, "swimmers", "swimmers"), (colloids, "colloids", "colloids")):
        axes.plot(*curve(figures[group]), "o-", color="tab:blue")
        axes.set(xscale="log", xlabel=f"number of {label}", ylabel="ns per swimmer-step", ylim=(0, 20))
    swimmers.set_title("fcc lattice, 864 colloids")
    colloids.set_title("fcc lattice, 2048 swimmers")
    taken = figures["threads"][0]["nanoseconds"]
    for name, color, label in (("engine", "tab:blue", "engine"), ("C", "tab:gray", "C, one colloid")):
        times = {int(key.split(", ")[1].split()[0]): ns for key, ns in taken.items() if key.startswith(name + ",")}
        counts = sorted(times)
        threads.plot(counts, [times[counts[0]] / times[count] for count in counts], "o-", color=color, label=label)
    threads.set(xlabel="threads", ylabel="gain", xticks=counts, ylim=(0, None), title="fcc lattice")
    threads.legend(frameon=False, loc="lower right")
    picture.savefig(path, dpi=120)


if __name__ == "__main__":
    run = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    draw(run, Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "docs" / "performance.png")
    print(text(run))
