"""The errors a user may meet. Each has the sentence to print; none needs a traceback."""

from __future__ import annotations


class PorousSwimError(Exception):
    """Base of every error that porous_swim raises on purpose."""


class SceneError(PorousSwimError, ValueError):
    """A scene that cannot be run as written; the message names file, line, column and key."""


class DeviceError(PorousSwimError, RuntimeError):
    """The device that was asked for is not there."""


class RunError(PorousSwimError, RuntimeError):
    """A run that failed on its way; the message names swimmer, time and place."""


class ResultsError(PorousSwimError, ValueError):
    """A run folder that is missing, incomplete, or would be overwritten."""
