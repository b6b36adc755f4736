"""A fault in the session of one client: it ends that session alone, and is logged once."""

import logging
from typing import NoReturn

import pytest

from engine.links.place_link import PlaceLink
from engine.protocols import robot_link
from engine.sessions.goals import ClientGoals
from engine.sessions.session import ClientSession
from ppaas.errors import PPaaSError
from ppaas.wire.rosbridge import RosbridgeSession
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, says
from tests.unit.engine.sessions.test_host import Client, Container

CHATTER = {"topic": "chatter", "type": "my_msgs/Chat"}
MOVE = {
    "op": "send_action_goal", "action": "move_base", "action_type": "move_base_msgs/MoveBase", "id": "g1",
    "args": {"target_pose": POSE},
}  # fmt: skip


def fail(*_: object, **__: object) -> NoReturn:
    raise RuntimeError("a fault of the session")


def reason_of(session: ClientSession) -> str:
    return str(session.over.result()) if session.over.done() else ""


def errors(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]


async def test_a_session_that_cannot_take_a_message_ends_and_all_others_get_it(
    place: StillPlace, client: StillClient, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, faulty, after = (StillClient(place, "operator") for _ in range(3))
    client.say(op="advertise", **CHATTER)
    for each in (before, faulty, after):
        each.say(op="subscribe", topic="chatter")
    monkeypatch.setattr(faulty.session._wire, "publish", fail)
    for number in range(3):
        assert says(client, op="publish", topic="chatter", msg={"n": number}) == []
    for each in (before, after):
        assert [frame["msg"]["n"] for frame in each.received()] == [0, 1, 2]
        assert not each.session.over.done()
    assert not client.session.over.done()
    assert reason_of(faulty.session) == "internal error: RuntimeError"
    assert len(errors(caplog)) == 1


async def test_a_goal_tracker_that_fails_ends_its_session_alone(
    place: StillPlace, monkeypatch: pytest.MonkeyPatch
) -> None:
    faulty, other = StillClient(place, "operator"), StillClient(place, "operator")
    for each in (faulty, other):
        assert says(each, **MOVE) == []
        each.say(op="subscribe", topic="move_base/status")
    monkeypatch.setattr(faulty.session._goals, "published", fail)
    place.publish_json("move_base/status", {"status_list": []})
    assert reason_of(faulty.session) == "internal error: RuntimeError"
    assert [frame["op"] for frame in faulty.received()] == ["publish"]
    assert [frame["op"] for frame in other.received()] == ["publish"] and not other.session.over.done()


@pytest.mark.parametrize("what", ["refused", "acknowledged"])
async def test_a_session_that_cannot_take_a_notice_ends_alone(
    place: StillPlace, client: StillClient, other: StillClient, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    monkeypatch.setattr(ClientGoals, "refused", fail)
    monkeypatch.setattr(client.session.unsettled, "acknowledged", fail)
    if what == "acknowledged":
        place.say(robot_link.Ack(1))
    else:
        place._refused(client.session._client, "goal", PPaaSError("no"), 1)
    assert reason_of(client.session) == "internal error: RuntimeError"
    assert not other.session.over.done()


async def test_a_client_whose_service_or_action_fails_answers_the_caller_and_not_the_end_of_its_session(
    place: StillPlace, client: StillClient, other: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    other.say(op="advertise_service", service="lights", type="my_msgs/Lights")
    other.say(op="advertise_action", action="dance", type="my_msgs/Dance")
    monkeypatch.setattr(other.session._calls, "request", fail)
    monkeypatch.setattr(other.session._actions, "_send", fail)
    [answer] = says(client, op="call_service", service="lights", id="c")
    assert (answer["result"], answer["values"]) == (False, "the client that offers service 'lights' failed")
    [end] = says(client, op="send_action_goal", action="dance", action_type="my_msgs/Dance", id="g")
    assert end["result"] is False and "the client that offers action 'dance' failed" in end["values"]
    assert place.client_actions.goals == 0 and not client.session.over.done()


async def test_a_caller_that_cannot_take_the_response_does_not_end_the_client_that_responds(
    client: StillClient, other: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    other.say(op="advertise_service", service="lights", type="my_msgs/Lights")
    client.say(op="call_service", service="lights", id="c")
    [request] = other.received()
    monkeypatch.setattr(RosbridgeSession, "answer", fail)
    assert says(other, op="service_response", service="lights", id=request["id"], result=True, values={}) == []
    assert not other.session.over.done()


async def test_a_socket_that_cannot_be_written_ends_its_session_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    container, link = Container(), PlaceLink("robot:ann/tb1")
    container.connect(link)
    faulty, other = Client(link, "faulty"), Client(link, "other")
    for each in (faulty, other):
        each.say({"op": "subscribe", "topic": "goal"})
    monkeypatch.setattr(faulty, "send_frame", fail)
    for number in range(2):
        container.place.publish_json("goal", {"n": number})
    assert str(faulty.session.over.result()) == "internal error: RuntimeError"
    assert [frame["msg"]["n"] for frame in other.received()] == [0, 1] and not other.session.over.done()


async def test_a_session_that_fails_at_the_next_container_does_not_keep_the_others_from_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    container, link = Container(), PlaceLink("robot:ann/tb1")
    container.connect(link)
    faulty, other = Client(link, "faulty"), Client(link, "other")
    monkeypatch.setattr(faulty.session, "attach", fail)
    link.begin(robot_link.Hello("c2", "", 1, 0, [], [], []), link._stream)  # type: ignore[arg-type]
    assert str(faulty.session.over.result()) == "internal error: RuntimeError"
    other.say({"op": "subscribe", "topic": "goal"})
    container.place.publish_json("goal", {})
    assert [frame["op"] for frame in other.received()] == ["publish"]


async def test_a_session_that_cannot_begin_is_refused_and_its_endpoint_keeps_its_link(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    container, link = Container(), PlaceLink("robot:ann/tb1")
    container.connect(link)
    other = Client(link, "other")
    with monkeypatch.context() as patch:
        patch.setattr(container.host, "_begin", fail)
        faulty = Client(link, "faulty")
    assert str(faulty.session.over.result()) == "internal error: RuntimeError"
    other.say({"op": "subscribe", "topic": "goal"})
    container.place.publish_json("goal", {})
    assert [frame["op"] for frame in other.received()] == ["publish"]
