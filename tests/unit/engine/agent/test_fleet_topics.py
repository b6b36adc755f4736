"""Fleet topics without a container gateway; test_container_gateway tests them with one."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.agent.fleet_topics import MAX_SHARED, MAX_STATE, FleetTopics, heard_by, scope_of
from engine.fabric.keys import parse_shared
from engine.protocols import machine_link
from ppaas.errors import MessageTooLarge, NotPermitted, PPaaSError
from tests.support.engine.fake_fabric import FakeFabric
from tests.support.engine.specs import (
    HOUSE,
    coordinator_spec,
    mapping_spec,
    planning_spec,
    robot_config,
    robot_spec,
    traffic_spec,
)


def test_oversized_or_unowned_messages_are_refused() -> None:
    fabric = FakeFabric()
    topics = FleetTopics(fabric)
    with pytest.raises(MessageTooLarge):
        topics.share(
            scope_of(robot_spec("c1", "ann", "tb1")), machine_link.FabricPublish("amcl_pose", bytes(MAX_SHARED + 1))
        )
    with pytest.raises(NotPermitted):
        topics.share(scope_of(planning_spec()), machine_link.FabricPublish("amcl_pose", b"here"))
    assert fabric.published == []


def test_the_state_of_people_may_be_larger_than_other_messages() -> None:
    fabric, scope = FakeFabric(), scope_of(coordinator_spec())
    topics = FleetTopics(fabric)
    topics.share(scope, machine_link.FabricPublish("people_coordinator/state", bytes(MAX_STATE)))
    with pytest.raises(MessageTooLarge):
        topics.share(scope, machine_link.FabricPublish("people_coordinator/state", bytes(MAX_STATE + 1)))
    assert [key for key, _ in fabric.published] == ["ppaas/map/house/ann/_coordinator/people_coordinator/state"]


def test_only_robots_with_nodes_for_people_on_published_maps_receive_the_state_of_people() -> None:
    state = "ppaas/map/house/ann/_coordinator/people_coordinator/state"
    poses = "ppaas/map/house/*/*/amcl_pose"
    detector = {"torso_detector": {}}
    spec = robot_spec("c1", "ann", "tb1")
    assert heard_by(spec) == [poses]
    seeing = msgspec.structs.replace(spec, robot=robot_config(parameters=detector))
    assert heard_by(seeing) == [poses, state]
    mapping = msgspec.structs.replace(mapping_spec(), robot=robot_config(parameters=detector, new_map="office-2"))
    assert state not in heard_by(mapping) and len(heard_by(mapping)) == 1
    assert heard_by(planning_spec()) == []


def test_only_robots_that_take_part_on_published_maps_receive_grants_and_only_their_own() -> None:
    takes_part = robot_config("tb1", parameters={"traffic": {}})
    spec = msgspec.structs.replace(robot_spec("c1", "ann", "tb1"), robot=takes_part)
    assert heard_by(spec)[1:] == ["ppaas/map/house/ann/_traffic/traffic/grants/tb1"]
    mapping = msgspec.structs.replace(mapping_spec(), robot=msgspec.structs.replace(takes_part, new_map="office-2"))
    assert len(heard_by(mapping)) == 1
    people = "ppaas/map/house/ann/_coordinator/people_coordinator/state"
    assert heard_by(traffic_spec()) == ["ppaas/map/house/ann/*/traffic/report", "ppaas/map/house/*/*/amcl_pose", people]


def test_only_traffic_nodes_address_robots() -> None:
    fabric = FakeFabric()
    topics, grants = FleetTopics(fabric), machine_link.FabricPublish("traffic/grants", b"{}", "tb1")
    for spec in (robot_spec("c1", "ann", "tb1"), coordinator_spec(), planning_spec()):
        with pytest.raises(NotPermitted):
            topics.share(scope_of(spec), grants)
    assert fabric.published == []
    topics.share(scope_of(traffic_spec()), grants)
    assert fabric.published == [("ppaas/map/house/ann/_traffic/traffic/grants/tb1", b"{}")]


@given(robot=st.text(min_size=1))
def test_any_addressee_is_one_part_of_a_key(robot: str) -> None:
    fabric = FakeFabric()
    try:
        FleetTopics(fabric).share(scope_of(traffic_spec()), machine_link.FabricPublish("traffic/grants", b"", robot))
    except UnicodeEncodeError:
        return  # half a character, which no frame carries
    [(key, _)] = fabric.published
    assert key.startswith("ppaas/map/house/ann/_traffic/traffic/grants/") and key.count("/") == 7


def test_a_robot_that_continues_a_map_shares_with_the_robots_on_it() -> None:
    spec = mapping_spec()
    assert spec.robot is not None
    robot = msgspec.structs.replace(spec.robot, continued=HOUSE)
    scope = scope_of(msgspec.structs.replace(spec, robot=robot))
    assert scope == scope_of(robot_spec("c1", "ann", "tb1"))


def test_robots_share_with_those_whose_maps_may_be_joined() -> None:
    own, other = scope_of(mapping_spec("m1", "ann", "tb1")), scope_of(mapping_spec("m2", "bob", "tb2"))
    spec = mapping_spec("m3", "bob", "tb3")
    assert own is not None and other is not None and spec.robot is not None
    robot = msgspec.structs.replace(spec.robot, map_owner="ann")
    guest = scope_of(msgspec.structs.replace(spec, robot=robot))
    assert guest is not None
    assert own.shared_pattern("amcl_pose") == guest.shared_pattern("amcl_pose") != other.shared_pattern("amcl_pose")
    assert guest.shared_key("amcl_pose") == "ppaas/map/new%3Aoffice-2%40ann/bob/tb3/amcl_pose"


@given(topic=st.text() | st.from_regex(r"[a-z~_/.*$%#?]{0,12}", fullmatch=True))
def test_any_topic_stays_below_its_robot_or_is_refused(topic: str) -> None:
    fabric = FakeFabric()
    scope = scope_of(robot_spec("c1", "ann", "tb1"))
    assert scope is not None
    try:
        key = scope.shared_key(topic)
    except PPaaSError:
        return
    fabric.publish(key, b"")  # Zenoh accepts it
    assert key.startswith("ppaas/map/house/ann/tb1/")
    assert parse_shared(key)[:3] == ("house", "ann", "tb1")
