"""Sessions in containers that are lost and replaced, carried by an endpoint that lives on, or by the next one."""

import asyncio
import json
from typing import Any

import msgspec
import pytest

from engine.links.carried_session import MAX_KEPT, MAX_KEPT_BYTES, CarriedSession
from engine.links.place_link import PlaceLink
from engine.protocols import robot_link
from engine.protocols.session_frames import SessionClient, SessionOptions
from engine.rights.access import Access
from engine.rights.roles import Role
from engine.sessions import host as host_module
from engine.sessions.host import SessionHost
from ppaas.errors import PPaaSError, QuotaExceeded
from ppaas.wire.own_topics import PRESENCE
from ppaas.wire.resumption import ResumptionPoint
from tests.support.endpoints.still_place import POSE, StillPlace, delivered
from tests.support.waiting import until

GOAL = {"op": "publish", "topic": "goal", "msg": {"data": "kitchen"}}
CALL = {"op": "call_service", "service": "make_plan", "id": "c1", "args": {}}
MOVE = {
    "op": "send_action_goal", "action": "move_base", "action_type": "move_base_msgs/MoveBase", "id": "g1",
    "args": {"target_pose": POSE},
}  # fmt: skip


class _Far:
    """Container's end of a link to an endpoint."""

    waiting = 0

    def __init__(self, link: PlaceLink) -> None:
        self._link = link
        self.lost = False

    def write(self, frame: msgspec.Struct) -> None:
        if not self.lost:
            self._link.take(frame)  # type: ignore[arg-type]


class _Near:
    """Endpoint's end of the link."""

    waiting = 0

    def __init__(self, host: SessionHost, far: _Far) -> None:
        self._host = host
        self._far = far

    def write(self, frame: msgspec.Struct) -> None:
        self._host.take(self._far, frame)  # type: ignore[arg-type]


class Container:
    """Container whose clone is played by the test, with links without streams."""

    def __init__(self, checkpoint: bytes = b"") -> None:
        self.place = StillPlace()
        self.host = SessionHost(self.place)
        if checkpoint:
            self.host.restore(checkpoint)
        self._links: list[tuple[PlaceLink, _Far]] = []

    def connect(self, link: PlaceLink) -> None:
        """Serve an endpoint."""
        far = _Far(link)
        self._links.append((link, far))
        self.host.link_up(far)
        link.topics, link.services = self.place.topics, self.place.services
        link._stream = _Near(self.host, far)
        for session in tuple(link._carried.values()):
            session.attach()

    def lose(self) -> None:
        """Lose the last link, as with an endpoint or a container that is killed."""
        link, far = self._links.pop()
        far.lost, link._stream = True, None
        self.host.link_lost(far)

    def acknowledge(self) -> None:
        """Report that a checkpoint with all messages was stored."""
        self.place.say(robot_link.Ack(1000))


class Client:
    """Client with its endpoint's side of the session."""

    def __init__(
        self,
        link: PlaceLink,
        name: str | None = "mine",
        *,
        counts: bool = False,
        resume: ResumptionPoint | None = None,
        role: Role = "operator",
    ) -> None:
        self.frames: list[dict[str, Any]] = []
        self.ready = True
        options = SessionOptions("error", counts=counts, linger=100.0)
        client = SessionClient("ann", "ann", "tb1", role, name)
        self.session = CarriedSession(link, client, options, Access.of_owner("tb1"), resume, count_plan=self.count)
        self.counted = 0
        self.refusal: PPaaSError | None = None
        self.session.connect(self)
        self.session.attach()

    async def count(self) -> None:
        self.counted += 1
        if self.refusal is not None:
            raise self.refusal

    def send_frame(self, frame: bytes) -> None:
        self.frames.append(json.loads(frame))

    def say(self, frame: dict[str, Any]) -> None:
        self.session.take(json.dumps(frame).encode())

    def received(self) -> list[dict[str, Any]]:
        frames, self.frames = self.frames, []
        return frames


@pytest.fixture
def link() -> PlaceLink:
    return PlaceLink("robot:ann/tb1")


@pytest.fixture
def first(link: PlaceLink) -> Container:
    made = Container()
    made.connect(link)
    return made


def replaced(first: Container, link: PlaceLink, checkpoint: bytes) -> Container:
    """Lose a container, and let another continue from its checkpoint."""
    first.lose()
    second = Container(checkpoint)
    second.connect(link)
    return second


def goals(container: Container) -> list[str]:
    return [topic for topic, _ in delivered(container.place)]


# -- a container is replaced -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mine", None])
async def test_subscriptions_continue_in_the_next_container(
    first: Container, link: PlaceLink, name: str | None
) -> None:
    client = Client(link, name)
    client.say({"op": "subscribe", "topic": "map"})
    client.say({"op": "subscribe", "topic": "goal"})
    client.say({"op": "unsubscribe", "topic": "goal"})
    second = replaced(first, link, first.host.checkpoint())
    assert second.place.heard() == {"map"}
    second.place.publish_json("map", {"n": 1})
    assert [frame["msg"] for frame in client.received()] == [{"n": 1}]


@pytest.mark.parametrize("name", ["mine", None])
async def test_a_message_in_the_checkpoint_is_not_sent_again(
    first: Container, link: PlaceLink, name: str | None
) -> None:
    client = Client(link, name)
    client.say(GOAL)
    assert goals(first) == ["goal"]
    second = replaced(first, link, first.host.checkpoint())
    assert goals(second) == []
    client.say(GOAL)
    assert goals(second) == ["goal"]


@pytest.mark.parametrize("name", ["mine", None])
async def test_a_message_after_the_checkpoint_is_sent_again(
    first: Container, link: PlaceLink, name: str | None
) -> None:
    client = Client(link, name)
    checkpoint = first.host.checkpoint()
    client.say(GOAL)
    assert goals(replaced(first, link, checkpoint)) == ["goal"]


async def test_a_message_that_no_container_got_is_sent_to_the_next(first: Container, link: PlaceLink) -> None:
    client, checkpoint = Client(link), first.host.checkpoint()
    first.lose()
    client.say(GOAL)
    client.say(CALL)
    second = Container(checkpoint)
    second.connect(link)
    assert goals(second) == ["goal"]
    [call] = second.place.far.take(robot_link.ServiceCall)
    second.place.say(robot_link.ServiceAnswer(call.call, b"{}"))
    assert [frame["result"] for frame in client.received()] == [True]


@pytest.mark.parametrize("kept", [True, False])
async def test_a_call_of_a_lost_container_fails_once(first: Container, link: PlaceLink, kept: bool) -> None:
    client = Client(link)
    checkpoint = b"" if kept else first.host.checkpoint()
    client.say(CALL)
    second = replaced(first, link, checkpoint or first.host.checkpoint())
    [answer] = client.received()
    assert (answer["id"], answer["result"]) == ("c1", False) and "lost" in answer["values"]
    assert second.place.far.take(robot_link.ServiceCall) == []
    third = replaced(second, link, second.host.checkpoint())
    assert client.received() == [] and third.place.far.take(robot_link.ServiceCall) == []


async def test_an_answered_call_is_not_answered_again(first: Container, link: PlaceLink) -> None:
    client = Client(link)
    client.say(CALL)
    checkpoint = first.host.checkpoint()
    [call] = first.place.far.take(robot_link.ServiceCall)
    first.place.say(robot_link.ServiceAnswer(call.call, b"{}"))
    assert len(client.received()) == 1
    replaced(first, link, checkpoint)
    assert client.received() == []


@pytest.mark.parametrize("applied", [True, False])
async def test_a_goal_ends_once_under_its_name(first: Container, link: PlaceLink, applied: bool) -> None:
    client = Client(link)
    before = first.host.checkpoint()
    client.say(MOVE)
    [(_, goal)] = delivered(first.place)
    second = replaced(first, link, first.host.checkpoint() if applied else before)
    again = delivered(second.place)
    assert again == ([] if applied else [("move_base/goal", goal)])
    status = {"goal_id": {"id": goal["goal_id"]["id"]}, "status": 3, "text": ""}
    second.place.publish_json("move_base/result", {"header": {}, "status": status, "result": {}})
    [result] = client.received()
    assert (result["op"], result["id"], result["status"]) == ("action_result", "g1", 4)
    replaced(second, link, second.host.checkpoint())
    assert client.received() == []


async def test_stream_messages_are_not_repeated(first: Container, link: PlaceLink) -> None:
    client = Client(link)
    client.say({"op": "advertise", "topic": "chatter", "type": "std_msgs/String"})
    checkpoint = first.host.checkpoint()
    client.say({"op": "publish", "topic": "scan", "msg": {}})
    second = replaced(first, link, checkpoint)
    assert goals(second) == [] and second.place.client_topics.type_of("chatter") == "std_msgs/String"


async def test_a_client_with_too_many_unsettled_frames_is_closed(link: PlaceLink) -> None:
    client = Client(link)
    for _ in range(MAX_KEPT):
        client.say(GOAL)
        client.say({"op": "publish", "topic": "scan", "msg": {}})
    assert not client.session.over.done()
    client.say(GOAL)
    with pytest.raises(QuotaExceeded, match=f"{MAX_KEPT + 1} messages are not acknowledged yet"):
        raise client.session.over.result()


async def test_a_client_with_too_large_unsettled_frames_is_closed(link: PlaceLink) -> None:
    client = Client(link)
    half = {**GOAL, "msg": {"data": "a" * (MAX_KEPT_BYTES // 2)}}
    client.say(half)
    assert not client.session.over.done()
    client.say(half)
    assert isinstance(client.session.over.result(), QuotaExceeded)


async def test_settled_frames_are_forgotten_by_the_endpoint(first: Container, link: PlaceLink) -> None:
    client = Client(link)
    client.say(GOAL)
    client.say({"op": "subscribe", "topic": "map", "id": "a"})
    assert len(client.session._kept) == 2
    first.acknowledge()
    await until(lambda: len(client.session._kept) == 1)
    client.say({"op": "unsubscribe", "topic": "map", "id": "a"})
    await until(lambda: not client.session._kept)


# -- the link alone is lost --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mine", None])
async def test_frames_of_a_lost_link_are_executed_once(first: Container, link: PlaceLink, name: str | None) -> None:
    client = Client(link, name)
    client.say({"op": "subscribe", "topic": "map"})
    client.say(GOAL)
    assert goals(first) == ["goal"]
    first.lose()
    client.say(GOAL)
    first.connect(link)
    assert goals(first) == ["goal"]
    first.place.publish_json("map", {})
    assert [frame["op"] for frame in client.received()] == ["publish"]


# -- the endpoint is lost ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("counts", [True, False])
async def test_a_session_outlives_its_endpoint(first: Container, link: PlaceLink, counts: bool) -> None:
    client = Client(link, counts=counts)
    client.say({"op": "subscribe", "topic": "map"})
    client.say(CALL)
    first.lose()
    [call] = first.place.far.take(robot_link.ServiceCall)
    first.place.say(robot_link.ServiceAnswer(call.call, b"{}"))
    other = PlaceLink("robot:ann/tb1")
    first.connect(other)
    again = Client(other, counts=counts, resume=ResumptionPoint(client.session.id, 0) if counts else None)
    assert (again.session.id, again.session.resumed, again.session.taken) == (client.session.id, True, 2)
    assert [frame["id"] for frame in again.received()] == ["c1"]
    first.place.publish_json("map", {})
    assert len(again.received()) == 1


async def test_a_session_outlives_endpoint_and_container(first: Container, link: PlaceLink) -> None:
    client = Client(link, counts=True)
    client.say({"op": "subscribe", "topic": "map"})
    client.say(GOAL)
    checkpoint = first.host.checkpoint()
    first.lose()
    second, other = Container(checkpoint), PlaceLink("robot:ann/tb1")
    second.connect(other)
    again = Client(other, counts=True, resume=ResumptionPoint(client.session.id, 0))
    assert (again.session.id, again.session.resumed, again.session.taken) == (client.session.id, True, 2)
    assert goals(second) == [] and second.place.heard() == {"map"}


@pytest.mark.parametrize("stored", [True, False])
async def test_a_session_that_came_to_another_endpoint_continues_in_the_next_container(
    first: Container, link: PlaceLink, stored: bool
) -> None:
    client = Client(link, counts=True)
    client.say({"op": "subscribe", "topic": "map"})
    client.say({"op": "subscribe", "topic": "scan"})
    checkpoint = first.host.checkpoint()
    first.lose()
    other = PlaceLink("robot:ann/tb1")
    first.connect(other)
    again = Client(other, counts=True, resume=ResumptionPoint(client.session.id, 0))
    again.say({"op": "unsubscribe", "topic": "scan"})
    again.say(GOAL)
    if stored:
        first.acknowledge()
        checkpoint = first.host.checkpoint()
    second = replaced(first, other, checkpoint)
    assert second.place.heard() == {"map"}, "the first endpoint alone knew what was subscribed"
    assert goals(second) == ([] if stored else ["goal"])


async def test_a_client_that_missed_frames_of_a_lost_container_begins_anew(first: Container, link: PlaceLink) -> None:
    client = Client(link, counts=True)
    client.say({"op": "subscribe", "topic": "map"})
    first.place.publish_json("map", {})
    checkpoint = first.host.checkpoint()
    first.lose()
    second, other = Container(checkpoint), PlaceLink("robot:ann/tb1")
    second.connect(other)
    again = Client(other, counts=True, resume=ResumptionPoint(client.session.id, 0))
    assert not again.session.resumed and again.session.taken == 0


async def test_the_endpoint_of_a_client_that_came_back_elsewhere_is_refused(first: Container, link: PlaceLink) -> None:
    client, checkpoint = Client(link), first.host.checkpoint()
    first.lose()
    second, other = Container(checkpoint), PlaceLink("robot:ann/tb1")
    second.connect(other)
    again = Client(other)
    second.connect(link)
    assert "took over" in str(client.session.displaced.result())
    assert again.session.resumed and not again.session.displaced.done()


# -- permits, bounds, records ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("refused", [False, True])
async def test_a_path_is_counted_by_the_endpoint(first: Container, link: PlaceLink, refused: bool) -> None:
    client = Client(link)
    client.refusal = QuotaExceeded("too many paths") if refused else None
    client.say({**CALL, "service": "move_base/make_plan"})
    await until(lambda: client.counted == 1)
    if refused:
        await until(lambda: client.frames)
        assert "too many paths" in client.received()[0]["values"]
    else:
        await until(lambda: first.place.far.take(robot_link.ServiceCall))


async def test_the_oldest_detached_session_is_evicted(
    first: Container, link: PlaceLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host_module, "MAX_AWAY", 2)
    for number in range(4):
        Client(link, f"s{number}").session.detach(for_good=False)
    assert [client.name for client in first.host._named] == ["s2", "s3"]


async def test_sessions_that_cannot_be_read_begin_anew(link: PlaceLink) -> None:
    container = Container(b'{"of": "another release"}')
    container.connect(link)
    assert not Client(link).session.resumed


# -- presence of the robot ---------------------------------------------------------------------------------------------

PRESENCE_HEARD = {"op": "subscribe", "topic": PRESENCE}


def presence(client: Client) -> list[bool]:
    """Return what a client has heard of the presence of the robot since the last call."""
    return [frame["msg"]["data"] for frame in client.received() if frame.get("topic") == PRESENCE]


async def test_the_robot_is_here_while_a_socket_of_its_own_is_attached(first: Container, link: PlaceLink) -> None:
    Client(link, "operator")
    assert not first.host.robot_is_here
    robot = Client(link, "robot", role="robot")
    assert first.host.robot_is_here
    robot.session.detach(for_good=False)  # its session is retained
    assert not first.host.robot_is_here
    Client(link, "robot", role="robot")
    assert first.host.robot_is_here


@pytest.mark.parametrize("name", ["mine", None])
async def test_the_robot_is_away_with_its_endpoint_and_here_with_the_next(
    first: Container, link: PlaceLink, name: str | None
) -> None:
    Client(link, name, role="robot")
    first.lose()
    assert not first.host.robot_is_here
    first.connect(link)
    assert first.host.robot_is_here


@pytest.mark.parametrize("name", ["mine", None])
async def test_the_robot_is_here_in_the_next_container(first: Container, link: PlaceLink, name: str | None) -> None:
    Client(link, name, role="robot")
    assert replaced(first, link, first.host.checkpoint()).host.robot_is_here


async def test_a_robot_that_takes_over_its_session_stays_here(first: Container, link: PlaceLink) -> None:
    old = Client(link, "robot", role="robot")
    other = PlaceLink("robot:ann/tb1")
    first.connect(other)
    Client(other, "robot", role="robot")
    assert first.host.robot_is_here
    old.session.detach(for_good=False)
    assert first.host.robot_is_here


async def test_operators_hear_whether_the_robot_is_connected(
    first: Container, link: PlaceLink, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host_module, "ATTEND_PERIOD", 0.001)
    attending = asyncio.create_task(first.host.attend())
    operator = Client(link, "operator")
    operator.say(PRESENCE_HEARD)
    assert presence(operator) == [False]
    robot = Client(link, "robot", role="robot")
    await until(lambda: presence(operator) == [True])
    robot.session.detach(for_good=True)
    await until(lambda: presence(operator) == [False])
    operator.say({"op": "publish", "topic": PRESENCE, "msg": {"data": True}})
    assert [frame["op"] for frame in operator.received()] == ["status"]
    attending.cancel()
