"""Stops of the robots of a user, as they are stored: one record a user, which the leading master alone writes.

It is stored among the checkpoints of the user's clones, as those of the nodes of groups are.
"""

from collections.abc import Iterable, Mapping

import msgspec

from ppaas.errors import NotFound
from ppaas.messages.health.stops import STOPS_RECORD, RobotStop
from storage.encoding import decode, encode
from storage.ports import CloneStore
from storage.records import CloneCheckpoint, RobotRecord

_STOPS = "stops"


class StoredStops(msgspec.Struct):
    """Record of the stops of the robots of a user."""

    stops: tuple[RobotStop, ...]


def stored_stops(store: CloneStore, user: str) -> tuple[RobotStop, ...]:
    """Return the stops of the robots of a user, oldest first; may block.

    Raises
    ------
    Unavailable
        The record is damaged: nobody may conclude that the robots may drive.
    """
    try:
        record = store.clone(user, STOPS_RECORD)
    except NotFound:
        return ()
    return decode(record.nodes[_STOPS], StoredStops, f"clones/{user}/{STOPS_RECORD}").stops


def store_stops(store: CloneStore, user: str, stops: Iterable[RobotStop], now: float) -> None:
    """Store the stops of the robots of a user at a time [s since the epoch]; may block."""
    kept = tuple(stops)
    if kept:
        store.save_clone(CloneCheckpoint(user, STOPS_RECORD, {_STOPS: encode(StoredStops(kept))}, now))
    else:
        store.remove_clone(user, STOPS_RECORD)


def stops_of_robot(stops: Iterable[RobotStop], robot: str, map_id: str) -> tuple[RobotStop, ...]:
    """Return the stops that apply to a robot on a map."""
    return tuple(stop for stop in stops if stop.applies_to(robot, map_id))


def why_stopped(store: CloneStore, robots: Iterable[RobotRecord]) -> list[str | None]:
    """Return for each of some robots the stops that apply, in words; None if there are none; may block."""
    known = tuple(robots)
    return in_words({user: stored_stops(store, user) for user in {robot.user for robot in known}}, known)


def in_words(stops: Mapping[str, tuple[RobotStop, ...]], robots: Iterable[RobotRecord]) -> list[str | None]:
    """Return for each of some robots the stops that apply, among the stops by user; None if there are none."""
    apply = (stops_of_robot(stops[robot.user], robot.id, robot.map) for robot in robots)
    return ["; ".join(stop.in_words for stop in each) or None for each in apply]


def stops_key(user: str) -> str:
    """Return the key of the news that the stops of a user have changed; no robot has it."""
    return f"{user}/{STOPS_RECORD}"
