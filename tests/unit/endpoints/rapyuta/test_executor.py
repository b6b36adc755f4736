"""Containers, nodes, parameters, interfaces and connections of robots of 2013."""

import asyncio
from typing import Any

import pytest

from endpoints.rapyuta.clone import MAX_NODES
from endpoints.rapyuta.executor import MAX_CONTAINERS
from endpoints.rapyuta.interfaces import MAX_INTERFACES
from endpoints.resources.services import Services
from engine.protocols import robot_link
from ppaas.errors import Idle, InvalidParameter, NotFound, QuotaExceeded, Unavailable
from tests.support.endpoints.rapyuta import ClonePlace, StillRobot, StillSessions, error_in
from tests.support.endpoints.still_place import delivered
from tests.support.waiting import until

STRING = "std_msgs/String"


def _node(pkg: str, exe: str, tag: str = "n1", **fields: str) -> dict[str, str]:
    return {"containerTag": "c1", "nodeTag": tag, "pkg": pkg, "exe": exe} | fields


def _parameters(services: Services) -> Any:
    return services.store.robot("ann", "tb1").parameters


@pytest.fixture
async def created(robot: StillRobot) -> StillRobot:
    """Return a robot with the container c1."""
    assert await robot.do("CC", containerTag="c1") == []
    return robot


# -- containers --------------------------------------------------------------------------------------------------------


async def test_the_containers_of_a_robot_share_its_clone(robot: StillRobot, sessions: StillSessions) -> None:
    assert await robot.do("CC", containerTag="c1", containerData={"size": 2, "group": "g"}) == []
    assert await robot.do("CC", containerTag="c2") == []
    assert sessions.opened == ["tb1"]
    assert [attachment.request.role for attachment in sessions.attached] == ["robot"]
    assert await robot.do("DC", containerTag="c1") == []
    assert sessions.attached
    assert await robot.do("DC", containerTag="c2") == []
    assert not sessions.attached


@pytest.mark.parametrize("tag", ["c1", "tb1", "tb2"])
async def test_robots_and_containers_share_one_name_space(created: StillRobot, other: StillRobot, tag: str) -> None:
    assert "ID is already used" in error_in(await created.do("CC", containerTag=tag))
    assert "ID is already used" in error_in(await other.do("CC", containerTag=tag))


async def test_an_invalid_tag_is_refused(robot: StillRobot, sessions: StillSessions) -> None:
    assert error_in(await robot.do("CC", containerTag="my-container")).startswith("Invalid Request: containerTag")
    assert not sessions.opened


async def test_a_robot_without_a_file_is_told_what_to_do(robot: StillRobot, sessions: StillSessions) -> None:
    sessions.refusals.append(NotFound("robot", "tb1"))
    assert "ppaas robot put tb1" in error_in(await robot.do("CC", containerTag="c1"))
    assert await robot.do("CC", containerTag="c1") == []


@pytest.mark.parametrize("error", [QuotaExceeded("two containers"), Unavailable("no machine")])
async def test_no_capacity_is_told_in_the_words_of_2013(
    robot: StillRobot, sessions: StillSessions, error: QuotaExceeded | Unavailable
) -> None:
    sessions.refusals.append(error)
    assert error_in(await robot.do("CC", containerTag="c1")).startswith("You seem to have run out of capacity: ")


async def test_a_robot_has_a_limited_number_of_containers(robot: StillRobot) -> None:
    for number in range(MAX_CONTAINERS):
        assert await robot.do("CC", containerTag=f"c{number}") == []
    assert "run out of capacity" in error_in(await robot.do("CC", containerTag="c99"))


async def test_only_its_robot_destroys_a_container(created: StillRobot, other: StillRobot) -> None:
    assert "another robot" in error_in(await other.do("DC", containerTag="c1"))
    assert "unknown endpoint" in error_in(await created.do("DC", containerTag="c7"))
    assert "is a robot" in error_in(await created.do("DC", containerTag="tb1"))


async def test_a_revoked_token_creates_no_container(robot: StillRobot, services: Services, token: str) -> None:
    await services.accounts.revoke("ann", token)
    assert "token" in error_in(await robot.do("CC", containerTag="c1"))
    assert robot.robot.over.done()


async def test_containers_end_with_their_place(created: StillRobot, place: ClonePlace, sessions: StillSessions) -> None:
    await created.joined("in", "Subscriber", STRING, "/goal")
    sessions.link.close(Idle("no frames for 600 s"))
    await until(lambda: not sessions.attached)
    kinds = {message["type"]: message["data"] for message in created.received()}
    assert kinds["ST"] == {"topic": "iu", "iTag": "in", "status": False}
    assert "no frames for 600 s" in kinds["ER"]
    sessions.place = ClonePlace()
    assert await created.do("CC", containerTag="c1") == []


async def test_a_message_that_is_none_is_an_error(robot: StillRobot) -> None:
    await robot.executor.execute({"type": "XX", "data": {}})
    assert error_in(robot.received()).startswith("Invalid Request: This message type is not supported")


# -- nodes -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("pkg", "exe"), [("amcl", "amcl"), ("move_base", "move_base"), ("map_server", "map_server")])
async def test_nodes_of_the_clone_are_found_by_package_and_executable(created: StillRobot, pkg: str, exe: str) -> None:
    assert await created.do("CN", addNodes=[_node(pkg, exe, args="office.yaml")]) == []
    assert "twice" in error_in(await created.do("CN", addNodes=[_node(pkg, exe)]))
    assert await created.do("CN", removeNodes=[{"containerTag": "c1", "nodeTag": "n1"}]) == []
    assert "unknown node" in error_in(await created.do("CN", removeNodes=[{"containerTag": "c1", "nodeTag": "n1"}]))


@pytest.mark.parametrize(("pkg", "exe"), [("my_pkg", "posRecorder.py"), ("gmapping", "slam_gmapping")])
async def test_unknown_nodes_are_refused_with_those_that_exist(created: StillRobot, pkg: str, exe: str) -> None:
    text = error_in(await created.do("CN", addNodes=[_node(pkg, exe)]))
    assert f"unknown node '{pkg} {exe}'" in text
    assert "amcl amcl" in text and "move_base move_base" in text and "posRecorder" not in text.split("known:")[1]


async def test_a_node_on_request_is_written_into_the_file_and_the_clone_starts_again(
    created: StillRobot, services: Services, sessions: StillSessions
) -> None:
    sessions.place = ClonePlace({"depthimage_to_laserscan": {}})
    assert await created.do("CN", addNodes=[_node("depthimage_to_laserscan", "depthimage_to_laserscan")]) == []
    assert _parameters(services) == {"depthimage_to_laserscan": {}}
    assert sessions.opened == ["tb1", "tb1"]
    assert await created.do("CN", addNodes=[_node("depthimage_to_laserscan", "depthimage_to_laserscan", "n2")]) == []
    assert len(sessions.opened) == 2


async def test_names_and_arguments_of_nodes_count_in_addresses_and_parameters(
    created: StillRobot, services: Services, place: ClonePlace
) -> None:
    node = _node("amcl", "amcl", args="scan:=base_scan _max_particles:=900", name="localization", namespace="robot1")
    assert await created.do("CN", addNodes=[node]) == []
    assert _parameters(services) == {"amcl": {"max_particles": 900}}
    setting = {"containerTag": "c1", "name": "/robot1/localization/min_particles", "value": 50}
    assert await created.do("CN", setParam=[setting]) == []
    assert _parameters(services) == {"amcl": {"max_particles": 900, "min_particles": 50}}
    await created.joined("scan", "Subscriber", "sensor_msgs/LaserScan", "/robot1/base_scan")
    await created.send("scan", "sensor_msgs/LaserScan", {"ranges": []})
    assert delivered(place)[0][0] == "scan"


async def test_a_container_has_a_limited_number_of_nodes(created: StillRobot) -> None:
    many = [_node("amcl", "amcl", f"n{number}") for number in range(MAX_NODES + 1)]
    assert "at most" in error_in(await created.do("CN", addNodes=many))


async def test_open_quotations_in_arguments_are_refused(created: StillRobot) -> None:
    assert "can not be read" in error_in(await created.do("CN", addNodes=[_node("amcl", "amcl", args='"a')]))


# -- parameters --------------------------------------------------------------------------------------------------------


def _setting(name: str, value: Any) -> dict[str, Any]:
    return {"containerTag": "c1", "name": name, "value": value}


async def test_free_parameters_are_set_in_the_clone(
    created: StillRobot, place: ClonePlace, sessions: StillSessions
) -> None:
    assert await created.do("CN", setParam=[_setting("/battery/limits", [10.5, 12.6])]) == []
    assert place.tree.get("/battery/limits") == [10.5, 12.6]
    assert await created.do("CN", deleteParam=[{"containerTag": "c1", "name": "battery/limits"}]) == []
    assert not place.tree.has("/battery/limits")
    assert sessions.opened == ["tb1"]


async def test_parameters_of_nodes_are_written_into_the_file_once(
    created: StillRobot, services: Services, sessions: StillSessions
) -> None:
    sessions.place = ClonePlace({"amcl": {"max_particles": 700}, "DWAPlannerROS": {"max_vel_x": 0.3}})
    many = [_setting("/amcl/max_particles", 700), _setting("/move_base/DWAPlannerROS/max_vel_x", 0.3)]
    assert await created.do("CN", setParam=many) == []
    assert _parameters(services) == {"amcl": {"max_particles": 700}, "DWAPlannerROS": {"max_vel_x": 0.3}}
    assert sessions.opened == ["tb1", "tb1"]
    assert await created.do("CN", setParam=many) == []  # as each start of the robot does
    assert sessions.opened == ["tb1", "tb1"]
    deleted = [{"containerTag": "c1", "name": "/amcl/max_particles"}]
    assert await created.do("CN", deleteParam=deleted) == []
    assert _parameters(services)["amcl"] == {}
    assert "read only" in error_in(await created.do("CN", setParam=[_setting("/amcl", 1)]))
    assert "unknown parameter" in error_in(await created.do("CN", deleteParam=deleted))


@pytest.mark.parametrize(
    ("name", "value"), [("/amcl/odom_topic", "x"), ("/amcl", 5), ("", 1), ("/a b", 1), ("/a", "x" * 40_000)]
)
async def test_other_parameters_are_refused(
    created: StillRobot, services: Services, sessions: StillSessions, name: str, value: Any
) -> None:
    assert error_in(await created.do("CN", setParam=[_setting(name, value)])).startswith("Invalid Request: ")
    assert _parameters(services) == {}
    assert sessions.opened == ["tb1"]


async def test_a_value_with_which_the_clone_does_not_start_is_taken_back(
    created: StillRobot, services: Services, sessions: StillSessions, place: ClonePlace
) -> None:
    await created.joined("in", "Subscriber", STRING, "/goal")
    sessions.refusals.append(InvalidParameter("max_particles must be a whole number"))
    text = error_in(await created.do("CN", setParam=[_setting("/amcl/max_particles", "many")]))
    assert text == "Invalid Request: max_particles must be a whole number"
    assert _parameters(services) == {}
    await created.send("in", STRING, {"data": "still there"})
    assert delivered(place) == [("goal", {"data": "still there"})]


async def test_a_clone_that_does_not_start_again_is_lost(
    created: StillRobot, services: Services, sessions: StillSessions
) -> None:
    sessions.refusals += [Unavailable("no machine"), Unavailable("no machine")]
    messages = await created.do("CN", setParam=[_setting("/amcl/max_particles", 500)])
    assert ["closed" in message["data"] for message in messages] == [True, False]
    assert _parameters(services) == {}
    assert "unknown endpoint" in error_in(await created.do("DC", containerTag="c1"))
    assert await created.do("CC", containerTag="c1") == []


# -- interfaces and connections ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("interface", "text"),
    [
        (("c1", "a", "PublisherConverter", STRING, "/goal"), "type of interfaces on robots"),
        (("tb1", "a", "PublisherInterface", STRING, ""), "type of interfaces in containers"),
        (("c1", "a", "ServiceInterface", STRING, "/goal"), "is invalid"),
        (("c1", "a-b", "PublisherInterface", STRING, "/goal"), "interfaceTag"),
        (("c1", "a", "PublisherInterface", STRING, ""), "addr"),
        (("c1", "a", "PublisherInterface", "String", "/goal"), "type name"),
        (("c1", "a", "PublisherInterface", "std_msgs/Bool", "/goal"), "has type std_msgs/String"),
        (("c1", "a", "SubscriberInterface", "std_msgs/Bool", "/goal"), "has type std_msgs/String"),
        (("c1", "a", "ServiceClientInterface", "nav_msgs/GetMap", "/make_plan"), "has type nav_msgs/GetPlan"),
        (("c1", "a", "ServiceProviderInterface", "nav_msgs/GetPlan", "/make_plan"), "provided by the clone"),
        (("c1", "a", "PublisherInterface", STRING, "/a b"), "graph name"),
        (("c9", "a", "PublisherInterface", STRING, "/goal"), "unknown endpoint"),
        (("tb2", "a", "PublisherConverter", STRING, ""), "another robot"),
        (("tb1", "a", "PublisherForwarder", "my_msgs/Lamp", ""), "use a converter"),
    ],
)
async def test_invalid_interfaces_are_refused(
    created: StillRobot, other: StillRobot, interface: tuple[str, ...], text: str
) -> None:
    assert text in error_in(await created.add(*interface))
    assert not created.robot.interfaces
    assert "unknown" in error_in(await created.do("CX", connect=[{"tagA": f"{interface[0]}/a", "tagB": "c1/b"}]))


async def test_tags_of_interfaces_are_unique_in_their_endpoint_and_limited(created: StillRobot) -> None:
    for number in range(MAX_INTERFACES):
        assert await created.add("tb1", f"i{number}", "PublisherConverter", STRING) == []
    assert "at most" in error_in(await created.add("tb1", "more", "PublisherConverter", STRING))
    assert "twice" in error_in(await created.add("tb1", "i0", "PublisherConverter", STRING))


async def test_connections_are_checked(created: StillRobot) -> None:
    await created.joined("in", "Subscriber", STRING, "/goal")
    pair = {"tagA": "c1/in", "tagB": "tb1/in"}
    assert "connected already" in error_in(await created.do("CX", connect=[pair]))
    await created.add("tb1", "out", "PublisherConverter", STRING)
    await created.add("tb1", "flag", "SubscriberConverter", "std_msgs/Bool")
    assert "needs" in error_in(await created.do("CX", connect=[{"tagA": "c1/in", "tagB": "tb1/out"}]))
    assert "different classes" in error_in(await created.do("CX", connect=[{"tagA": "c1/in", "tagB": "tb1/flag"}]))
    assert "ENDPOINT/INTERFACE" in error_in(await created.do("CX", connect=[{"tagA": "in", "tagB": "tb1/out"}]))
    assert "unknown connection" in error_in(await created.do("CX", disconnect=[{"tagA": "c1/in", "tagB": "tb1/out"}]))
    [status] = await created.do("CX", disconnect=[pair])
    assert status["data"] == {"topic": "iu", "iTag": "in", "status": False}


async def test_one_item_of_several_that_is_wrong_harms_no_other(created: StillRobot) -> None:
    good = {"endpointTag": "tb1", "interfaceType": "SubscriberConverter", "className": STRING}
    items = [good | {"interfaceTag": tag} for tag in ("a", "1b", "c")]
    assert "1b" in error_in(await created.do("CN", addInterfaces=items))
    assert set(created.robot.interfaces) == {"a", "c"}


async def test_removed_interfaces_are_disconnected(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("out", "Publisher", "geometry_msgs/Twist", "/cmd_vel")
    assert "cmd_vel" in place.heard()
    [status] = await created.do("CN", removeInterfaces=[{"endpointTag": "c1", "interfaceTag": "out"}])
    assert status["data"]["status"] is False
    assert "cmd_vel" not in place.heard()
    removed = [{"endpointTag": "c1", "interfaceTag": "out"}]
    assert "unknown interface" in error_in(await created.do("CN", removeInterfaces=removed))


async def test_containers_do_not_pass_messages_in_a_circle(created: StillRobot) -> None:
    await created.do("CC", containerTag="c2")
    for tag, kind, container, topic in (
        ("s", "Subscriber", "c1", "/one"), ("p", "Publisher", "c2", "/two"),
        ("s", "Subscriber", "c2", "/two"), ("p", "Publisher", "c1", "/one"), ("same", "Publisher", "c1", "/one"),
    ):  # fmt: skip
        assert await created.add(container, tag, f"{kind}Interface", STRING, topic) == []
    assert "again and again" in error_in(await created.do("CX", connect=[{"tagA": "c1/s", "tagB": "c1/same"}]))
    assert await created.do("CX", connect=[{"tagA": "c1/s", "tagB": "c2/p"}]) == []
    assert "again and again" in error_in(await created.do("CX", connect=[{"tagA": "c2/s", "tagB": "c1/p"}]))


async def test_a_topic_of_a_closed_container_takes_no_messages(created: StillRobot, place: ClonePlace) -> None:
    await created.joined("in", "Subscriber", STRING, "/goal")
    [status] = await created.do("DC", containerTag="c1")
    assert status["data"]["status"] is False
    assert await created.send("in", STRING, {"data": "x"}) == []
    await asyncio.sleep(0)
    assert place.far.take(robot_link.Deliver) == []
