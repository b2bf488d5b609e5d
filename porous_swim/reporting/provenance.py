"""Section: what made the runs, enough to make them again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from porous_swim.reporting.run import Run, differences
from porous_swim.reporting.section import Section, Table


def section(runs: Sequence[Run]) -> Section:
    """Version, scene, seed, device, precision, speed, status; and the scene as it was run."""
    found = [_entries(run) for run in runs]
    names = list(dict.fromkeys(name for each in found for name in each))
    rows = [[name, *(each.get(name, "") for each in found)] for name in names]
    return Section(
        "Provenance", "provenance",
        tables=[Table(["", *(run.label for run in runs)], rows), *_differences(runs)],
        listings=[(run.says("scene.yaml"), text) for run in runs if (text := _scene_text(run))],
    )  # fmt: skip


def _differences(runs: Sequence[Run]) -> list[Table]:
    """What the scenes of several runs do not share."""
    found = differences([run.scene for run in runs])
    if not found:
        return []
    rows = [[key, *values] for key, values in found.items()]
    return [Table(["key of the scene", *(run.label for run in runs)], rows, "What differs between the scenes.")]


def _entries(run: Run) -> dict[str, str]:
    summary = run.results.summary
    entries = {"status": str(summary.get("status", "not known"))}
    if run.results.folder is not None:
        entries["folder"] = Path(run.results.folder).name
    provenance: Mapping[str, Any] = summary.get("provenance") or run.results.info.provenance
    for name, value in provenance.items():
        words = name.replace("_", " ")
        if isinstance(value, Mapping):
            entries[words] = ", ".join(f"{key} {version}" for key, version in value.items())
        elif isinstance(value, float):
            entries[words] = f"{value:.4g}"
        elif name == "threads" and value is None and provenance.get("device") == "cpu":
            entries[words] = "all of the processor's"
        else:
            entries[words] = "not known" if value is None else str(value)
    return entries


def _scene_text(run: Run) -> str:
    path = None if run.results.folder is None else Path(run.results.folder) / "scene.yaml"
    return path.read_text(encoding="utf-8", errors="replace") if path is not None and path.is_file() else ""
