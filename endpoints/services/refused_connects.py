"""Refused connects: why the last attempt of a robot to connect failed, for its diagnosis."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, monotonic
from ppaas.errors import PPaaSError

MOST_ROBOTS = 1000
"""Largest number of robots whose last refusal is kept."""

MOST_TEXT = 400
"""Length of the reason that is kept [characters]."""


class RefusedConnect(NamedTuple):
    """Refusal of an attempt to connect: its reason, and the time since then [s]."""

    reason: str
    ago: float


class RefusedConnects:
    """Last refusals by user and robot.

    They belong to this endpoint: a diagnosis by way of another endpoint does not name them, and a connect by way of
    another endpoint does not end them.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    def __init__(self, clock: Clock = monotonic) -> None:
        self._clock = clock
        self._refused: BoundedDict[tuple[str, str], tuple[float, str]] = BoundedDict(MOST_ROBOTS)

    @contextmanager
    def attempt(self, user: str, robot: str, role: str) -> Iterator[None]:
        """Note the error with which an attempt of a robot fails in the block; a success forgets the one before."""
        try:
            yield
        except PPaaSError as error:
            if role == "robot":
                self._refused[user, robot] = self._clock(), f"{error.slug}: {error.public}"[:MOST_TEXT]
            raise
        if role == "robot":
            self._refused.pop((user, robot), None)

    def last(self, user: str, robot: str) -> RefusedConnect | None:
        """Return the last refusal of a robot; None if it connected since, or never tried."""
        refused = self._refused.get((user, robot))
        return None if refused is None else RefusedConnect(refused[1], self._clock() - refused[0])
