"""Robots of a map that may do tasks: who is connected, where they are, and their goals."""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Literal, Protocol

from engine.control.open_places import OpenPlaces
from engine.control.tasks.docking import DockingClient
from engine.links.place_link import PlaceLink
from engine.master.places import robot_key
from engine.specs.containers import MapVersion
from ppaas.clock import Clock, monotonic
from ppaas.energy.battery import Battery, BatteryEstimator, Learnt
from ppaas.geometry import Pose2D
from ppaas.tasks.orders import Outcome, RobotNow, Send
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Place, pose_of
from storage.names import Group


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

    def __init__(self, learnt: Learnt | None = None) -> None:
        self._model = BatteryEstimator(learnt)
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
    docked : callable
        Called once a robot has docked or undocked, or has failed to.
    monotonic : callable
        Returns monotonic time [s].
    """

    def __init__(
        self,
        places: OpenPlaces,
        join: Callable[[PlaceLink], Navigator],
        docked: Callable[[], None] = lambda: None,
        *,
        monotonic: Clock = monotonic,
    ) -> None:
        self._places = places
        self._join = join
        self._keys: set[str] = set()
        self._docked = docked
        self._clients: dict[str, Navigator] = {}
        self._docks: dict[str, DockingClient] = {}
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
        self._docks[key] = DockingClient(place, self._docked, monotonic=self._monotonic)
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

    def send(self, user: str, robot: str, order: Send) -> None:
        """Send a robot that is followed to a place or a dock; one that stands at a dock undocks first.

        Raises
        ------
        PPaaSError
            Too much is sent to its clone.
        """
        key, pose = robot_key(user, robot), pose_of(order.place)
        client, docks = self._clients.get(key), self._docks.get(key)
        if client is None or docks is None:
            return  # it is sent once the robot is there
        go: Callable[[], object] = partial(client.send, pose, order.goal_id)
        if order.dock and docks.can_dock:
            go = partial(docks.dock, order.goal_id, order.dock)
        if docks.is_docked and not docks.stands_at(order.dock):
            docks.undock(order.goal_id, go)
        else:
            go()

    def leaves_dock(self, user: str, robot: str, goal_id: str) -> bool:
        """Return whether a robot stands at a dock; it undocks then, for a goal to be sent afterwards."""
        docks = self._docks.get(robot_key(user, robot))
        if docks is None or not docks.is_docked:
            return False
        docks.undock(goal_id, lambda: None)
        return True

    def cancel(self, user: str, robot: str, goal_id: str) -> None:
        """Cancel a goal of a robot, if it is followed."""
        key = robot_key(user, robot)
        if key in self._clients:
            self._docks[key].cancel(goal_id)
            self._clients[key].cancel_any(goal_id)

    def goals(self, user: str, robot: str) -> Sequence[RobotGoal]:
        """Return the goals that were sent to a robot; none if it is not followed."""
        key = robot_key(user, robot)
        return [*self._docks[key].goals(), *self._clients[key].goals()] if key in self._clients else []

    def recall(self, user: str, robot: str, learnt: Learnt) -> None:
        """Go on from what was learnt of the battery of a robot, unless its reports have come already."""
        self._batteries.setdefault(robot_key(user, robot), _BatteryWatch(learnt))

    def now(self, user: str, robot: str, labels: Mapping[str, str], *, charging: bool = False) -> RobotNow:
        """Return what is known of a robot that is followed; its place only while it is renewed and its goals known."""
        key = robot_key(user, robot)
        client = self._clients[key]
        if client.followed is None:
            return RobotNow(None, labels)
        place = client.place_now
        watch = self._batteries.setdefault(key, _BatteryWatch())
        battery = watch.see(client.place.beat.report.battery, place, self._monotonic(), charging=charging)
        return RobotNow(place, labels, client.followed | self._docks[key].followed, battery)

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
            self._docks.pop(key).leave()
