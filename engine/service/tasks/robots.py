"""Robots of a map that may do tasks: who is connected, where it is, and its goals."""

from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

import msgspec

from engine.master.places import robot_key
from engine.service.master_driver import MasterDriver
from engine.service.navigation_client import NavigationClient
from engine.specs.containers import MapVersion
from ppaas.tasks.orders import RobotNow
from storage.task_records import Group


class TaskRobots:
    """Knows the connected robots of all users and maps, and follows those of maps with tasks.

    Parameters
    ----------
    service : MasterDriver
        Has the places of the robots.
    goal_ended : callable
        Called after a goal of a robot has ended.
    """

    def __init__(self, service: MasterDriver, goal_ended: Callable[[], None]) -> None:
        self._service = service
        self._goal_ended = goal_ended
        self._keys: set[str] = set()
        self._clients: dict[str, NavigationClient] = {}

    def place_opened(self, key: str) -> None:
        """Note a place that was opened or adopted."""
        request = self._service.request_of(key)
        if request is not None and request.robot is not None and not request.robot.new_map:
            self._keys.add(key)

    def close(self) -> None:
        """Leave all places."""
        self.follow_only(set())

    def connected(self) -> dict[Group, dict[str, MapVersion]]:
        """Return the map versions of the robots that have a container, by user and map; forget closed places."""
        found: defaultdict[Group, dict[str, MapVersion]] = defaultdict(dict)
        for key in tuple(self._keys):
            request, place = self._service.request_of(key), self._service.place(key)
            if request is None or request.robot is None or place is None:
                self._keys.discard(key)
                self._leave(key)
            elif place.container is not None:
                found[request.user, request.map.id][request.robot.id] = request.map
        return found

    def follow(self, user: str, robot: str) -> bool:
        """Follow a robot; return whether its place is a new one, which knows of no goals."""
        key = robot_key(user, robot)
        place = self._service.place(key)
        known = self._clients.get(key)
        if place is None or (known is not None and known.place is place):
            return False
        self._leave(key)
        self._clients[key] = NavigationClient(place, goal_ended=self._goal_ended)
        return True

    def follow_only(self, groups: set[Group]) -> None:
        """Follow no robots but those of some users and maps."""
        for key in tuple(self._clients):
            request = self._service.request_of(key)
            if request is None or (request.user, request.map.id) not in groups:
                self._leave(key)

    def client(self, user: str, robot: str) -> NavigationClient | None:
        """Return the client of a robot that is followed."""
        return self._clients.get(robot_key(user, robot))

    def now(self, user: str, robot: str, labels: Mapping[str, str]) -> RobotNow:
        """Return what is known of a robot that is followed; its place only once its goals are known, too."""
        client = self._clients[robot_key(user, robot)]
        if client.followed is None:
            return RobotNow(None, labels)
        return RobotNow(client.state().pose, labels, client.followed)

    def _leave(self, key: str) -> None:
        client = self._clients.pop(key, None)
        if client is not None:
            client.leave()


def labels_of(properties: Mapping[str, Any]) -> dict[str, str]:
    """Return the properties of a robot that tasks may require: texts, and numbers and truths as in JSON."""
    return {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode()
        for name, value in properties.items()
        if isinstance(value, str | int | float | bool)
    }
