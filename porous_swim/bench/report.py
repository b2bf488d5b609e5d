"""The benchmark as a table for people and as JSON for machines."""

from __future__ import annotations

import difflib
import os
import platform
import sys
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from porous_swim.bench import answer, conditions, fields, one_colloid, peers, recording, threads
from porous_swim.bench.figure import QUICK, Counts, Figure, Group, Setting
from porous_swim.bench.reference import References, compilers
from porous_swim.core.console import tell
from porous_swim.core.errors import SceneError

GROUPS: dict[str, Group] = {
    "one_colloid": one_colloid.figures,
    "answer": answer.figures,
    "fields": fields.against_c,
    "colloids": fields.more_colloids,
    "lanes": conditions.lanes,
    "swimmers": conditions.populations,
    "threads": threads.figures,
    "precision": conditions.precision,
    "noise": conditions.noise,
    "memory": conditions.memory,
    "recording": recording.figures,
    "peers": peers.figures,
}
NEED_C = {"one_colloid", "answer", "fields", "threads"}
FORMS = {"ratio": "{:.3f}", "bytes": "{:.0f} bytes", "percent": "{:.2f} %"}
HEADER = ("figure", "value", "quartiles", "target", "", "ns per swimmer-step", "conditions")


def benchmark(names: Sequence[str], *, quick: bool) -> dict[str, Any]:
    """Measure the groups `names`, all where none is named; tells on stderr how far it is. Plain data, for JSON.

    Raises:
        SceneError: there is no such group.
    """
    wanted = _chosen(names)
    counts = QUICK if quick else Counts()
    load = os.getloadavg()[0]
    figures: dict[str, list[dict[str, Any]]] = {}
    with tempfile.TemporaryDirectory() as name:
        references = _references(Path(name), counts) if NEED_C & set(wanted) else References()
        setting = Setting(counts, Path(name), references)
        for group in wanted:
            tell(f"bench: {group}", sys.stderr)
            figures[group] = [_judged(figure, quick) for figure in GROUPS[group](setting)]
    return {
        "machine": {**_machine(), "load_before": load, "load_after": os.getloadavg()[0]},
        "c": {kind: one and one.name for kind, one in vars(references).items()},
        "quick": quick,
        "figures": figures,
    }


def text(found: dict[str, Any]) -> str:
    """The table, in Markdown, below what it was measured on; `found` is from `benchmark`, or from its JSON."""
    machine, figures = found["machine"], [figure for group in found["figures"].values() for figure in group]
    lines = [
        f"{machine['processor']}, {machine['n_cpus']} CPUs, load {machine['load_before']:.1f} to "
        f"{machine['load_after']:.1f}, {machine['date']}; Taichi {machine['taichi']}; "
        + ("; ".join(machine["compilers"].values()) or "no C compiler"),
        "; ".join(f"{kind} C: {name}" for kind, name in found["c"].items() if name),
        "",
    ]
    rows = [HEADER, *[_row(figure) for figure in figures]]
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEADER))]
    table = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in rows
    ]
    rule = "|" + "|".join("-" * (width + 2) for width in widths) + "|"
    n_missed = sum(figure["verdict"] == "missed" for figure in figures)
    n_met = sum(figure["verdict"] == "met" for figure in figures)
    end = "tiny counts: nothing here is a speed" if found["quick"] else f"{n_met} targets met, {n_missed} missed"
    return "\n".join([*lines, table[0], rule, *table[1:], "", end])


def _judged(figure: Figure, quick: bool) -> dict[str, Any]:
    """A figure as plain data; tiny counts give no speed to hold against a target."""
    return figure.as_dict() | ({"verdict": ""} if quick else {})


def _chosen(names: Sequence[str]) -> list[str]:
    for name in names:
        if name not in GROUPS:
            near = difflib.get_close_matches(name, GROUPS, n=1)
            hint = f" (did you mean {near[0]}?)" if near else ""
            raise SceneError(f"bench {name}: there is no such group{hint}; there are: {', '.join(GROUPS)}")
    return [name for name in GROUPS if not names or name in names]


def _references(folder: Path, counts: Counts) -> References:
    """C, or one line that says why there is none."""
    references = References.build(folder, n_swimmers=counts.n_swimmers, n_steps=counts.n_steps, rounds=counts.rounds)
    if references.blocked is None:
        tell("bench: no C compiler (clang or gcc) that works was found: ratios to C are left out", sys.stderr)
    return references


def _machine() -> dict[str, Any]:
    return {
        "processor": _processor(), "n_cpus": os.cpu_count(), "system": platform.platform(),
        "date": datetime.now(UTC).date().isoformat(), "python": platform.python_version(),
        "compilers": compilers(),
        **{name: version(name) for name in ("porous_swim", "taichi", "numpy")},
    }  # fmt: skip


def _processor() -> str:
    """What the processor calls itself, and the widest vectors that it says it has."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    facts = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)}
    flags = facts.get("flags", "").split()
    vectors = next((name for name in ("avx512f", "avx2", "sse2") if name in flags), platform.machine())
    kind = f"family {facts.get('cpu family')}, model {facts.get('model')}" if "cpu family" in facts else ""
    return ", ".join(filter(None, (facts.get("model name", platform.machine()), kind, vectors)))


def _row(figure: dict[str, Any]) -> tuple[str, ...]:
    where, target = figure["conditions"], figure["target"]
    value = FORMS[figure["unit"]].format(figure["value"])
    spread = "" if figure["quartiles"] is None else "{:.3f} to {:.3f}".format(*figure["quartiles"])
    bound = "" if target is None else f"{'>=' if figure['at_least'] else '<='} {target:g}"
    times = ", ".join(f"{name} {taken:.1f}" for name, taken in figure["nanoseconds"].items())
    what = f"{where['dimensions']}-D {where['precision']}, {_many(where['threads'], 'thread')}, "
    what += f"{_many(where['n_swimmers'], 'swimmer')}, {_many(where['n_colloids'], 'colloid')}"
    what += f", {where['rounds']} x {where['n_steps']} steps" if where["n_steps"] else ""
    return figure["name"], value, spread, bound, figure["verdict"], times, what


def _many(n: int, thing: str) -> str:
    return f"{n} {thing}" if n == 1 else f"{n} {thing}s"
