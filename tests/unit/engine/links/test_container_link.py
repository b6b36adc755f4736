"""Clients of a link: what one of them does concerns no other, nor the one that publishes."""

import logging

import pytest

from engine.protocols import robot_link
from engine.sessions.place.place import Place
from ppaas.errors import PPaaSError, Unavailable
from tests.support.engine.place_peers import RecordingClient


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


@pytest.fixture
def place() -> Place:
    return Place("robot:ann/tb1")


async def test_a_listener_that_fails_starves_no_other_and_does_not_reach_the_sender(
    place: Place, caplog: pytest.LogCaptureFixture
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


async def test_acknowledgements_and_the_end_reach_all_whatever_one_does(place: Place) -> None:
    clients = [FaultyClient(), RecordingClient()]
    for client in clients:
        place.join(client)
    place.take(robot_link.Ack(7))
    place.close(Unavailable("over"))
    assert clients[1].acknowledgements == [7]
    assert [str(reason) for reason in clients[1].reasons] == ["over"]
    assert place.clients == 0


async def test_a_refusal_to_a_listener_that_fails_does_not_end_the_link(place: Place) -> None:
    number = place.join(FaultyClient())
    place._refused(number, "goal", Unavailable("no"), 1)
    assert place.clients == 1


async def test_a_listener_that_another_one_makes_leave_gets_nothing_more(place: Place) -> None:
    first = LeavingClient(place)
    second = LeavingClient(place)
    second.other, first.other = place.join(first), place.join(second)
    for number in (first.other, second.other):
        place.hear("chatter", number)
    place._published("chatter", b"{}")
    assert sorted([len(first.heard), len(second.heard)]) == [0, 1]
