"""Topics and services that the clients of a place link advertise to each other."""

import asyncio
import json

import pytest

from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from engine.sessions.place.place import Place
from ppaas.errors import Conflict, NotFound, NotPermitted, Unavailable
from tests.support.engine.place_peers import FakeContainer, RecordingClient
from tests.support.waiting import until


async def test_subscription_before_the_advertisement_gets_the_messages() -> None:
    place = Place("robot:a/r")
    listener = RecordingClient()
    subscriber, publisher = place.join(listener), place.join(RecordingClient())
    container = await FakeContainer.ready(place, "c1")
    place.hear("chatter", subscriber, "std_msgs/String")
    assert place.topic_type("chatter") is None
    with pytest.raises(NotFound, match="known: goal, map"):
        place.publish("chatter", b"{}", publisher, must_arrive=True)
    place.advertise("chatter", "std_msgs/String", publisher, "1", latch=False)
    place.publish("chatter", b'{"data":"hi"}', publisher, must_arrive=True)
    assert listener.heard == [("chatter", b'{"data":"hi"}')]
    place.leave(publisher)
    assert place.topic_type("chatter") is None
    await container.die()


async def test_topic_of_the_clone_keeps_its_type_and_recipient() -> None:
    place = Place("robot:a/r")
    client = place.join(RecordingClient())
    container = await FakeContainer.ready(place, "c1")
    with pytest.raises(Conflict, match="has type std_msgs/String"):
        place.advertise("goal", "std_msgs/Bool", client, None, latch=False)
    with pytest.raises(Conflict, match="has type nav_msgs/OccupancyGrid"):
        place.hear("map", client, "std_msgs/String")
    place.advertise("goal", "std_msgs/String", client, None, latch=False)
    place.unadvertise("goal", client, None)
    assert place.publish("goal", b"{}", client, must_arrive=True) == 1
    assert place.publish("goal", b"{}", client, must_arrive=False) == 0
    assert isinstance(await container.next(), robot_link.Deliver)
    await container.die()


async def test_clone_takes_over_a_topic_of_a_client() -> None:
    place = Place("robot:a/r")
    client = place.join(RecordingClient())
    container = await FakeContainer.ready(place, "c1")
    place.advertise("tf_view", "tf2_msgs/TFMessage", client, None, latch=True)
    place.publish("tf_view", b"{}", client, must_arrive=True, latch=True)
    container.stream.write(
        robot_link.TopicAdded(robot_link.TopicInfo("tf_view", "tf2_msgs/TFMessage", False), "planner")
    )
    await until(lambda: "tf_view" in place.topics)
    assert place.client_topics.latched("tf_view") is None
    place.publish("tf_view", b"{}", client, must_arrive=True)
    assert isinstance(await container.next(), robot_link.Deliver)
    await container.die()


async def test_call_reaches_the_client_that_advertises_the_service() -> None:
    place = Place("robot:a/r")
    provider = RecordingClient()
    number, caller = place.join(provider), place.join(RecordingClient())
    container = await FakeContainer.ready(place, "c1")
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
    await container.die()


async def test_pending_call_fails_if_the_clone_takes_the_service_over() -> None:
    place = Place("robot:a/r")
    robot = RecordingClient()
    number = place.join(robot)
    container = await FakeContainer.ready(place, "c1")
    for service in ("drive", "lights"):
        place.advertise_service(service, "my_msgs/Trigger", number, robot)
    driving, lighting = (asyncio.create_task(place.call(service, b"{}", 5.0)) for service in ("drive", "lights"))
    await until(lambda: len(robot.calls) == 2)
    container.stream.write(robot_link.NodesChanged([robot_link.ServiceInfo("drive", "std_srvs/Trigger")], []))
    with pytest.raises(Unavailable, match="the clone now provides service 'drive' itself; call again"):
        await driving
    [call] = [call for call, service, _ in robot.calls if service == "lights"]
    place.client_services.answer(call, number, b"{}")
    assert await lighting == b"{}"
    again = asyncio.create_task(place.call("drive", b"{}", 5.0))
    asked = await container.next()
    assert isinstance(asked, robot_link.ServiceCall) and asked.service == "drive"
    container.stream.write(robot_link.ServiceAnswer(asked.call, b"1"))
    assert await again == b"1"
    await container.die()


async def test_refusal_reaches_only_the_sender_of_the_message() -> None:
    place = Place("robot:a/r")
    sender, other = RecordingClient(), RecordingClient()
    number = place.join(sender)
    place.join(other)
    container = await FakeContainer.ready(place, "c1")
    container.stream.write(robot_link.MessageRefused(number, "goal", Refusal("invalid-input", "NaN")))
    await sender.notified()
    assert [error.slug for error in sender.errors] == ["invalid-input"]
    assert other.errors == []
    await container.die()
