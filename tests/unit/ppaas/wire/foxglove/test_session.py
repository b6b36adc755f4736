"""State of a connection of Foxglove's protocol."""

import struct

import pytest
from hypothesis.stateful import Bundle, RuleBasedStateMachine, consumes, invariant, rule

from ppaas.errors import Conflict, NotFound, QuotaExceeded
from ppaas.wire.foxglove import session as sessions
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.requests import ChannelSubscription, ClientChannel
from ppaas.wire.foxglove.session import FoxgloveSession

SCHEMA = Schema("json", "a/B", "jsonschema", "{}")


def test_a_message_goes_to_each_subscription_of_its_channel() -> None:
    session: FoxgloveSession[str] = FoxgloveSession()
    first, second = (session.open(topic, SCHEMA, topic).id for topic in ("/a", "/b"))
    assert session.subscribe(ChannelSubscription(7, first)) == "/a"
    session.subscribe(ChannelSubscription(8, first))
    session.subscribe(ChannelSubscription(9, second))
    assert list(session.messages(first, 5, b"x")) == [struct.pack("<BIQ", 1, number, 5) + b"x" for number in (7, 8)]
    assert session.unsubscribe(7) is None
    assert session.unsubscribe(8) == "/a"
    assert not list(session.messages(first, 5, b"x"))


def test_a_closed_channel_has_no_subscriptions() -> None:
    session: FoxgloveSession[str] = FoxgloveSession()
    channel = session.open("/a", SCHEMA, "a").id
    session.subscribe(ChannelSubscription(1, channel))
    session.close(channel)
    with pytest.raises(NotFound):
        session.unsubscribe(1)
    with pytest.raises(NotFound, match="unknown channel '1'"):
        session.subscribe(ChannelSubscription(1, channel))
    assert session.open("/a", SCHEMA, "a").id != channel


def test_an_id_is_used_once() -> None:
    session: FoxgloveSession[str] = FoxgloveSession()
    channel = session.open("/a", SCHEMA, "a").id
    session.subscribe(ChannelSubscription(1, channel))
    with pytest.raises(Conflict):
        session.subscribe(ChannelSubscription(1, channel))
    mine = ClientChannel(1, "/goal", "json", "a/B")
    session.advertise(mine)
    with pytest.raises(Conflict):
        session.advertise(mine)
    assert session.published(1) == session.unadvertise(1) == mine
    with pytest.raises(NotFound):
        session.published(1)
    with pytest.raises(NotFound):
        session.unadvertise(1)


def test_tables_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sessions, "MAX_SUBSCRIPTIONS", 2)
    monkeypatch.setattr(sessions, "MAX_CLIENT_CHANNELS", 2)
    session: FoxgloveSession[str] = FoxgloveSession()
    channel = session.open("/a", SCHEMA, "a").id
    for number in (1, 2):
        session.subscribe(ChannelSubscription(number, channel))
        session.advertise(ClientChannel(number, "/goal", "json", "a/B"))
    with pytest.raises(QuotaExceeded):
        session.subscribe(ChannelSubscription(3, channel))
    with pytest.raises(QuotaExceeded):
        session.advertise(ClientChannel(3, "/goal", "json", "a/B"))


class AnyOrder(RuleBasedStateMachine):
    """Channels open and close, and subscriptions come and go, in any order."""

    channels = Bundle("channels")
    subscriptions = Bundle("subscriptions")

    def __init__(self) -> None:
        super().__init__()
        self.session: FoxgloveSession[int] = FoxgloveSession()
        self.of: dict[int, int] = {}
        self.open: set[int] = set()
        self.number = 0

    @rule(target=channels)
    def opens(self) -> int:
        channel = self.session.open("/a", SCHEMA, 0).id
        self.open.add(channel)
        return channel

    @rule(channel=consumes(channels))
    def closes(self, channel: int) -> None:
        self.session.close(channel)
        self.open.discard(channel)
        self.of = {number: other for number, other in self.of.items() if other != channel}

    @rule(target=subscriptions, channel=channels)
    def subscribes(self, channel: int) -> int:
        self.number += 1
        self.session.subscribe(ChannelSubscription(self.number, channel))
        self.of[self.number] = channel
        return self.number

    @rule(number=consumes(subscriptions))
    def unsubscribes(self, number: int) -> None:
        if number in self.of:
            channel = self.of.pop(number)
            assert (self.session.unsubscribe(number) is None) == (channel in self.of.values())
        else:
            with pytest.raises(NotFound):
                self.session.unsubscribe(number)

    @invariant()
    def messages_go_to_the_subscriptions(self) -> None:
        for channel in self.open:
            expected = [number for number, of in self.of.items() if of == channel]
            sent = [struct.unpack_from("<I", frame, 1)[0] for frame in self.session.messages(channel, 0, b"")]
            assert sent == expected


TestAnyOrder = AnyOrder.TestCase
