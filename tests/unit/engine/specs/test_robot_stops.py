"""Stops of the robots of a user, as they are stored, and as containers start with them."""

import msgspec
import pytest

from engine.specs.checkpoints import CheckpointSelection
from engine.specs.robot_stops import store_stops, stored_stops, why_stopped
from ppaas.errors import Unavailable
from ppaas.messages.health.stops import ALL, MAP, ROBOT, STOPS_RECORD, RobotStop
from storage.memory.store import MemoryStore
from storage.records import CloneCheckpoint
from tests.support.engine.specs import coordinator_spec, robot_spec
from tests.support.storage import records

EVERY = RobotStop(ALL, "", "ann", 1.0, "a pallet fell")
HOUSE = RobotStop(MAP, "house", "ann", 2.0)
OWN = RobotStop(ROBOT, "tb1", "bob", 3.0)
OTHER = RobotStop(ROBOT, "tb2", "bob", 4.0)


@pytest.fixture
def store() -> MemoryStore:
    return MemoryStore()


def test_stops_are_stored_by_user_and_removed_with_the_last(store: MemoryStore) -> None:
    store_stops(store, "ann", [EVERY, OWN], 9.0)
    assert stored_stops(store, "ann") == (EVERY, OWN)
    assert stored_stops(store, "bob") == ()
    store_stops(store, "ann", [], 10.0)
    assert stored_stops(store, "ann") == ()


def test_a_damaged_record_is_no_permission_to_drive(store: MemoryStore) -> None:
    store.save_clone(CloneCheckpoint("ann", STOPS_RECORD, {"stops": b"[{"}, 1.0))
    with pytest.raises(Unavailable, match=f"clones/ann/{STOPS_RECORD}"):
        stored_stops(store, "ann")


def test_a_container_starts_with_the_stops_of_its_robot(store: MemoryStore) -> None:
    store_stops(store, "ann", [HOUSE, OWN, OTHER], 9.0)
    selection = CheckpointSelection(store, "this", 30.0)
    stale = msgspec.structs.replace(robot_spec("c1"), session="c1", stops=(EVERY,))
    assert selection.with_checkpoint(stale).stops == (HOUSE, OWN), "its specification may be of an earlier time"
    assert selection.with_checkpoint(msgspec.structs.replace(coordinator_spec("k1"), session="k1")).stops == ()


def test_robots_say_why_they_are_stopped(store: MemoryStore) -> None:
    store_stops(store, "ann", [HOUSE, OWN], 9.0)
    robots = [records.robot("tb1"), records.robot("tb2", map="yard"), records.robot("tb1", user="bob")]
    why, *free = why_stopped(store, robots)
    assert free == [None, None]
    assert why == (
        "all robots on map 'house' are stopped by 'ann' since 1970-01-01 00:00:02 UTC; "
        "stopped by 'bob' since 1970-01-01 00:00:03 UTC"
    )
