"""Robots of a map that may do tasks: who is connected, where they are, and their goals."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Literal, Protocol

from engine.links.place_link import PlaceLink
from engine.links.presence import RobotPresence
from engine.master.places import PlaceRequest, robot_key
from engine.specs.containers import MapVersion
from ppaas.clock import Clock, monotonic
from ppaas.energy.battery import Battery, BatteryEstimator
from ppaas.geometry import Pose2D
from ppaas.tasks.orders import Outcome, RobotNow
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place
from storage.names import Group


class OpenPlaces(Protocol):
    """Open places, as a driver of the master knows them."""

    @property
    def presence(self) -> RobotPresence:
        """Robots that are connected."""
        ...

    def place(self, key: str) -> PlaceLink | None:
        """Return the link of an open place, or None."""
        ...

    def request_of(self, key: str) -> PlaceRequest | None:
        """Return the request of an open or queued place, or None."""
        ...


class RobotGoal(Protocol):
    """Goal of a robot."""

    @property
    def id(self) -> str:
        """Id of the goal."""
        ...

    @property
    def state(self) -> Literal["pending", "active"] | Outcome:
        """State of the goal."""
        ...

    @property
    def text(self) -> str:
        """Reason for it."""
        ...


class Navigator(Protocol):
    """Client of a robot's place that sends it to goals, and follows its pose and the goals that were sent."""

    place: PlaceLink
    followed: frozenset[str] | None

    @property
    def place_now(self) -> Place | None:
        """Pose of the robot; None if it is not known, or not any more."""
        ...

    def send(self, pose: Pose2D, goal_id: str) -> object:
        """Send a goal in the frame ``map``, unless one of that id was sent already."""
        ...

    def cancel_any(self, goal_id: str) -> None:
        """Cancel a goal, also one of another client."""
        ...

    def goals(self) -> Sequence[RobotGoal]:
        """Return the goals that were sent, oldest first."""
        ...

    def leave(self) -> None:
        """Leave the place."""
        ...


MOST_STEP = 5.0
"""Distance between two poses from which the robot did not drive, but was localized elsewhere [m]."""


class _BatteryWatch:
    """Learns the battery of a robot from its reports and poses; it is kept while the robot is away."""

    def __init__(self) -> None:
        self._model = BatteryEstimator()
        self._metres = 0.0
        self._place: Place | None = None

    def see(self, charge: float | None, place: Place | None, now: float, *, charging: bool) -> Battery | None:
        """Note what is reported, and return what is known; nothing while the charge is not reported."""
        if place is not None:
            step = 0.0 if self._place is None else straight(self._place, place)
            self._metres += step if step <= MOST_STEP else 0.0
            self._place = place
        self._model.see(charge, self._metres, now, charging=charging)
        return None if charge is None else self._model.battery


class TaskRobots:
    """Knows the connected robots of all users and maps, and follows the robots on maps with tasks.

    Parameters
    ----------
    places : OpenPlaces
        Places of the robots.
    join : callable
        Returns a new client of a place.
    monotonic : callable
        Returns monotonic time [s].
    """

    def __init__(
        self, places: OpenPlaces, join: Callable[[PlaceLink], Navigator], *, monotonic: Clock = monotonic
    ) -> None:
        self._places = places
        self._join = join
        self._keys: set[str] = set()
        self._clients: dict[str, Navigator] = {}
        self._monotonic = monotonic
        self._batteries: dict[str, _BatteryWatch] = {}
        self._confirmations: dict[str, int] = {}

    def place_opened(self, key: str) -> None:
        """Note a place that was opened or adopted."""
        request = self._places.request_of(key)
        if request is not None and request.robot is not None and not request.robot.new_map:
            self._keys.add(key)

    def close(self) -> None:
        """Leave all places."""
        self.follow_only(set())

    def forget_closed(self) -> None:
        """Forget the places that are closed."""
        for key in tuple(self._keys):
            if self._places.request_of(key) is None or self._places.place(key) is None:
                self._keys.discard(key)
                self._leave(key)

    def connected(self) -> dict[Group, dict[str, MapVersion]]:
        """Return the map versions of the connected robots with a container, by user and map; forget closed places.

        A container that waits for a robot that has left does no task.
        """
        self.forget_closed()
        found: defaultdict[Group, dict[str, MapVersion]] = defaultdict(dict)
        for key in self._keys:
            request, place = self._places.request_of(key), self._places.place(key)
            assert request is not None and request.robot is not None and place is not None, "others are forgotten"
            if place.container is not None and self._places.presence.is_here(key):
                found[request.user, request.map.id][request.robot.id] = request.map
        return found

    def lost_at(self, user: str, robot: str) -> float | None:
        """Return the time at which a robot was lost [s since the epoch]; None if it is connected or not known."""
        return self._places.presence.of(robot_key(user, robot)).disconnected_since

    def follow(self, user: str, robot: str) -> bool:
        """Follow a robot; return whether its place is a new one, which knows of no goals."""
        key = robot_key(user, robot)
        place = self._places.place(key)
        known = self._clients.get(key)
        if place is None or (known is not None and known.place is place):
            return False
        self._leave(key)
        self._clients[key] = self._join(place)
        return True

    def follow_only(self, groups: set[Group]) -> None:
        """Follow only the robots of some users and maps."""
        for key in tuple(self._clients):
            request = self._places.request_of(key)
            if request is None or (request.user, request.map.id) not in groups:
                self._leave(key)

    def client(self, user: str, robot: str) -> Navigator | None:
        """Return the client of a robot that is followed."""
        return self._clients.get(robot_key(user, robot))

    def now(self, user: str, robot: str, labels: Mapping[str, str], *, charging: bool = False) -> RobotNow:
        """Return what is known of a robot that is followed; its place only while it is renewed and its goals known."""
        key = robot_key(user, robot)
        client = self._clients[key]
        if client.followed is None:
            return RobotNow(None, labels)
        place = client.place_now
        watch = self._batteries.setdefault(key, _BatteryWatch())
        battery = watch.see(client.place.beat.report.battery, place, self._monotonic(), charging=charging)
        return RobotNow(place, labels, client.followed, battery)

    def is_confirmed(self, user: str, robot: str) -> bool:
        """Return whether somebody at a robot has confirmed its task since the last call, by its button."""
        key = robot_key(user, robot)
        client = self._clients.get(key)
        count = 0 if client is None else client.place.beat.report.confirmations
        before, self._confirmations[key] = self._confirmations.get(key, count), count
        return count > before

    def _leave(self, key: str) -> None:
        client = self._clients.pop(key, None)
        if client is not None:
            client.leave()
