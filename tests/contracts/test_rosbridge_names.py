"""Names of topics, services and actions as clients of rosbridge spell them.

Members of the kind "a robot whose nodes run below a namespace": its topics, services and actions, those that its
clients offer, the names in requests of rosapi, and private and relative names. What a client gets is named as it named
it.
"""

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from engine.protocols import robot_link
from engine.sessions.namespaces import RESERVED, parse_namespace, scope_of
from ppaas.errors import InvalidParameter
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, answers, delivered, error_of, says

GOAL = {"op": "send_action_goal", "action_type": "nav2_msgs/action/NavigateToPose", "args": {"pose": POSE}, "id": "g"}

Join = Callable[..., StillClient]


@pytest.fixture
def join(place: StillPlace) -> Iterator[Join]:
    """Return a function that adds a client of a robot at the place."""
    made: list[StillClient] = []

    def add(robot: str = "tb3_1", namespace: str | None = None, role: Any = "robot") -> StillClient:
        made.append(StillClient(place, role, names=scope_of(robot, namespace)))
        return made[-1]

    yield add
    for client in made:
        client.session.end()


NAMESPACES = [("tb3_1", None), ("tb3-1", None), ("tb3.1", None), ("r2d2", "tb3_1"), ("r2d2", "/tb3_1/"), ("-", "tb3_1")]


@pytest.mark.parametrize(("robot", "namespace"), NAMESPACES)
@pytest.mark.parametrize("spelling", ["/tb3_1/goal", "tb3_1/goal", "/goal", "goal"])
async def test_names_below_the_namespace_of_the_robot_are_those_of_the_clone(
    join: Join, place: StillPlace, robot: str, namespace: str | None, spelling: str
) -> None:
    client = join(robot, namespace if namespace is None else parse_namespace(namespace))
    assert says(client, op="publish", topic=spelling, msg={"data": "x"}) == []
    assert delivered(place) == [("goal", {"data": "x"})]
    client.say(op="subscribe", topic=spelling)
    place.publish_json("goal", {"n": 1})
    assert client.received() == [{"op": "publish", "topic": spelling, "msg": {"n": 1}}]
    client.say(op="unsubscribe", topic="/tb3_1/goal")
    place.publish_json("goal", {"n": 2})
    assert client.received() == []


async def test_a_namespace_may_have_parts(join: Join, place: StillPlace) -> None:
    client = join("tb1", "fleet/tb3_1")
    client.say(op="publish", topic="/fleet/tb3_1/goal", msg={})
    client.say(op="publish", topic="/tb1/goal", msg={})
    assert [topic for topic, _ in delivered(place)] == ["goal", "goal"]


async def test_services_below_the_namespace_are_those_of_the_clone(join: Join, place: StillPlace) -> None:
    client = join()
    client.say(op="call_service", service="/tb3_1/make_plan", id=1)
    [call] = place.far.take(robot_link.ServiceCall)
    assert call.service == "make_plan"
    place.say(robot_link.ServiceAnswer(call.call, b'{"plan":{}}'))
    [answer] = await answers(client)
    assert (answer["service"], answer["id"], answer["result"]) == ("/tb3_1/make_plan", 1, True)
    [answer] = says(client, op="call_service", service="/tb3_1/rosapi/topic_type", args={"topic": "/tb3_1/map"})
    assert answer["values"] == {"type": "nav_msgs/OccupancyGrid"}


@pytest.mark.parametrize(
    ("name", "bare"),
    [
        ("/tb3_1/move_base/x", "move_base/x"), ("/tb3_1/move_base:x", "move_base:x"), ("tb3_1/x", "x"),
        ("/move_base/x", "/move_base/x"), ("/tb3_12/x", "/tb3_12/x"), ("a b", "a b"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("service", ["get_param", "set_param", "has_param", "delete_param", "search_param"])
async def test_parameters_below_the_namespace_are_those_of_the_clone(
    join: Join, place: StillPlace, service: str, name: str, bare: str
) -> None:
    client = join()
    client.say(op="call_service", service=f"/rosapi/{service}", args={"name": name, "value": "1"})
    [call] = place.far.take(robot_link.ServiceCall)
    assert json.loads(call.payload) == {"name": bare, "value": "1"}


@pytest.mark.parametrize("arguments", [{}, {"name": 7}, {"name": None}, []])
async def test_requests_that_name_no_parameter_come_to_the_clone_as_they_are(
    join: Join, place: StillPlace, arguments: Any
) -> None:
    join().say(op="call_service", service="/rosapi/get_param", args=arguments)
    [call] = place.far.take(robot_link.ServiceCall)
    assert json.loads(call.payload) == (arguments or {})


async def test_actions_below_the_namespace_are_those_of_the_clone(join: Join, place: StillPlace) -> None:
    client = join()
    client.say(**GOAL, action="/tb3_1/navigate_to_pose", feedback=True)
    [(topic, message)] = delivered(place)
    assert topic == "move_base/goal"
    status = {"goal_id": message["goal_id"], "status": 3}
    place.publish_json("move_base/result", {"status": status, "result": {}})
    [result] = client.received()
    assert (result["action"], result["status"]) == ("/tb3_1/navigate_to_pose", 4)
    client.say(op="call_service", service="/tb3_1/navigate_to_pose/_action/cancel_goal")
    assert [topic for topic, _ in delivered(place)] == ["move_base/cancel"]


async def test_what_clients_offer_below_the_namespace_is_found_without_it(join: Join) -> None:
    robot, operator = join(), join("r2d2", role="operator")
    robot.say(op="advertise", topic="/tb3_1/chatter", type="std_msgs/String")
    robot.say(op="advertise_service", service="/tb3_1/lights", type="std_srvs/SetBool")
    operator.say(op="subscribe", topic="/chatter")
    robot.say(op="publish", topic="/tb3_1/chatter", msg={"data": "x"})
    assert operator.received() == [{"op": "publish", "topic": "/chatter", "msg": {"data": "x"}}]
    operator.say(op="call_service", service="/lights", id=1)
    [call] = robot.received()
    assert call["service"] == "/tb3_1/lights"
    robot.say(op="service_response", service="/tb3_1/lights", id=call["id"], result=True)
    assert (await answers(operator))[0]["result"] is True
    assert says(robot, op="unadvertise_service", service="/lights") == []


async def test_an_operator_may_publish_no_sensor_data_below_the_namespace_either(join: Join, place: StillPlace) -> None:
    operator = join(role="operator")
    error_of(says(operator, op="publish", topic="/tb3_1/scan", msg={}), "not-permitted")
    error_of(says(operator, op="advertise", topic="tb3_1/odom", type="nav_msgs/Odometry"), "not-permitted")
    assert delivered(place) == []


@pytest.mark.parametrize(
    "frame",
    [
        {"op": "publish", "topic": "/tb3_2/goal"},
        {"op": "subscribe", "topic": "/tb3_2/goal"},
        {"op": "call_service", "service": "/tb3_2/make_plan"},
        {"op": "call_service", "service": "tb3_2/rosapi/topics"},
        GOAL | {"action": "/tb3_2/navigate_to_pose"},
    ],
)
async def test_names_below_another_namespace_are_unknown_and_the_answer_says_what_to_do(
    join: Join, place: StillPlace, frame: dict[str, Any]
) -> None:
    [answer] = says(join(), **frame)
    assert "add '&namespace=tb3_2' to the address" in (answer.get("msg") or answer["values"])
    assert delivered(place) == []


@pytest.mark.parametrize("name", ["/tb3_1", "/tb3_12/goal", "/x/tb3_1/goal", "/tb3_2/nothing"])
async def test_other_names_only_look_like_those_below_the_namespace(join: Join, place: StillPlace, name: str) -> None:
    error_of(says(join(), op="publish", topic=name, msg={}), "not-found")
    assert delivered(place) == []


@pytest.mark.parametrize("robot", sorted(RESERVED))
async def test_a_robot_with_the_name_of_a_part_of_the_clone_has_no_namespace_by_that(
    join: Join, place: StillPlace, robot: str
) -> None:
    client = join(robot)
    error_of(says(client, op="publish", topic=f"/{robot}/nothing", msg={}), "not-found")
    client.say(op="publish", topic="/move_base/goal", msg={})
    assert [topic for topic, _ in delivered(place)] == ["move_base/goal"]


@pytest.mark.parametrize("text", ["", "/", "a b", "1", "a//b", "ä", "move_base", "/rosapi/", "x" * 300, "a/*"])
def test_a_namespace_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(InvalidParameter, match="namespace"):
        parse_namespace(text)


@pytest.mark.parametrize("private", ["~chatter", "~/chatter"])
async def test_private_names_are_below_the_node_of_the_clients(join: Join, private: str) -> None:
    client, other = join(), join(role="operator")
    client.say(op="advertise", topic=private, type="std_msgs/String")
    other.say(op="subscribe", topic="/rosbridge_websocket/chatter")
    client.say(op="publish", topic=private, msg={"data": "x"})
    assert json.dumps(other.received()).count("/rosbridge_websocket/chatter") == 1


@pytest.mark.parametrize("name", ["~", "/~", "~~a", "a/~b", "a/~/b", "/~a", "/", "//a", "a/", "1a"])
async def test_names_that_ros_does_not_have_are_refused(join: Join, name: str) -> None:
    error_of(says(join(), op="subscribe", topic=name))


async def test_hidden_names_of_ros_2_are_names(join: Join, place: StillPlace) -> None:
    error_of(says(join(), op="publish", topic="/_hidden", msg={}), "not-found")
