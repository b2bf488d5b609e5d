"""Run folders that a test has changed by hand."""

from __future__ import annotations

import json
from pathlib import Path

from porous_swim.results.manifest import SUMMARY, records_of


def relisted(folder: Path) -> Path:
    """Have the summary of a run list its files as they are now, so that only what is in them is judged."""
    summary = json.loads((folder / SUMMARY).read_text())
    summary["files"] = records_of(folder, summary["files"])
    (folder / SUMMARY).write_text(json.dumps(summary))
    return folder
