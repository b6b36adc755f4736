"""Person whom a robot follows: position, motion, and the path walked so far."""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from ppaas.messages.people_coordination import LOST, SEEN, TrackedPerson
from ppaas.people.talking_groups import predicted

STARTS, STOPS = 0.3, 0.15
"""Speeds above which a standing person walks, and below which a walking person stands [m/s]."""

LONGEST_PREDICTION = 3.0
"""Time for which a position is predicted after the last message [s]."""

STEP, MOST_STEPS = 0.1, 100
"""Distance between points of the path walked [m], and their number."""


class Target:
    """Position and motion of one person, from the messages of the coordinator.

    Parameters
    ----------
    now : float
        Start, by the clock of the node [s].

    Attributes
    ----------
    known : bool
        Whether a position is known.
    seen_at : float
        Last time at which a robot saw the person [s].
    walking : bool
        Whether the person walks.
    heading : float or None
        Direction in which the person last walked [rad].
    last : TrackedPerson or None
        Last message in which the person was not lost.
    seen : TrackedPerson or None
        Last message in which a robot saw the person, or the first if none did.
    """

    def __init__(self, now: float) -> None:
        self.known, self.walking = False, False
        self.seen_at = self._at = now
        self.heading: float | None = None
        self.last: TrackedPerson | None = None
        self.seen: TrackedPerson | None = None
        self._path: deque[tuple[float, float]] = deque(maxlen=MOST_STEPS)

    def take(self, person: TrackedPerson | None, now: float) -> None:
        """Take the person of a message, None if it has none; one who is lost keeps the last position."""
        if person is None or person.state == LOST:
            return
        if person.state == SEEN or not self.known:
            self.seen_at, self.seen = now, person
        self.last, self._at, self.known = person, now, True
        speed = self.speed
        self.walking = speed > (STOPS if self.walking else STARTS)
        if self.walking:
            self.heading = math.atan2(person.velocity.y, person.velocity.x)
        x, y = person.position.x, person.position.y
        if not self._path or math.dist(self._path[-1], (x, y)) >= STEP:
            self._path.append((x, y))

    @property
    def speed(self) -> float:
        """Speed by the last message [m/s]."""
        return 0.0 if self.last is None else math.hypot(self.last.velocity.x, self.last.velocity.y)

    def position(self, now: float, ahead: float = 0.0) -> tuple[float, float]:
        """Return where the person is now, or after a time ``ahead`` [s]: x, y [m]."""
        assert self.last is not None, "the person is known"
        return predicted(self.last, min(now - self._at, LONGEST_PREDICTION) + (ahead if self.walking else 0.0))

    def behind(self, now: float, ahead: float, distance: float) -> tuple[float, float] | None:
        """Return the point of the path walked that is a length of it [m] behind the person after a time ``ahead`` [s].

        Returns
        -------
        tuple of float or None
            x, y [m]; None if the path is too short.
        """
        path: NDArray[np.float64] = np.array([*self._path, self.position(now), self.position(now, ahead)])[::-1]
        lengths = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
        if lengths[-1] < distance:
            return None
        x, y = (float(np.interp(distance, lengths, path[:, axis])) for axis in (0, 1))
        return x, y
