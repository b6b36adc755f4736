"""Presence of robots: whether the socket of a robot is at an endpoint, and since when it is not.

The presence of a robot is not the life of its container, which waits for a robot that has left, and which an operator
may open without one. All parts in the process of the master that need to know whether a robot is *connected* ask here;
in its container, the sessions know.
"""

from collections.abc import Callable
from dataclasses import dataclass

from engine.links.place_link import PlaceLink
from ppaas.bounded import BoundedDict
from ppaas.clock import Clock, epoch

MOST_GONE = 10_000
"""Largest number of robots that have left whose times are kept."""


@dataclass(frozen=True, slots=True)
class Presence:
    """Presence of a robot.

    Parameters
    ----------
    connected : bool
        Whether its socket is at an endpoint.
    disconnected_since : float, optional
        Time at which its socket was lost [s since the epoch]; None while it is connected, and if this master has never
        known it.
    """

    connected: bool
    disconnected_since: float | None = None


class RobotPresence:
    """Robots whose sockets are at the endpoints of a cloud.

    Endpoints report each socket of a robot when it opens and when it ends, and all of them to a new master. Until they
    have, the count of the robot's container stands in for theirs.

    Parameters
    ----------
    place_of : callable
        Returns the link of an open place.
    clock : callable
        Returns the time [s since the epoch].
    """

    def __init__(self, place_of: Callable[[str], PlaceLink | None], clock: Clock = epoch) -> None:
        self._place_of = place_of
        self._clock = clock
        self._here: set[str] = set()
        self._expected: set[str] = set()
        self._gone: BoundedDict[str, float] = BoundedDict(MOST_GONE)
        self._hear: Callable[[str, bool], None] = lambda _key, _here: None

    def listen(self, hear: Callable[[str, bool], None]) -> None:
        """Call a function with the key of a robot that was not here and comes, or was and leaves, and whether it came.

        A robot of an adopted place that an endpoint reports was here.
        """
        self._hear = hear

    def came(self, key: str) -> None:
        """Note that the socket of the robot of a place is here."""
        was_here = key in self._here or key in self._expected
        self._here.add(key)
        self._expected.discard(key)
        self._gone.pop(key, None)
        if not was_here:
            self._hear(key, True)

    def left(self, key: str) -> None:
        """Note that it is gone: closed, dead, or lost with its endpoint."""
        was_here = key in self._here or key in self._expected
        self._here.discard(key)
        self._expected.discard(key)
        self._gone[key] = self._clock()
        if was_here:
            self._hear(key, False)

    def expect(self, key: str) -> None:
        """Note an adopted place: the endpoint of its robot has not reported to this master yet, if there is one."""
        if key not in self._here:
            self._expected.add(key)

    def give_up(self, key: str) -> None:
        """Note that no endpoint has reported the robot of an adopted place in time."""
        if key in self._expected:
            self.left(key)

    def has_socket(self, key: str) -> bool:
        """Return whether an endpoint has reported the socket of a robot."""
        return key in self._here

    def is_here(self, key: str) -> bool:
        """Return whether the robot of a place is connected."""
        if key in self._here:
            return True
        place = self._place_of(key) if key in self._expected else None
        return place is not None and place.beat.robot

    def gone_since(self, time: float) -> int:
        """Return the number of robots that left after a time [s since the epoch] and did not come back."""
        return sum(left > time for left in self._gone.values())

    def of(self, key: str) -> Presence:
        """Return the presence of the robot of a place."""
        here = self.is_here(key)
        return Presence(here, None if here else self._gone.get(key))
