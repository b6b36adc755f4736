"""The contract of every ``RobotStore`` for robots that are shared."""

from collections.abc import Callable

import pytest

from ppaas.errors import Conflict, InvalidInput, NotFound
from storage.ports import Store
from storage.records import RobotRecord
from storage.sharing_records import Share, TokenScope
from tests.support.storage.records import NOT_NAMES, robot, token, user

BOB = Share("bob", "drive", ("cmd_vel",), ("*",))
HALL = Share("group:hall", "look")


def shared(store: Store, owner: str, name: str, *shares: Share) -> RobotRecord:
    """Store a robot, and share it."""
    store.put_robot(robot(name, user=owner))
    return store.change_shares(store.robot(owner, name), shares)


def ids(records: list[RobotRecord]) -> list[str]:
    return [f"{record.user}:{record.id}" for record in records]


def test_shares_and_scopes_and_groups_are_returned_as_stored(store: Store) -> None:
    given = shared(store, "ann", "tb1", BOB, HALL)
    assert store.robot("ann", "tb1") == given
    assert store.robot("ann", "tb1").shares == (BOB, HALL)
    store.add_user(user("ann", groups=("hall", "night")))
    assert store.user("ann").groups == ("hall", "night")
    scoped = token("a" * 64, scope=TokenScope(("tb*",), "robot", ("scan",), ()), name="wall")
    store.add_token(scoped)
    assert store.token("a" * 64) == store.tokens("ann")[0] == scoped


def test_robots_are_listed_for_those_they_are_shared_with(store: Store) -> None:
    for owner, name in (("carl", "tb1"), ("ann", "tb2"), ("ann", "tb1"), ("Zoe", "tb9")):
        shared(store, owner, name, BOB)
    shared(store, "ann", "tb3", HALL)
    assert ids(store.robots_shared_with("bob")) == ["Zoe:tb9", "ann:tb1", "ann:tb2", "carl:tb1"]
    assert ids(store.robots_shared_with("group:hall")) == ["ann:tb3"]
    assert ids(store.robots_shared_with("bob", after=("ann", "tb1"), limit=1)) == ["ann:tb2"]
    assert store.robots_shared_with("bob", limit=0) == store.robots_shared_with("group:bob") == []


def test_a_robot_is_listed_no_more_once_it_is_not_shared(store: Store) -> None:
    record = shared(store, "ann", "tb1", BOB, HALL)
    store.change_shares(record, (HALL,))
    assert store.robots_shared_with("bob") == []
    assert ids(store.robots_shared_with("group:hall")) == ["ann:tb1"]
    store.put_robot(robot("tb1"))
    assert store.robots_shared_with("group:hall") == []


def test_shares_end_with_the_robot_and_with_its_user(store: Store) -> None:
    store.add_user(user("ann"))
    shared(store, "ann", "tb1", BOB)
    store.remove_robot("ann", "tb1")
    store.put_robot(robot("tb1"))
    assert store.robots_shared_with("bob") == []
    shared(store, "ann", "tb2", BOB)
    store.remove_user("ann")
    store.add_user(user("ann"))
    store.put_robot(robot("tb2"))
    assert store.robots_shared_with("bob") == []


def test_shares_of_a_robot_that_changed_meanwhile_are_not_changed(store: Store) -> None:
    before = shared(store, "ann", "tb1", BOB)
    store.change_shares(before, ())
    with pytest.raises(Conflict, match="tb1"):
        store.change_shares(before, (BOB, HALL))
    assert store.robot("ann", "tb1").shares == ()
    assert store.robots_shared_with("bob") == store.robots_shared_with("group:hall") == []
    store.remove_robot("ann", "tb1")
    with pytest.raises(Conflict):
        store.change_shares(before, ())
    with pytest.raises(NotFound):
        store.robot("ann", "tb1")


@pytest.mark.parametrize("name", NOT_NAMES)
def test_invalid_names_of_users_and_groups_are_refused(store: Store, name: str) -> None:
    record = shared(store, "ann", "tb1")
    calls: list[Callable[[str], object]] = [
        store.robots_shared_with,
        lambda grantee: store.change_shares(record, (Share(grantee, "look"),)),
    ]
    for call in calls:
        for grantee in (name, f"group:{name}", f"group:group:{name}"):
            with pytest.raises(InvalidInput):
                call(grantee)
