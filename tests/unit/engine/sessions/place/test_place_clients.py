"""Topics and services that the clients of a place advertise to each other; what one of them does concerns no other."""

import asyncio
import json
import logging

import pytest

from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from engine.sessions.place.place import Place
from ppaas.errors import Conflict, NotFound, NotPermitted, PPaaSError, Unavailable
from tests.support.endpoints.still_place import StillPlace
from tests.support.engine.place_peers import RecordingClient
from tests.support.waiting import until


@pytest.fixture
def place() -> StillPlace:
    return StillPlace()


async def test_subscription_before_the_advertisement_gets_the_messages(place: StillPlace) -> None:
    listener = RecordingClient()
    subscriber, publisher = place.join(listener), place.join(RecordingClient())
    place.hear("chatter", subscriber, "std_msgs/String")
    assert place.topic_type("chatter") is None
    with pytest.raises(NotFound, match="known: cmd_vel, goal, map"):
        place.publish("chatter", b"{}", publisher, must_arrive=True)
    place.advertise("chatter", "std_msgs/String", publisher, "1", latch=False)
    place.publish("chatter", b'{"data":"hi"}', publisher, must_arrive=True)
    assert listener.heard == [("chatter", b'{"data":"hi"}')]
    place.leave(publisher)
    assert place.topic_type("chatter") is None


async def test_topic_of_the_clone_keeps_its_type_and_recipient(place: StillPlace) -> None:
    client = place.join(RecordingClient())
    with pytest.raises(Conflict, match="has type std_msgs/String"):
        place.advertise("goal", "std_msgs/Bool", client, None, latch=False)
    with pytest.raises(Conflict, match="has type nav_msgs/OccupancyGrid"):
        place.hear("map", client, "std_msgs/String")
    place.advertise("goal", "std_msgs/String", client, None, latch=False)
    place.unadvertise("goal", client, None)
    assert place.publish("goal", b"{}", client, must_arrive=True) == 1
    assert place.publish("goal", b"{}", client, must_arrive=False) == 0
    assert place.far.take(robot_link.Deliver) == [
        robot_link.Deliver("goal", b"{}", client, sequence) for sequence in (1, 0)
    ]


async def test_clone_takes_over_a_topic_of_a_client(place: StillPlace) -> None:
    client = place.join(RecordingClient())
    place.advertise("tf_view", "tf2_msgs/TFMessage", client, None, latch=True)
    place.publish("tf_view", b"{}", client, must_arrive=True, latch=True)
    place.say(robot_link.TopicAdded(robot_link.TopicInfo("tf_view", "tf2_msgs/TFMessage", False), "move_base"))
    assert "tf_view" in place.topics and place.client_topics.latched("tf_view") is None
    place.publish("tf_view", b"{}", client, must_arrive=True)
    assert len(place.far.take(robot_link.Deliver)) == 1


async def test_call_reaches_the_client_that_advertises_the_service(place: StillPlace) -> None:
    provider = RecordingClient()
    number, caller = place.join(provider), place.join(RecordingClient())
    with pytest.raises(Conflict, match="provided by the clone"):
        place.advertise_service("make_plan", "nav_msgs/GetPlan", number, provider)
    place.advertise_service("lights", "std_srvs/SetBool", number, provider)
    assert place.service_type("lights") == "std_srvs/SetBool"
    asked = asyncio.create_task(place.call("lights", b'{"data":true}', 5.0))
    await provider.notified()
    [(call, service, payload)] = provider.calls
    assert (service, payload) == ("lights", b'{"data":true}')
    with pytest.raises(NotPermitted):
        place.client_services.answer(call, caller, b"{}")
    place.client_services.answer(call, number, b'{"success":true}')
    assert json.loads(await asked) == {"success": True, "message": ""}


async def test_pending_call_fails_if_the_clone_takes_the_service_over(place: StillPlace) -> None:
    robot = RecordingClient()
    number = place.join(robot)
    for service in ("drive", "lights"):
        place.advertise_service(service, "my_msgs/Trigger", number, robot)
    driving, lighting = (asyncio.create_task(place.call(service, b"{}", 5.0)) for service in ("drive", "lights"))
    await until(lambda: len(robot.calls) == 2)
    place.say(robot_link.NodesChanged([robot_link.ServiceInfo("drive", "std_srvs/Trigger")], []))
    with pytest.raises(Unavailable, match="the clone now provides service 'drive' itself; call again"):
        await driving
    [call] = [call for call, service, _ in robot.calls if service == "lights"]
    place.client_services.answer(call, number, b"{}")
    assert await lighting == b"{}"
    again = asyncio.create_task(place.call("drive", b"{}", 5.0))
    await until(lambda: bool(place.far.written))
    [asked] = place.far.take(robot_link.ServiceCall)
    assert asked.service == "drive"
    place.say(robot_link.ServiceAnswer(asked.call, b"1"))
    assert await again == b"1"


async def test_refusal_reaches_only_the_sender_of_the_message(place: StillPlace) -> None:
    sender, other = RecordingClient(), RecordingClient()
    number = place.join(sender)
    place.join(other)
    place.say(robot_link.MessageRefused(number, "goal", Refusal("invalid-input", "NaN")))
    assert [error.slug for error in sender.errors] == ["invalid-input"]
    assert other.errors == []


# -- clients that fail -------------------------------------------------------------------------------------------------


class FaultyClient(RecordingClient):
    """Client of a place all of whose methods fail."""

    def published(self, topic: str, payload: bytes) -> None:
        raise RuntimeError("published")

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        raise RuntimeError("refused")

    def acknowledged(self, sequence: int) -> None:
        raise RuntimeError("acknowledged")

    def closed(self, reason: PPaaSError) -> None:
        raise RuntimeError("closed")


class LeavingClient(RecordingClient):
    """Client that makes another one leave when it gets a message."""

    def __init__(self, place: Place) -> None:
        super().__init__()
        self.place, self.other = place, 0

    def published(self, topic: str, payload: bytes) -> None:
        super().published(topic, payload)
        self.place.leave(self.other)


async def test_a_listener_that_fails_starves_no_other_and_does_not_reach_the_sender(
    place: StillPlace, caplog: pytest.LogCaptureFixture
) -> None:
    clients = [RecordingClient(), FaultyClient(), RecordingClient(), FaultyClient(), RecordingClient()]
    numbers = [place.join(client) for client in clients]
    place.advertise("chatter", "my_msgs/Chat", numbers[0], None, latch=False)
    for number in numbers:
        place.hear("chatter", number)
    for _ in range(3):
        place.publish("chatter", b"{}", numbers[0], must_arrive=False)
    assert [len(client.heard) for client in clients] == [3, 0, 3, 0, 3]
    errors = [record.getMessage() for record in caplog.records if record.levelno >= logging.ERROR]
    assert errors == [f"client {numbers[at]} failed; the other listeners go on" for at in (1, 3)]


async def test_a_refusal_to_a_listener_that_fails_does_not_end_the_link(place: StillPlace) -> None:
    number = place.join(FaultyClient())
    place._refused(number, "goal", Unavailable("no"), 1)
    assert place.clients == 1


async def test_a_listener_that_another_one_makes_leave_gets_nothing_more(place: StillPlace) -> None:
    first = LeavingClient(place)
    second = LeavingClient(place)
    second.other, first.other = place.join(first), place.join(second)
    for number in (first.other, second.other):
        place.hear("chatter", number)
    place._published("chatter", b"{}")
    assert sorted([len(first.heard), len(second.heard)]) == [0, 1]
