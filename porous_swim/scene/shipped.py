"""The scenes that ship with the package, as templates for new ones."""

from __future__ import annotations

import re
from difflib import get_close_matches
from pathlib import Path

from porous_swim.core.errors import SceneError

_PACKAGE = Path(__file__).parents[1]
NAME_PATTERN = r"[A-Za-z0-9][A-Za-z0-9._-]*"


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
    if re.fullmatch(NAME_PATTERN, target.stem) is None:
        raise SceneError(
            f"{target}: a scene's name has letters, digits, '.', '_' and '-' only, a letter or digit first"
        )
    source = scenes[template]
    text = source.read_text(encoding="utf-8")
    lines = [f"name: {target.stem}" if line.startswith("name:") else line for line in text.splitlines()]
    contents = {target: "\n".join(lines) + "\n"}
    for beside in source.parent.glob("*.csv"):
        if beside.name in text:
            contents[target.with_name(beside.name)] = beside.read_text(encoding="utf-8")
    _write_new(contents)
    return target


def _write_new(contents: dict[Path, str]) -> None:
    """Write files, none of them where another one stands: a copy made earlier may stay."""
    for path, text in contents.items():
        if path.exists() and (path.suffix == ".yaml" or path.read_text(encoding="utf-8") != text):
            raise SceneError(f"{path}: the file exists already")
    for path, text in contents.items():
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise SceneError(f"{path}: cannot be written ({error.strerror})") from None
