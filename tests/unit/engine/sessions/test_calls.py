"""Service calls between clients of a place, and to the clone."""

import json
from typing import Any

import pytest

from engine.protocols import robot_link
from engine.sessions.calls import MAX_CALLS
from ppaas.errors import Unavailable
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, answers


async def test_a_client_serves_a_service_to_another_client(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="/lights", type="std_srvs/SetBool")
    other.say(op="call_service", service="lights", id="c1", args={"data": True})
    [asked] = await answers(client)
    assert (asked["op"], asked["service"], asked["args"]) == ("call_service", "/lights", {"data": True})
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={"success": True})
    assert await answers(other) == [
        {
            "op": "service_response",
            "service": "lights",
            "id": "c1",
            "result": True,
            "values": {"success": True, "message": ""},
        }
    ]
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={})
    assert client.received()[0]["msg"].startswith("not-found")
    assert other.received() == []


@pytest.mark.parametrize(
    ("response", "reason"),
    [
        ({"result": False, "values": "no bulb"}, "no bulb"),
        ({"result": False, "values": "unavailable: no bulb"}, "no bulb"),
        ({"result": False}, "service 'lights': the client reported a failure"),
        ({"result": None, "values": {}}, "service 'lights': the client reported a failure"),
    ],
)
async def test_a_failure_response_reaches_the_caller_with_its_reason(
    response: dict[str, Any], reason: str, client: StillClient
) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    client.say(op="call_service", service="/lights", id="c1")
    [asked] = await answers(client)
    client.say(op="service_response", service="lights", id=asked["id"], **response)
    [answer] = await answers(client)
    assert (answer["result"], answer["values"], answer["id"]) == (False, reason, "c1")


async def test_calls_fail_on_timeout_and_when_the_provider_disconnects(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    other.say(op="call_service", service="lights", id="c1", timeout=0.02)
    other.say(op="call_service", service="lights", id="c2", timeout=-1)
    [late] = await answers(other)
    assert (late["id"], late["result"]) == ("c1", False) and "0.02 s" in late["values"]
    client.session.end()
    [gone] = await answers(other)
    assert (gone["id"], gone["result"]) == ("c2", False) and "has disconnected" in gone["values"]


async def test_a_call_to_a_slow_provider_fails_and_keeps_it_connected(
    client: StillClient, other: StillClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(frame: str) -> None:
        raise Unavailable("full")

    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    monkeypatch.setattr(client.session.outbox, "put_answer", full)
    other.say(op="call_service", service="lights", id="c1")
    [answer] = await answers(other)
    assert answer["values"] == "full"
    assert not client.session.over.done()


async def test_list_arguments_are_mapped_to_the_fields_of_clone_services(
    place: StillPlace, client: StillClient
) -> None:
    client.say(op="call_service", service="make_plan", args=[POSE, POSE])
    client.say(op="call_service", service="make_plan", id="long", args=[1, 2, 3, 4])
    client.say(op="call_service", service="nothing", id="unknown", args=[1])
    refused = {frame["id"]: frame["values"] for frame in await answers(client, 2)}
    assert "4 arguments" in refused["long"] and "as an object" in refused["unknown"]
    [call] = place.far.take(robot_link.ServiceCall)
    assert json.loads(call.payload) == {"start": POSE, "goal": POSE}


async def test_pending_calls_are_bounded_and_dropped_at_the_end(client: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    for number in range(MAX_CALLS + 1):
        client.say(op="call_service", service="lights", id=str(number))
    [refused] = [frame for frame in client.received() if frame["op"] == "service_response"]
    assert refused["id"] == str(MAX_CALLS)
    client.session.end()
    assert [frame for frame in client.received() if frame["op"] == "service_response"] == []
