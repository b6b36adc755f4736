"""Robots that a viewer sees: those of the user and those that are shared with the user, or the ones it names."""

from collections.abc import Sequence
from dataclasses import dataclass

from endpoints.sharing.shared_robots import own_robots, reach, robots_shared_with
from engine.service.endpoints.control_plane import ContainerCalls
from ppaas.errors import NotFound, NotPermitted
from ppaas.maps.new_map import new_map_id
from ppaas.wire.foxglove.conversion.base import SharedFrames
from storage.ports import RobotStore
from storage.records import RobotRecord, User

MAX_ROBOTS = 200
"""Largest number of robots that one viewer sees; further ones are not shown unless it names them."""


@dataclass(frozen=True, slots=True)
class ReachableRobot:
    """Robot that has a running clone.

    Parameters
    ----------
    record : RobotRecord
    name : str
        Its id, below that of its owner if it is another user's.
    frames : SharedFrames
    """

    record: RobotRecord
    name: str
    frames: SharedFrames

    @property
    def key(self) -> tuple[str, str]:
        """Owner and id."""
        return self.record.user, self.record.id


def reached(store: RobotStore, caller: User, named: Sequence[str]) -> list[RobotRecord]:
    """Return the robots that a viewer is to see, with or without a clone; blocks.

    Parameters
    ----------
    store : RobotStore
    caller : User
    named : sequence of str
        Addresses that the viewer names; empty for all.
    """
    if not named:
        mine = own_robots(store, caller, limit=MAX_ROBOTS)
        others = robots_shared_with(store, caller, limit=MAX_ROBOTS - len(mine))
        return [*mine, *(one.record for one in others)]
    found = []
    for address in named:
        try:
            found.append(reach(store, caller, address).record)
        except (NotFound, NotPermitted):
            continue  # it may be registered, or shared, while the viewer waits
    return found


async def running(containers: ContainerCalls, caller: User, records: Sequence[RobotRecord]) -> list[ReachableRobot]:
    """Return those of some robots that have a running clone, with the frame of the map they are on."""
    maps = {
        (one.user, one.robot): one.map.id
        for owner in {record.user for record in records}
        for one in await containers.views(owner)
        if one.robot is not None and one.state == "ready"
    }
    found = []
    for record in records:
        map_id = maps.get((record.user, record.id))
        if map_id is not None:
            name = record.id if record.user == caller.id else f"{record.user}/{record.id}"
            shared = "" if new_map_id(map_id) is not None else map_id
            found.append(ReachableRobot(record, name, SharedFrames(name, shared)))
    return found
