"""The errors a user may meet. Each has the sentence to print; none needs a traceback."""

from __future__ import annotations

from porous_swim.core.console import printable


class PorousSwimError(Exception):
    """Base of every error that porous_swim raises on purpose. Its message can be shown anywhere."""

    def __init__(self, message: object = "") -> None:
        """Keep the message without the control characters that names and values of the user may have brought."""
        super().__init__(printable(str(message)))


class SceneError(PorousSwimError, ValueError):
    """A scene that cannot be run as written; the message names file, line, column and key."""


class DeviceError(PorousSwimError, RuntimeError):
    """The device that was asked for is not there."""


class RunError(PorousSwimError, RuntimeError):
    """A run that failed on its way; the message names swimmer, time and place."""


class ResultsError(PorousSwimError, ValueError):
    """A run folder that is missing, incomplete, or would be overwritten."""
