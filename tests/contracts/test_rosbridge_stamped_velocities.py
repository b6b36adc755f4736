"""Velocities of clients that name ``cmd_vel`` as ``geometry_msgs/TwistStamped``, as bases and joysticks of Nav2 do.

Others of this kind: types that rosbridge clients of ROS 1 and ROS 2 name differently on one topic. Times, matrices of a
CameraInfo and arguments of GetParam are spelled by the type that the client names; see ``test_rosbridge_messages.py``.
"""

import json
from typing import Any

import pytest

from engine.links.place_link import PlaceLink
from ppaas.clock import epoch
from ppaas.errors import MalformedMessage
from ppaas.messages import decode
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Twist, TwistStamped, Vector3
from tests.support.endpoints.still_place import StillClient, StillPlace, answers, delivered, error_of, says

VELOCITY = {"linear": {"x": 0.25, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -0.5}}


@pytest.mark.parametrize("kind", ["geometry_msgs/TwistStamped", "geometry_msgs/msg/TwistStamped"])
@pytest.mark.parametrize("topic", ["/cmd_vel", "cmd_vel"])
async def test_a_client_that_names_stamped_velocities_gets_them_in_the_frame_of_the_base(
    client: StillClient, place: StillPlace, kind: str, topic: str
) -> None:
    place.base_frame = "robot1/base_footprint"
    assert says(client, op="subscribe", topic=topic, type=kind) == []
    place.publish_json("cmd_vel", VELOCITY)
    [frame] = client.received()
    assert (frame["op"], frame["topic"], frame["msg"]["twist"]) == ("publish", topic, VELOCITY)
    header = frame["msg"]["header"]
    assert header["frame_id"] == "robot1/base_footprint"
    seconds = "sec" if "/msg/" in kind else "secs"
    assert set(header["stamp"]) == {seconds, f"nano{seconds}" if "/msg/" in kind else f"n{seconds}"}
    assert header["stamp"][seconds] > 1_600_000_000


@pytest.mark.parametrize("fields", [{}, {"type": None}, {"type": "geometry_msgs/Twist"},
                                    {"type": "geometry_msgs/msg/Twist"}])  # fmt: skip
async def test_any_other_client_gets_plain_velocities(
    client: StillClient, place: StillPlace, fields: dict[str, Any]
) -> None:
    assert says(client, op="subscribe", topic="/cmd_vel", **fields) == []
    place.publish_json("cmd_vel", VELOCITY)
    assert client.received() == [{"op": "publish", "topic": "/cmd_vel", "msg": VELOCITY}]


async def test_clients_of_both_kinds_are_served_at_once(
    client: StillClient, other: StillClient, place: StillPlace
) -> None:
    client.say(op="subscribe", topic="/cmd_vel", type="geometry_msgs/msg/TwistStamped")
    other.say(op="subscribe", topic="/cmd_vel", type="geometry_msgs/msg/Twist")
    place.publish_json("cmd_vel", VELOCITY)
    assert [frame["msg"]["twist"] for frame in client.received()] == [VELOCITY]
    assert [frame["msg"] for frame in other.received()] == [VELOCITY]


async def test_queued_velocities_have_a_header_too(client: StillClient, place: StillPlace) -> None:
    kind = "geometry_msgs/TwistStamped"
    client.say(op="subscribe", topic="/cmd_vel", type=kind, throttle_rate=1, queue_length=3)
    for number in range(3):
        place.publish_json("cmd_vel", VELOCITY | {"linear": {"x": float(number)}})
    frames = await answers(client, 3)
    assert [frame["msg"]["twist"]["linear"]["x"] for frame in frames] == [0.0, 1.0, 2.0]


async def test_rosapi_names_the_type_of_the_clone(client: StillClient) -> None:
    [answer] = says(client, op="call_service", service="/rosapi/topic_type", args={"topic": "/cmd_vel"})
    assert answer["values"] == {"type": "geometry_msgs/Twist"}
    args = {"type": "geometry_msgs/TwistStamped"}
    [answer] = says(client, op="call_service", service="/rosapi/message_details", args=args)
    assert answer["values"]["typedefs"][0]["fieldnames"] == ["header", "twist"]


# -- velocities of clients ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["geometry_msgs/TwistStamped", "geometry_msgs/msg/TwistStamped",
                                  "geometry_msgs/Twist"])  # fmt: skip
async def test_a_joystick_may_advertise_either_type(other: StillClient, place: StillPlace, kind: str) -> None:
    assert says(other, op="advertise", topic="/cmd_vel", type=kind) == []
    assert says(other, op="publish", topic="/cmd_vel", msg={"twist": VELOCITY}) == []
    assert delivered(place) == [("cmd_vel", {"twist": VELOCITY})]


@pytest.mark.parametrize("header", [{}, {"header": {"frame_id": "base_link", "stamp": {"sec": 1, "nanosec": 2}}},
                                    {"header": {"stamp": {"secs": 1, "nsecs": 2}}}, {"header": None}])  # fmt: skip
def test_a_stamped_velocity_is_read_as_its_twist(header: dict[str, Any]) -> None:
    twist = decode(Twist, json.dumps({**header, "twist": VELOCITY}))
    assert twist == Twist(Vector3(x=0.25), Vector3(z=-0.5))
    assert decode(Twist, json.dumps({**header, "twist": {"linear": {"x": 1}}})) == Twist(Vector3(x=1.0))


def test_a_plain_velocity_is_read_as_a_stamped_one_without_a_frame() -> None:
    """A robot whose own Move Base drives it gets velocities from there, and not by the cloud."""
    assert decode(TwistStamped, json.dumps(VELOCITY)) == TwistStamped(Header(), Twist(Vector3(x=0.25), Vector3(z=-0.5)))
    with pytest.raises(MalformedMessage, match="not a TwistStamped"):
        decode(TwistStamped, json.dumps({"linear": {}, "speed": 1}))


@pytest.mark.parametrize("message", [{"twist": {"linear": {"x": None}}}, {"twist": {"speed": 1}}, {"twist": 1},
                                     {"twist": {}, "linear": {"x": 1}}, {"twist": {"twist": {}}}])  # fmt: skip
def test_what_is_neither_type_is_refused(message: dict[str, Any]) -> None:
    with pytest.raises(MalformedMessage, match="not a Twist"):
        decode(Twist, json.dumps(message))


# -- topics that are not the clone's -----------------------------------------------------------------------------------


async def test_topics_of_clients_have_one_type(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise", topic="/teleop", type="geometry_msgs/Twist")
    error_of(says(other, op="subscribe", topic="/teleop", type="geometry_msgs/TwistStamped"), "conflict")
    error_of(says(other, op="advertise", topic="/teleop", type="geometry_msgs/TwistStamped"), "conflict")


async def test_stamped_velocities_on_topics_of_clients_are_passed_as_they_are(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise", topic="/teleop", type="geometry_msgs/TwistStamped")
    other.say(op="subscribe", topic="/teleop", type="geometry_msgs/TwistStamped")
    header = {"seq": 7, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "base_link"}
    client.say(op="publish", topic="/teleop", msg={"header": header, "twist": VELOCITY})
    assert other.received() == [{"op": "publish", "topic": "/teleop", "msg": {"header": header, "twist": VELOCITY}}]


async def test_stamped_velocities_without_a_time_are_stamped_on_their_way_to_clients(
    client: StillClient, other: StillClient
) -> None:
    client.say(op="advertise", topic="/teleop", type="geometry_msgs/TwistStamped")
    other.say(op="subscribe", topic="/teleop", type="geometry_msgs/TwistStamped")
    before = int(epoch())
    client.say(op="publish", topic="/teleop", msg={"header": {}, "twist": VELOCITY})
    [frame] = other.received()
    header = frame["msg"]["header"]
    assert before <= header["stamp"].pop("secs") <= epoch() and 0 <= header["stamp"].pop("nsecs") < 10**9
    assert frame["msg"] == {"header": {"seq": 0, "stamp": {}, "frame_id": ""}, "twist": VELOCITY}


@pytest.mark.parametrize("kind", ["geometry_msgs/PoseStamped", "std_msgs/String", "geometry_msgs/TwistWithCovariance"])
async def test_other_types_are_refused_on_the_topic_of_velocities(client: StillClient, kind: str) -> None:
    error_of(says(client, op="subscribe", topic="/cmd_vel", type=kind), "conflict")
    error_of(says(client, op="advertise", topic="/cmd_vel", type=kind), "conflict")


def test_a_place_has_the_usual_frame_of_the_base_by_default() -> None:
    assert PlaceLink("robot:ann/tb1").base_frame == "base_link"
