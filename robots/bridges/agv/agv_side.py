"""One AGV at the broker: messages to it, and a check of its headers."""

import logging
from collections import defaultdict
from typing import NamedTuple

from ppaas.clock import epoch
from ppaas.errors import NotFound, Unavailable
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter, MessageHeader
from ppaas.wire.vda5050.master.header_watch import HeaderOrder, HeaderWatch
from ppaas.wire.vda5050.orders import InstantActions, Order
from ppaas.wire.vda5050.topics import AgvAddress, Version, version_of
from ppaas.wire.vda5050.zones import ZoneSet
from robots.bridges.vda5050.mqtt_link import Outbox, Outgoing

logger = logging.getLogger(__name__)


class IgnoredMessage(NamedTuple):
    """Message that does not count.

    Parameters
    ----------
    reason : str
    is_loss : bool
        Whether it may have said something new: then what was known before is not known any more.
    """

    reason: str
    is_loss: bool


class AgvSide:
    """Exchange with one AGV.

    Parameters
    ----------
    address : AgvAddress
    outbox : Outbox
        Messages for the broker.

    Attributes
    ----------
    name : str
        Manufacturer and serial number.
    version : Version
        Version in which messages are sent: the AGV's.
    """

    def __init__(self, address: AgvAddress, outbox: Outbox) -> None:
        self.address = address
        self.name = address.agv
        self.version = version_of(address.major)
        self._outbox = outbox
        self._headers = HeaderCounter(self.version, address)
        self._watches: defaultdict[str, HeaderWatch] = defaultdict(HeaderWatch)

    def begin_again(self) -> None:
        """Take the next header id of each topic, whatever it is: the AGV may have been restarted."""
        self._watches.clear()

    def left_out(self, topic: str, header: MessageHeader) -> IgnoredMessage | None:
        """Return why a message is left out; None if it counts.

        The last will of an AGV was written when it connected, so the ids of ``connection`` are not compared. An AGV
        that connects again before the broker has noticed that it was away begins its ids again in this topic as well.
        """
        named = header.manufacturer, header.serial_number
        if named not in (("", ""), (self.address.manufacturer, self.address.serial)):
            return IgnoredMessage(f"the header of {topic} names AGV {'/'.join(named)[:120]!r}", is_loss=True)
        self._use_version(header.version)
        watch = self._watches[topic]
        arrival = watch.take(header)
        if topic == topics.CONNECTION:
            if arrival in (HeaderOrder.LATE, HeaderOrder.RESTARTED):
                self.begin_again()
            return None
        if arrival in (HeaderOrder.NEXT, HeaderOrder.RESTARTED):
            return None
        return IgnoredMessage(f"{arrival.value} message {header.header_id} on {topic}", is_loss=watch.is_behind)

    def send_order(self, order: Order) -> None:
        """Send an order; it replaces one that still waits for the broker, which was the same."""
        self._outbox.put_newest(self._message(topics.ORDER, order))
        nodes = f"{sum(node.released for node in order.nodes)} of {len(order.nodes)} nodes released"
        logger.info("AGV %s: order %s, update %d, %s", self.name, order.order_id, order.order_update_id, nodes)

    def send_actions(self, actions: InstantActions) -> None:
        """Send instant actions."""
        kinds = ", ".join(action.action_type for action in actions.actions)
        try:
            self._outbox.put(self._message(topics.INSTANT_ACTIONS, actions))
        except Unavailable as error:
            logger.warning("AGV %s: %s is not sent: %s", self.name, kinds, error)
        else:
            logger.info("AGV %s: %s", self.name, kinds)

    def send_zones(self, zones: ZoneSet) -> None:
        """Send a set of zones; it replaces one that still waits for the broker."""
        self._outbox.put_newest(self._message(topics.ZONE_SET, zones))
        one = zones.zone_set
        logger.info("AGV %s: zone set %s of map %s, %d zones", self.name, one.zone_set_id, one.map_id, len(one.zones))

    def _message(self, topic: str, body: Fields) -> Outgoing:
        payload = encode(topic, self._headers.next(topic, epoch()), body, self.version)
        return Outgoing(self.address.topic(topic), payload, *topics.quality_of(topic))

    def _use_version(self, text: str) -> None:
        try:
            version: Version = version_of(text)
        except NotFound:
            return
        if version is not self.version and version.major == self.version.major:
            self.version = version
            self._headers = HeaderCounter(version, self.address)
