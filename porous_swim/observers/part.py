"""What a scene file says of a user's observer."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

from porous_swim.core.registry import OpenPart
from porous_swim.observers.base import Observer


class ObserverPart(OpenPart):
    """The keys of an observer that scenes name in `record.observers`: a frozen model, chosen by `kind`.

    Observers change no result, so that these keys are no part of a `scene_id`. A file that an observer writes is named
    in a key of its own; relative paths are relative to the folder in which the program was started.
    """

    if TYPE_CHECKING:
        kind: str

    @abstractmethod
    def make(self) -> Observer:
        """Return a new observer, for one run."""
