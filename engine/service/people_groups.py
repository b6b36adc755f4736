"""People groups: the coordinators of robots that track people, opened, closed and called."""

import msgspec

from engine.service.group_places import Group, GroupKind, GroupPlaces, Key
from engine.service.master_driver import MasterDriver
from engine.service.views import PeopleGroupView
from ppaas.clock import Clock, monotonic
from ppaas.messages import decode
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.people_coordination import (
    ConfigurePeopleRequest,
    GetPeopleCountsRequest,
    GetPeopleCountsResponse,
    PeopleState,
    ZoneCount,
)
from ppaas.people.names import PEOPLE_COORDINATOR, tracks_people
from ppaas.people.settings import PeopleSettings

LINGER = 75.0
"""Time for which a coordinator outlives the places of its robots [s]. By then it has forgotten all people, so that the
store keeps no positions in its last checkpoint."""

KIND = GroupKind(
    "people",
    "people coordinator",
    PEOPLE_COORDINATOR,
    tracks_people,
    LINGER,
    "no robot of user {user} tracks people on map {map} now: connect one with a detector of people",
)


class PeopleGroups:
    """Gives each group of robots that track people a coordinator, and calls it; implements ``PeopleCalls``.

    A coordinator that is refused changes nothing for the robots: the reason is in the view of the group.

    Parameters
    ----------
    service : MasterDriver
        Opens and closes places.
    clock : callable
        Returns monotonic seconds.

    Attributes
    ----------
    places : GroupPlaces
        Places of the coordinators.
    """

    def __init__(self, service: MasterDriver, clock: Clock = monotonic) -> None:
        self.places = GroupPlaces(KIND, service, clock)

    async def views(self) -> list[PeopleGroupView]:
        """Return the groups with robots, by user and map."""
        return [_view(key, group) for key, group in sorted(self.places.groups.items()) if group.robots]

    async def people(self, user: str, map_id: str) -> PeopleState:
        """Return the people whom the robots of a user see on a map."""
        return decode(PeopleState, await self._call(user, map_id, "get_people", Empty()))

    async def counts(self, user: str, map_id: str, since: int) -> list[ZoneCount]:
        """Return the numbers of different people by hour and zone, without hours that ended before a time."""
        answer = await self._call(user, map_id, "get_people_counts", GetPeopleCountsRequest(since))
        return decode(GetPeopleCountsResponse, answer).counts

    async def configure(self, user: str, map_id: str, settings: PeopleSettings) -> None:
        """Make the coordinator of a group use settings, which are stored already.

        A group without a coordinator needs none: each coordinator reads the stored settings when it starts. One that
        was refused is tried again at once, since its settings may have been the reason.
        """
        if self.places.place(user, map_id) is not None:
            text = msgspec.json.encode(settings).decode()
            await self.places.call(user, map_id, "configure_people", ConfigurePeopleRequest(text))
        elif (user, map_id) in self.places.groups:
            self.places.groups[user, map_id].retry_at = float("-inf")

    async def _call(self, user: str, map_id: str, service: str, request: Message) -> bytes:
        group = self.places.groups.get((user, map_id))
        if group is None or not group.robots:
            raise self.places.absent(user, map_id)
        return await self.places.call(user, map_id, service, request)


def _view(key: Key, group: Group) -> PeopleGroupView:
    robots, link = tuple(sorted(group.robots)), group.link
    if link is None or group.refusal is not None:
        return PeopleGroupView(*key, robots, "refused" if group.refusal else "starting", str(group.refusal or ""))
    return PeopleGroupView(*key, robots, "starting" if link.container is None else "ready")
