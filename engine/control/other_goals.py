"""Results of the goals that clients send past the master: heard at the robots of users who want to know them.

The master follows the goals of REST and of tasks itself (``engine.control.robot_navigation``). Others it hears of only
when Move Base publishes their results, each of which is one message.
"""

from collections.abc import Callable, Collection, Mapping
from typing import Any

from engine.control.open_places import OpenPlaces
from engine.links.place_link import PlaceLink
from engine.specs.goal_states import STATES
from engine.specs.work_counts import FOLLOWED
from ppaas.errors import PPaaSError
from ppaas.messages import decode
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.navigation.goal_watch import status_of
from ppaas.nodes import topics

Report = Callable[[str, Mapping[str, Any]], None]
"""Called with the name of a place and a goal that has ended: its id, state and text."""


class _Results:
    """Listener at one place."""

    def __init__(self, place: PlaceLink, report: Report) -> None:
        self.place = place
        self._report = report
        self._client = place.join(self)
        place.subscribe(topics.MOVE_BASE_RESULT.name, self._client)

    def leave(self) -> None:
        """Leave the place."""
        self.place.leave(self._client)

    def published(self, _topic: str, payload: bytes) -> None:
        """Report the result of a goal, unless the master follows the goal itself."""
        status = decode(MoveBaseActionResult, payload).status
        goal_id = status.goal_id.id
        if not goal_id.startswith(FOLLOWED):
            self._report(self.place.key, {"id": goal_id, "state": STATES[status_of(status)], "text": status.text})

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Do nothing: this client sends nothing."""

    def acknowledged(self, sequence: int) -> None:
        """Do nothing: this client sends nothing."""

    def closed(self, reason: PPaaSError) -> None:
        """Do nothing: a robot that comes back has another place."""


class OtherGoals:
    """Hears the results of goals at the open places of some users.

    Parameters
    ----------
    places : OpenPlaces
    report : callable
    """

    def __init__(self, places: OpenPlaces, report: Report) -> None:
        self._places = places
        self._report = report
        self._users: frozenset[str] = frozenset()
        self._keys: set[str] = set()
        self._heard: dict[str, _Results] = {}

    def place_opened(self, key: str) -> None:
        """Note a place that was opened or adopted."""
        request = self._places.request_of(key)
        if request is not None and request.robot is not None:
            self._keys.add(key)
            self._follow(key)

    def hear(self, users: Collection[str]) -> None:
        """Hear the results of the robots of these users alone, at the places that are open now and later."""
        self._users = frozenset(users)
        self._keys = {key for key in self._keys if self._places.place(key) is not None}
        for key in {*self._keys, *self._heard}:
            self._follow(key)

    def _follow(self, key: str) -> None:
        request, place, known = self._places.request_of(key), self._places.place(key), self._heard.get(key)
        wanted = request is not None and place is not None and request.user in self._users
        if known is not None and not (wanted and known.place is place):
            known.leave()
            del self._heard[key]
            known = None
        if wanted and known is None and place is not None:
            self._heard[key] = _Results(place, self._report)
