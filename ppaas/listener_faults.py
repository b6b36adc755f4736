"""Faults of listeners: an exception of one reaches neither the others nor the one that calls them."""

import logging
from collections.abc import Callable
from typing import ParamSpec

from ppaas.bounded import BoundedDict
from ppaas.errors import PPaaSError

P = ParamSpec("P")

MOST_NAMES = 256
"""Largest number of listeners whose faults are remembered."""


def internal_error(error: Exception) -> PPaaSError:
    """Return an exception as an error to report; one of the project's own errors unchanged."""
    return error if isinstance(error, PPaaSError) else PPaaSError(f"internal error: {type(error).__name__}")


class ListenerFaults:
    """Calls listeners, and logs the first fault of each with its traceback; further ones at level DEBUG.

    Parameters
    ----------
    logger : Logger
        Logger of the module that calls the listeners.
    """

    def __init__(self, logger: logging.Logger) -> None:
        self._logger = logger
        self._known: BoundedDict[tuple[str, type[Exception]], None] = BoundedDict(MOST_NAMES)

    def call(self, name: str, listener: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> PPaaSError | None:
        """Call a listener; return its fault as an error to report, or None.

        Parameters
        ----------
        name : str
            Name of the listener in the log.
        listener : callable
        """
        try:
            listener(*args, **kwargs)
        except Exception as error:  # noqa: BLE001 - it is logged by `note`
            return self.note(name, error)
        return None

    def deliver(self, name: str, listener: Callable[P, object], *args: P.args, **kwargs: P.kwargs) -> PPaaSError | None:
        """Call a listener that may refuse by an error of the project, which is returned without a line in the log."""
        try:
            listener(*args, **kwargs)
        except PPaaSError as refusal:
            return refusal
        except Exception as error:  # noqa: BLE001 - it is logged by `note`
            return self.note(name, error)
        return None

    def note(self, name: str, error: Exception) -> PPaaSError:
        """Log the fault of a listener, whose name is formatted for it alone; return it as an error to report."""
        known = (name, type(error)) in self._known
        self._known[name, type(error)] = None
        level = logging.DEBUG if known else logging.ERROR
        self._logger.log(level, "%s failed; the other listeners go on", name, exc_info=error)
        return internal_error(error)
