"""Service calls between clients of a place, and to the clone."""

import json
from typing import Any

import pytest

from endpoints.rosbridge.calls import MAX_CALLS
from engine.protocols import robot_link
from ppaas.errors import Unavailable
from tests.support.endpoints.still_place import POSE, StillClient, StillPlace, answers


async def test_a_client_serves_another(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="/lights", type="std_srvs/SetBool")
    other.say(op="call_service", service="lights", id="c1", args={"data": True})
    [asked] = await answers(client)
    assert (asked["op"], asked["service"], asked["args"]) == ("call_service", "/lights", {"data": True})
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={"success": True})
    assert await answers(other) == [
        {"op": "service_response", "service": "lights", "id": "c1", "result": True, "values": {"success": True}}
    ]
    client.say(op="service_response", service="/lights", id=asked["id"], result=True, values={})
    assert client.told()[0]["msg"].startswith("not-found")
    assert other.told() == []


@pytest.mark.parametrize(
    ("response", "reason"),
    [
        ({"result": False, "values": "no bulb"}, "no bulb"),
        ({"result": False, "values": "unavailable: no bulb"}, "no bulb"),
        ({"result": False}, "service 'lights': the client reported a failure"),
        ({"result": None, "values": {}}, "service 'lights': the client reported a failure"),
    ],
)
async def test_a_client_may_serve_itself_and_refuse(response: dict[str, Any], reason: str, client: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    client.say(op="call_service", service="/lights", id="c1")
    [asked] = await answers(client)
    client.say(op="service_response", service="lights", id=asked["id"], **response)
    [answer] = await answers(client)
    assert (answer["result"], answer["values"], answer["id"]) == (False, reason, "c1")


async def test_a_provider_that_goes_fails_the_calls_put_to_it(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    other.say(op="call_service", service="lights", id="c1", timeout=0.02)
    other.say(op="call_service", service="lights", id="c2", timeout=-1)
    [late] = await answers(other)
    assert (late["id"], late["result"]) == ("c1", False) and "0.02 s" in late["values"]
    client.session.end()
    [gone] = await answers(other)
    assert (gone["id"], gone["result"]) == ("c2", False) and "has disconnected" in gone["values"]


async def test_a_provider_that_does_not_read_is_not_closed_by_those_who_call_it(
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


async def test_arguments_of_the_clones_services_may_be_a_list(place: StillPlace, client: StillClient) -> None:
    client.say(op="call_service", service="make_plan", args=[POSE, POSE])
    client.say(op="call_service", service="make_plan", id="long", args=[1, 2, 3, 4])
    client.say(op="call_service", service="nothing", id="unknown", args=[1])
    refused = {told["id"]: told["values"] for told in await answers(client, 2)}
    assert "4 arguments" in refused["long"] and "as an object" in refused["unknown"]
    [call] = place.far.take(robot_link.ServiceCall)
    assert json.loads(call.payload) == {"start": POSE, "goal": POSE}


async def test_calls_under_way_are_bounded_and_given_up_at_the_end(client: StillClient) -> None:
    client.say(op="advertise_service", service="lights", type="std_srvs/Trigger")
    for number in range(MAX_CALLS + 1):
        client.say(op="call_service", service="lights", id=str(number))
    [refused] = [told for told in client.told() if told["op"] == "service_response"]
    assert refused["id"] == str(MAX_CALLS)
    client.session.end()
    assert [told for told in client.told() if told["op"] == "service_response"] == []
