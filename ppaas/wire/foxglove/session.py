"""State of a connection of Foxglove's protocol: channels, subscriptions, channels of the client."""

import itertools
from collections.abc import Iterator
from typing import Generic, TypeVar

from ppaas.errors import Conflict, NotFound, QuotaExceeded
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.foxglove.answers import Channel, Schema, message_data
from ppaas.wire.foxglove.requests import ChannelSubscription, ClientChannel

MAX_SUBSCRIPTIONS = 10_000
"""Largest number of subscriptions of one client."""

MAX_CLIENT_CHANNELS = 200
"""Largest number of channels that one client publishes."""

K = TypeVar("K")


class FoxgloveSession(Generic[K]):
    """Channels and subscriptions of one connection; ``K`` is what the caller shows in a channel."""

    def __init__(self) -> None:
        self._ids = itertools.count(1)
        self._channels: dict[int, K] = {}
        self._subscriptions: dict[int, int] = {}
        self._heard: dict[int, list[int]] = {}
        self._published: dict[int, ClientChannel] = {}

    # -- channels ------------------------------------------------------------------------------------------------------

    def open(self, topic: str, schema: Schema, shows: K) -> Channel:
        """Open a channel; its id is never used again."""
        channel = Channel(next(self._ids), topic, schema)
        self._channels[channel.id] = shows
        return channel

    def close(self, channel: int) -> None:
        """Close a channel, and end its subscriptions."""
        del self._channels[channel]
        for subscription in self._heard.pop(channel, ()):
            del self._subscriptions[subscription]

    # -- subscriptions -------------------------------------------------------------------------------------------------

    def subscribe(self, wanted: ChannelSubscription) -> K:
        """Add a subscription, and return what its channel shows.

        Raises
        ------
        Conflict
            The id of the subscription is in use.
        NotFound
            There is no such channel.
        QuotaExceeded
            There are too many subscriptions.
        """
        if wanted.id in self._subscriptions:
            raise Conflict(f"subscription {wanted.id} exists already: choose another id, or unsubscribe first")
        if wanted.channel_id not in self._channels:
            raise NotFound("channel", str(wanted.channel_id))
        if len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
            raise QuotaExceeded(f"a client may have at most {MAX_SUBSCRIPTIONS} subscriptions: end some first")
        self._subscriptions[wanted.id] = wanted.channel_id
        self._heard.setdefault(wanted.channel_id, []).append(wanted.id)
        return self._channels[wanted.channel_id]

    def unsubscribe(self, subscription: int) -> K | None:
        """End a subscription; return what its channel shows if that was the last one of the channel, else None.

        Raises
        ------
        NotFound
            There is no such subscription.
        """
        channel = self._subscriptions.pop(subscription, None)
        if channel is None:
            raise NotFound("subscription", str(subscription))
        self._heard[channel].remove(subscription)
        if self._heard[channel]:
            return None
        del self._heard[channel]
        return self._channels[channel]

    def messages(self, channel: int, time: int, data: bytes) -> Iterator[BinaryFrame]:
        """Yield the frames of a message, one for each subscription of its channel.

        Parameters
        ----------
        channel : int
        time : int
            Time of reception [ns since the epoch].
        data : bytes
            Message in the encoding of the channel.
        """
        for subscription in self._heard.get(channel, ()):
            yield message_data(subscription, time, data)

    # -- channels of the client ----------------------------------------------------------------------------------------

    def advertise(self, channel: ClientChannel) -> None:
        """Open a channel of the client.

        Raises
        ------
        Conflict
            The client has a channel of this id.
        QuotaExceeded
            It has too many channels.
        """
        if channel.id in self._published:
            raise Conflict(f"you advertise channel {channel.id} already: choose another id, or unadvertise it first")
        if len(self._published) >= MAX_CLIENT_CHANNELS:
            raise QuotaExceeded(f"a client may advertise at most {MAX_CLIENT_CHANNELS} channels: unadvertise one first")
        self._published[channel.id] = channel

    def unadvertise(self, channel: int) -> ClientChannel:
        """Close a channel of the client, and return it; ``NotFound`` if there is none."""
        closed = self.published(channel)
        del self._published[channel]
        return closed

    def published(self, channel: int) -> ClientChannel:
        """Return a channel of the client; ``NotFound`` if there is none."""
        found = self._published.get(channel)
        if found is None:
            raise NotFound("advertised channel", str(channel))
        return found
