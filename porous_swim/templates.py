"""The scenes that ship with the package, as templates for new ones."""

from __future__ import annotations

import shutil
from difflib import get_close_matches
from pathlib import Path

from porous_swim.errors import SceneError

_PACKAGE = Path(__file__).parent


def scenes_folder() -> Path:
    """Where the shipped scenes are: inside an installed package, beside it in a checkout."""
    installed = _PACKAGE / "scenes"
    return installed if installed.is_dir() else _PACKAGE.parent / "scenes"


def copy_template(template: str, target: Path) -> Path:
    """Write the shipped scene `template` to `target` (with the files that it names); return the new file."""
    scenes = {path.stem: path for path in sorted(scenes_folder().glob("*.yaml"))}
    if template not in scenes:
        near = get_close_matches(template, scenes, n=1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise SceneError(f"--from {template}: there is no such scene{hint}; there are: {', '.join(scenes)}")
    target = target if target.suffix == ".yaml" else target.with_name(target.name + ".yaml")
    if target.exists():
        raise SceneError(f"{target}: the file exists already")
    source = scenes[template]
    text = source.read_text(encoding="utf-8")
    for beside in source.parent.glob("*.csv"):
        if beside.name in text and not (target.parent / beside.name).exists():
            shutil.copyfile(beside, target.parent / beside.name)
    lines = [f"name: {target.stem}" if line.startswith("name:") else line for line in text.splitlines()]
    target.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return target
