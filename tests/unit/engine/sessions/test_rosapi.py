"""rosapi lists everything at a place: the clone, the clients, and rosapi itself."""

import asyncio
import json
from collections.abc import Callable

import msgspec
import pytest

from engine.links.open_calls import Done
from engine.sessions.calls import ClientCalls
from engine.sessions.outbox import Sent
from engine.sessions.place.place import Place
from engine.sessions.rosapi import introspect, view_of
from engine.sessions.unsettled import Posting, UnsettledFrames
from ppaas.errors import Conflict, PPaaSError
from ppaas.wire.operations import AdvertiseService, CallService
from ppaas.wire.rosbridge import RosbridgeSession
from tests.support.endpoints.still_place import StillPlace


class Client:
    """Client that only receives."""

    def published(self, topic: str, payload: bytes) -> None: ...

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None: ...

    def closed(self, reason: PPaaSError) -> None: ...

    def requested(self, call: int, service: str, payload: bytes) -> None: ...


@pytest.fixture
async def place() -> StillPlace:
    return StillPlace()


def _calls(place: Place, send: Callable[[bytes, int, Sent | None], None]) -> ClientCalls:
    client = place.join(Client())
    posting = Posting(place, client, UnsettledFrames(), lambda: None)
    return ClientCalls(place, client, RosbridgeSession(), send, lambda *_: None, posting=posting)


def ask(place: Place, service: str, /, **arguments: str) -> dict[str, object]:
    answer = introspect(place, f"rosapi/{service}", json.dumps(arguments).encode())
    assert answer is not None
    decoded: dict[str, object] = json.loads(answer)
    return decoded


async def test_rosapi_lists_the_clone_its_clients_and_itself(place: Place) -> None:
    client = place.join(Client())
    place.advertise("chatter", "std_msgs/String", client, None, latch=False)
    place.advertise_service("wave", "std_srvs/Trigger", client, Client())
    place.hear("cmd_vel", client)
    assert ask(place, "nodes")["nodes"] == ["/move_base", "/rosapi", "/rosbridge_websocket"]
    assert ask(place, "publishers", topic="/cmd_vel")["publishers"] == ["/move_base"]
    assert ask(place, "publishers", topic="/chatter")["publishers"] == ["/rosbridge_websocket"]
    assert ask(place, "publishers", topic="/goal")["publishers"] == ["/rosbridge_websocket"]
    assert ask(place, "subscribers", topic="/cmd_vel")["subscribers"] == ["/rosbridge_websocket"]
    assert ask(place, "service_type", service="/wave")["type"] == "std_srvs/Trigger"
    assert ask(place, "service_node", service="/rosapi/topics")["node"] == "/rosapi"
    assert {"/make_plan", "/wave", "/rosapi/topics"} <= set(ask(place, "services")["services"])
    place.leave(client)
    assert ask(place, "topic_type", topic="/chatter")["type"] == ""
    assert "/wave" not in ask(place, "services")["services"]


async def test_services_outside_rosapi_are_not_answered(place: Place) -> None:
    assert introspect(place, "make_plan", b"{}") is None
    assert introspect(place, "rosapi/get_param", b"{}") is None


async def test_a_place_without_a_container_lists_only_its_own_nodes() -> None:
    view = view_of(Place("robot:ann/tb1"))
    assert (dict(view.topics), list(view.nodes)) == ({}, ["rosapi", "rosbridge_websocket"])


async def test_clients_call_rosapi_and_cannot_advertise_its_services(place: Place) -> None:
    frames: asyncio.Queue[str] = asyncio.Queue()
    send: Callable[[bytes, int, Sent | None], None] = lambda frame, *_: frames.put_nowait(frame)  # noqa: E731
    calls = _calls(place, send)
    with pytest.raises(Conflict, match="belongs to the cloud"):
        calls.advertise(AdvertiseService("/rosapi/topics", "rosapi/Topics"), Client())
    calls.start(CallService("/rosapi/get_time", "1"))
    calls.start(CallService("rosapi/message_details", "2", msgspec.Raw(b'{"type": "no/Such"}')))
    decoded = {frame["id"]: frame for frame in [json.loads(await asyncio.wait_for(frames.get(), 5)) for _ in range(2)]}
    assert (decoded["1"]["service"], set(decoded["1"]["values"]["time"])) == ("/rosapi/get_time", {"secs", "nsecs"})
    assert decoded["2"]["result"] is False
    assert "no/Such" in decoded["2"]["values"]


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("rosapi_msgs/srv/GetParamNames", ["/move_base:a", "/b"]),
        ("rosapi/srv/GetParamNames", ["/move_base:a", "/b"]),
        ("rosapi/GetParamNames", ["/move_base/a", "/b"]),
        (None, ["/move_base/a", "/b"]),
    ],
)
async def test_names_of_parameters_are_those_of_the_ros_that_the_client_names(
    place: Place, kind: str | None, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    frames: list[bytes] = []
    send: Callable[[bytes, int, Sent | None], None] = lambda frame, *_: frames.append(frame)  # noqa: E731
    calls = _calls(place, send)

    def call(service: str, payload: bytes, timeout: float, done: Done) -> Callable[[], object]:
        done(b'{"names":["/move_base/a","/b"]}')
        return lambda: None

    monkeypatch.setattr(place, "begin_call", call)
    calls.start(CallService("/rosapi/get_param_names", "1", type=kind))
    assert json.loads(frames[0])["values"] == {"names": names}
