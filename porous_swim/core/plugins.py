"""Where parts that are not ours come from: installed packages, which are loaded here, and scripts."""

from __future__ import annotations

import hashlib
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import entry_points, packages_distributions, version
from typing import Any

from porous_swim.core.console import tell

GROUP = "porous_swim.parts"  # of the entry points of plug-ins


@dataclass(frozen=True)
class Plugin:
    """Where a part that is not ours comes from."""

    package: str
    version: str
    """Of the package; of a part that belongs to none, digits that change with the source of its class."""

    @classmethod
    def of(cls, part: type) -> Plugin:
        """Return the installed package that a class belongs to; of one in a script of its own, the class's name."""
        top = part.__module__.partition(".")[0]
        packages: Callable[[], Any] = packages_distributions
        found = packages().get(top, []) if top != "__main__" else []
        return cls(found[0], version(found[0])) if found else cls(name_of(part), _digits(part))


def name_of(part: type) -> str:
    """Return the full name of a class."""
    return f"{part.__module__}.{part.__qualname__}"


def load_installed(take: Callable[[Any, Plugin], None]) -> None:
    """Give each part of an installed plug-in to `take`; what cannot be loaded or taken costs a warning on stderr."""
    for entry in entry_points(group=GROUP):
        package = entry.dist.name if entry.dist is not None else entry.module
        try:
            part = entry.load()
            take(part, Plugin(package, entry.dist.version if entry.dist is not None else _digits(part)))
        except (Exception, SystemExit) as error:
            why = f"{type(error).__name__}: {error}".replace("\n", " ")
            tell(
                f"warning: the plug-in {entry.name} of the package {package} cannot be loaded, so that scenes do not "
                f"know it: {why}",
                sys.stderr,
            )


def _digits(part: type) -> str:
    try:
        source = inspect.getsource(part)
    except (OSError, TypeError):  # typed in by hand
        return "unknown"
    return hashlib.sha256(source.encode()).hexdigest()[:16]
