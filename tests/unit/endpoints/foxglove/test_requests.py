"""Requests of a viewer: messages that it publishes, parameters, services, the graph."""

import json
import struct
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from endpoints.foxglove.viewer import MAX_WORK
from endpoints.resources.services import Services
from engine.protocols import robot_link
from ppaas.errors import PPaaSError
from ppaas.messages import encode, rosapi
from ppaas.wire.foxglove import requests
from ppaas.wire.ros import ros_types
from storage.sharing_records import Share
from tests.support.endpoints.fake_cloud import FakeCloud, container
from tests.support.endpoints.foxglove import StillViewer
from tests.support.endpoints.rapyuta import ClonePlace, StillSessions
from tests.support.endpoints.still_place import delivered
from tests.support.storage import records
from tests.support.waiting import until

POSE = "geometry_msgs/PoseStamped"
GOAL: dict[str, Any] = {
    "header": {"stamp": {"sec": 3, "nsec": 4}, "frame_id": "house"},
    "pose": {"position": {"x": 1.0, "y": 2.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
}


def _goal(place: ClonePlace) -> dict[str, Any]:
    [(topic, message)] = delivered(place)
    assert topic == "goal_pose"
    found: dict[str, Any] = message
    return found


@pytest.fixture(autouse=True)
def goal_topic(place: ClonePlace) -> None:
    place.topics["goal_pose"] = robot_link.TopicInfo("goal_pose", POSE, False)


# -- publishing --------------------------------------------------------------------------------------------------------


def _encoded(encoding: str) -> bytes:
    if encoding == "json":
        return json.dumps(GOAL).encode()
    values = GOAL | {"header": {"stamp": {"sec": 3, "nanosec": 4}, "frame_id": "house"}}
    return ros_types({"cdr": "jazzy", "ros1": "noetic"}[encoding]).encode(POSE, values)


@pytest.mark.parametrize("encoding", ["json", "cdr", "ros1"])
@pytest.mark.parametrize("topic", ["/tb1/goal_pose", "/goal_pose"])
async def test_a_goal_reaches_the_clone_in_each_encoding(
    viewer: StillViewer, place: ClonePlace, encoding: str, topic: str
) -> None:
    viewer.advertise(topic, "geometry_msgs/msg/PoseStamped" if encoding == "cdr" else POSE, encoding)
    viewer.publish(_encoded(encoding))
    goal = _goal(place)
    stamp = goal["header"]["stamp"]
    assert goal["header"]["frame_id"] == "map"
    assert (stamp.get("secs", stamp.get("sec")), stamp.get("nsecs", stamp.get("nanosec"))) == (3, 4)
    assert goal["pose"]["position"] == GOAL["pose"]["position"]
    assert not viewer.statuses


async def test_a_robot_may_come_after_its_goal_was_advertised(
    services: Services, sessions: StillSessions, token: str, cloud: FakeCloud, place: ClonePlace
) -> None:
    cloud.running = []
    viewer = StillViewer(services, sessions, token)
    await viewer.look()
    viewer.advertise("/tb1/goal_pose", POSE)
    assert viewer.statuses.pop().startswith("not-found: unknown robot at the beginning of '/tb1/goal_pose'")
    cloud.running = [container()]
    await viewer.look()
    viewer.publish(_encoded("json"))
    assert _goal(place)["pose"] == GOAL["pose"]
    viewer.say("unadvertise", channelIds=[1])
    viewer.publish(_encoded("json"))
    assert viewer.statuses == ["not-found: unknown advertised channel '1'"]


@pytest.mark.parametrize(
    ("described", "data", "why"),
    [
        (("/tb1/goal_pose", POSE, "protobuf"), b"", "messages in 'protobuf' are not read"),
        (("/tb1/goal_pose", "no type", "json"), b"", "not a ROS type name"),
        (("/tb1/goal_pose", "std_msgs/String", "json"), b"{}", "has type geometry_msgs/PoseStamped"),
        (("/tb1/scan", "sensor_msgs/LaserScan", "json"), b"{}", "only the robot itself may publish 'scan'"),
        (("/tb1/goal_pose", POSE, "json"), b"{", "not JSON"),
        (("/tb1/goal_pose", POSE, "json"), b"[" * 100_000, "not JSON"),
        (("/tb1/goal_pose", POSE, "cdr"), b"\0\1\0\0abc", "not a geometry_msgs/PoseStamped"),
        (("/tb1/goal_pose", POSE, "ros1"), b"\xff" * 64, "not a geometry_msgs/PoseStamped"),
        (
            ("/moon/goal_pose", POSE, "json"),
            b"{}",
            "unknown robot at the beginning of '/moon/goal_pose'; known: /tb1/moon/goal_pose",
        ),
    ],
)
async def test_other_messages_are_refused(
    viewer: StillViewer, place: ClonePlace, described: tuple[str, str, str], data: bytes, why: str
) -> None:
    viewer.advertise(*described)
    viewer.publish(data)
    assert why in " ".join(viewer.statuses)
    assert not delivered(place)


async def test_a_guest_who_may_look_publishes_nothing(
    services: Services, sessions: StillSessions, token: str, cloud: FakeCloud, place: ClonePlace
) -> None:
    await services.accounts.register("bob", "correct horse")
    services.store.put_robot(records.robot("tb1", user="bob", shares=(Share("ann", "look", (), ("*",)),)))
    cloud.running = [container(user="bob")]
    viewer = StillViewer(services, sessions, token)
    await viewer.look()
    viewer.advertise("/bob/tb1/goal_pose", POSE)
    viewer.publish(_encoded("json"))
    assert all("needs the role 'drive'" in status for status in viewer.statuses) and viewer.statuses
    assert not delivered(place)
    assert "/bob/tb1/make_plan" in viewer.services
    assert "/bob/tb1/rosapi/set_param" not in viewer.services


# -- parameters --------------------------------------------------------------------------------------------------------


@pytest.fixture
def parameters(place: ClonePlace) -> ClonePlace:
    """Let the clone answer with two parameters."""
    place.answers["rosapi/get_param"] = encode(
        rosapi.GetParamResponse('{"amcl": {"alpha": 2.0, "beams": 60}, "points": [1.0, 2.5]}')
    )
    return place


async def _values(viewer: StillViewer) -> list[dict[str, Any]]:
    def has_answered() -> bool:
        viewer.read()  # a status message may come before the answer
        return bool(viewer.answers)

    await until(has_answered)
    answer = viewer.answers.pop()
    assert answer["op"] == "parameterValues"
    found: list[dict[str, Any]] = answer["parameters"]
    return found


async def test_parameters_are_those_of_all_robots_by_their_names(viewer: StillViewer, parameters: ClonePlace) -> None:
    viewer.say("getParameters", parameterNames=[], id="one")
    assert await _values(viewer) == [
        {"name": "/tb1/amcl/alpha", "value": 2.0, "type": "float64"},
        {"name": "/tb1/amcl/beams", "value": 60},
        {"name": "/tb1/points", "value": [1.0, 2.5], "type": "float64_array"},
    ]
    viewer.say("getParameters", parameterNames=["/tb1/amcl/beams", "/tb1/none", "/tb9/none"])
    assert await _values(viewer) == [{"name": "/tb1/amcl/beams", "value": 60}]


async def test_parameters_are_set_and_removed(viewer: StillViewer, parameters: ClonePlace) -> None:
    written = [
        {"name": "/tb1/free/limit", "value": 2, "type": "float64"},
        {"name": "/tb1/free/list", "value": [1, "a"]},
    ]
    viewer.say("setParameters", parameters=written, id="set")
    await _values(viewer)
    assert parameters.tree.get("/free") == {"limit": 2.0, "list": [1, "a"]}
    viewer.say("setParameters", parameters=[{"name": "/tb1/free/limit"}, {"name": "/tb1/free/a b", "value": 1}])
    await _values(viewer)
    assert parameters.tree.get("/free") == {"list": [1, "a"]}
    [status] = viewer.statuses
    assert "invalid parameter name" in status


async def test_changes_of_watched_parameters_are_sent(viewer: StillViewer, parameters: ClonePlace) -> None:
    viewer.say("subscribeParameterUpdates", parameterNames=["/tb1/amcl/beams"])
    assert await _values(viewer) == [{"name": "/tb1/amcl/beams", "value": 60}]
    await viewer.look()
    assert not [answer for answer in viewer.answers if answer["op"] == "parameterValues"]
    parameters.answers["rosapi/get_param"] = encode(rosapi.GetParamResponse('{"amcl": {"beams": 30}}'))
    await viewer.look()
    assert viewer.answers.pop()["parameters"] == [{"name": "/tb1/amcl/beams", "value": 30}]
    parameters.answers["rosapi/get_param"] = encode(rosapi.GetParamResponse("{}"))
    await viewer.look()
    assert viewer.answers.pop()["parameters"] == [{"name": "/tb1/amcl/beams"}]
    called = len(parameters.called)
    viewer.say("unsubscribeParameterUpdates", parameterNames=["/tb1/amcl/beams"])
    await viewer.look()
    assert len(parameters.called) == called


async def test_few_parameters_are_watched_by_name(viewer: StillViewer) -> None:
    viewer.say("subscribeParameterUpdates", parameterNames=[f"/tb1/{number}" for number in range(1001)])
    assert viewer.statuses == [
        "quota-exceeded: at most 1000 parameters can be watched by name: watch all, without names"
    ]


async def test_few_requests_wait_at_once(viewer: StillViewer) -> None:
    for _ in range(100):
        viewer.say("getParameters", parameterNames=[])
    assert viewer.statuses[0].startswith("quota-exceeded: at most 16 requests")


# -- services, graph, files --------------------------------------------------------------------------------------------


async def test_services_are_called_with_json(viewer: StillViewer, parameters: ClonePlace) -> None:
    viewer.call("/tb1/rosapi/has_param", b'{"name": "/amcl/max_particles"}')
    await until(lambda: len(viewer.viewer.outbox) > 0)
    viewer.read()
    assert viewer.answers.pop() == {"op": "serviceCallResponse", "data": {"exists": True}}
    for name, encoding, why in (
        ("/tb1/rosapi/has_param", b"cdr", "calls are JSON"),
        ("/none", b"json", "unknown service"),
    ):
        viewer.call(name, b"{}", encoding)
        failure = viewer.answers.pop()
        assert (failure["op"], failure["callId"]) == ("serviceCallFailure", 9)
        assert why in failure["message"]


async def _answer(viewer: StillViewer) -> dict[str, Any]:
    """Wait for an answer to a call, and return it."""

    def has_come() -> bool:
        viewer.read()
        return bool(viewer.answers)

    await until(has_come)
    [answer] = viewer.answers
    viewer.answers.clear()
    return answer


NO_REQUESTS = [
    b"", b"{", b"[]", b"null", b"7", b'"{}"', b"{}{}", b'{}, "op": "publish"', b'{"name": "x"}, "op": "publish"}',
    b"\xff", b'{"name": "\xff"}', b"\x00", b"[" * 5000, b'{"a":' * 3000 + b"1" + b"}" * 3000,
    b'{"name": 1e}', b'{"name": NaN}',
]  # fmt: skip
"""Bytes that are no request in JSON."""


async def test_calls_that_are_no_json_fail_at_the_edge_and_free_their_slots(
    viewer: StillViewer, parameters: ClonePlace
) -> None:
    for _ in range(3):  # more than may wait
        for payload in NO_REQUESTS:
            viewer.call("/tb1/rosapi/has_param", payload)
            [failure] = viewer.answers
            viewer.answers.clear()
            assert (failure["op"], failure["callId"]) == ("serviceCallFailure", 9), payload[:40]
            assert failure["message"].startswith("malformed-message: not a request of rosapi/has_param"), failure
    assert parameters.called == [] and viewer.statuses == []
    viewer.call("/tb1/rosapi/has_param", b'{"name": "/amcl/max_particles"}')
    assert await _answer(viewer) == {"op": "serviceCallResponse", "data": {"exists": True}}


async def test_calls_of_another_form_than_their_type_fail_with_the_reason_of_the_clone(
    viewer: StillViewer, parameters: ClonePlace
) -> None:
    for _ in range(2 * MAX_WORK):
        viewer.call("/tb1/rosapi/set_param", b'{"name": 7}')
        failure = await _answer(viewer)
        assert (failure["op"], failure["callId"]) == ("serviceCallFailure", 9)
        assert "name" in failure["message"]


@pytest.mark.parametrize(("length", "encoding"), [(99, b"json"), (2, b"\xff\xfe")])
async def test_a_call_whose_head_cannot_be_read_fails_by_its_ids(
    viewer: StillViewer, length: int, encoding: bytes
) -> None:
    viewer.send(struct.pack("<BIII", 2, 5, 9, length) + encoding + b"{}")
    [failure] = viewer.answers
    assert (failure["op"], failure["serviceId"], failure["callId"]) == ("serviceCallFailure", 5, 9)


async def test_times_of_calls_have_the_spelling_of_the_clone(viewer: StillViewer, place: ClonePlace) -> None:
    place.answers["make_plan"] = b"{}"
    viewer.call("/tb1/make_plan", b'{"start": {"header": {"stamp": {"sec": 3, "nsec": 4}}}}')
    await _answer(viewer)
    [(_, request)] = place.called
    assert request["start"]["header"]["stamp"] == {"secs": 3, "nsecs": 4}


async def _waiting_calls(viewer: StillViewer, place: ClonePlace) -> None:
    """Begin as many calls as may wait, and one more, which the clone does not answer."""
    vars(place.far).pop("write", None)  # the one that lets the clone answer
    for _ in range(MAX_WORK + 1):
        viewer.call("/tb1/rosapi/has_param", b'{"name": "/a"}')
    assert "at most 16 requests" in (await _answer(viewer))["message"]
    await until(lambda: len(place.far.take(robot_link.ServiceCall)) == MAX_WORK)


async def test_calls_without_an_answer_fail_in_time_and_free_their_slots(
    viewer: StillViewer, parameters: ClonePlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("endpoints.place_client.PATIENCE", 0.05)
    await _waiting_calls(viewer, parameters)

    def have_failed() -> bool:
        viewer.read()
        return len(viewer.answers) == MAX_WORK

    await until(have_failed)
    assert {answer["op"] for answer in viewer.answers} == {"serviceCallFailure"}
    assert all("did not answer within" in answer["message"] for answer in viewer.answers)
    viewer.answers.clear()
    await _waiting_calls(viewer, parameters)


async def test_calls_fail_with_the_container_of_their_robot(
    viewer: StillViewer, parameters: ClonePlace, cloud: FakeCloud
) -> None:
    await _waiting_calls(viewer, parameters)
    cloud.running = []
    await viewer.look()
    failures = [answer for answer in viewer.answers if answer["op"] == "serviceCallFailure"]
    assert len(failures) == MAX_WORK
    assert all("the container was closed" in failure["message"] for failure in failures)


async def test_calls_of_a_viewer_that_leaves_do_not_wait_on(viewer: StillViewer, parameters: ClonePlace) -> None:
    await _waiting_calls(viewer, parameters)
    [view] = viewer.viewer.views.values()
    assert len(view.client._calls) == MAX_WORK
    await viewer.requests._work.cancel()
    assert len(view.client._calls) == 0


async def test_the_graph_is_sent_once_and_then_its_changes(
    viewer: StillViewer, place: ClonePlace, cloud: FakeCloud
) -> None:
    viewer.say("subscribeConnectionGraph")
    graph = viewer.answers.pop()
    assert graph["op"] == "connectionGraphUpdate"
    assert all(one["name"].startswith("/tb1/") for one in graph["publishedTopics"])
    await viewer.look()
    assert not viewer.answers
    cloud.running = []
    await viewer.look()
    gone = {one["name"] for one in graph["publishedTopics"]} <= set(viewer.answers[-1]["removedTopics"])
    assert gone
    viewer.say("unsubscribeConnectionGraph")


async def test_there_are_no_files(viewer: StillViewer) -> None:
    viewer.say("fetchAsset", uri="package://a/b.stl", requestId=3)
    assert not viewer.statuses


# -- any frames --------------------------------------------------------------------------------------------------------

NUMBERS = st.integers(0, 12) | st.integers(0, 2**32 - 1)
NAMES = st.sampled_from(
    ["/tb1/scan", "/tb1/goal_pose", "/goal_pose", "/tb1", "/", "", "/tb2/scan", "//", "/tb1/amcl/beams"]
)
TEXTS = NAMES | st.text(max_size=6)
KINDS = st.sampled_from([POSE, "geometry_msgs/msg/PoseStamped", "sensor_msgs/LaserScan", "no/Such", "", "a"])
ENCODINGS = st.sampled_from(["json", "cdr", "ros1", "protobuf", ""])
VALUES = st.none() | st.booleans() | st.integers() | st.text(max_size=4) | st.lists(st.floats(), max_size=2)
OPERATIONS = st.one_of(
    st.builds(
        lambda pairs: {"op": "subscribe", "subscriptions": [{"id": a, "channelId": b} for a, b in pairs]},
        st.lists(st.tuples(NUMBERS, NUMBERS), max_size=3),
    ),
    st.builds(lambda ids: {"op": "unsubscribe", "subscriptionIds": ids}, st.lists(NUMBERS, max_size=3)),
    st.builds(
        lambda i, t, e, k: {"op": "advertise", "channels": [{"id": i, "topic": t, "encoding": e, "schemaName": k}]},
        NUMBERS,
        TEXTS,
        ENCODINGS,
        KINDS,
    ),
    st.builds(lambda ids: {"op": "unadvertise", "channelIds": ids}, st.lists(NUMBERS, max_size=3)),
    st.builds(lambda names: {"op": "getParameters", "parameterNames": names}, st.lists(TEXTS, max_size=2)),
    st.builds(lambda n, v: {"op": "setParameters", "parameters": [{"name": n, "value": v}]}, TEXTS, VALUES),
    st.builds(
        lambda op, names: {"op": op, "parameterNames": names},
        st.sampled_from(["subscribeParameterUpdates", "unsubscribeParameterUpdates"]),
        st.lists(TEXTS, max_size=2),
    ),
    st.sampled_from([{"op": "subscribeConnectionGraph"}, {"op": "unsubscribeConnectionGraph"}, {"op": "other"}, {}]),
    st.builds(lambda uri: {"op": "fetchAsset", "uri": uri, "requestId": 1}, TEXTS),
)  # fmt: skip
BINARY = st.one_of(
    st.binary(max_size=40),
    st.builds(lambda i, data: struct.pack("<BI", 1, i) + data, NUMBERS, st.binary(max_size=80)),
    st.builds(lambda i, data: struct.pack("<BI", 1, i) + json.dumps(data).encode(), NUMBERS, st.just(GOAL)),
    st.builds(
        lambda s, c, e, data: struct.pack("<BIII", 2, s, c, len(e)) + e + data,
        NUMBERS, NUMBERS, st.sampled_from([b"json", b"cdr", b"\xff", b""]), st.binary(max_size=20),
    ),
)  # fmt: skip
FRAMES = st.lists(OPERATIONS.map(json.dumps) | BINARY | st.text(max_size=30), min_size=1, max_size=8)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(frames=FRAMES)
async def test_any_frames_are_executed_or_refused(viewer: StillViewer, frames: list[str | bytes]) -> None:
    """No frame raises anything but an error that the viewer is shown, and a good one works afterwards."""
    for frame in frames:
        viewer.requests.take(frame)
    viewer.read()
    assert not viewer.viewer.over.done() or isinstance(viewer.viewer.over.result(), PPaaSError)
    viewer.say("fetchAsset", uri="a", requestId=1)
    assert requests.read_request(b"\x01\0\0\0\0") == requests.MessageData(0, b"")
