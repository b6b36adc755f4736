"""Side of an AGV that is the broker: topics of the master control in, states out."""

import logging
import math
from collections.abc import Callable

from ppaas.clock import epoch, monotonic
from ppaas.errors import PPaaSError
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.agv.agv import Agv
from ppaas.wire.vda5050.agv.report import Telemetry, state_of, visualization_of
from ppaas.wire.vda5050.codec import decode, encode
from ppaas.wire.vda5050.factsheets import Factsheet
from ppaas.wire.vda5050.fields import Fields
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.states import Connection, ConnectionState
from ppaas.wire.vda5050.topics import AgvAddress
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.factsheet import MIN_INTERVAL
from robots.bridges.vda5050.mqtt_link import Exchange, Outbox, Outgoing

logger = logging.getLogger(__name__)


class FleetSide:
    """Topics of one AGV.

    Parameters
    ----------
    agv, telemetry : Agv, Telemetry
    factsheet : Factsheet
    map_id : str
    serial : str
        Serial number of the AGV.
    options : AgvOptions
    """

    def __init__(
        self, agv: Agv, telemetry: Telemetry, factsheet: Factsheet, *, map_id: str, serial: str, options: AgvOptions
    ) -> None:
        self._agv, self._telemetry, self._factsheet, self._map_id = agv, telemetry, factsheet, map_id
        self._options = options
        self._address = AgvAddress.of(options.version, options.manufacturer, serial, options.interface)
        self._headers = HeaderCounter(options.version, self._address)
        self._names = {self._address.topic(name): name for name in topics.topics_to_agv(options.version)}
        self._outbox: Outbox | None = None
        self._state_sent, self._shown = -math.inf, -math.inf
        self._pending = True
        self._state_id = 0

    def exchange(self, received: Callable[[], None]) -> Exchange:
        """Return the use of an MQTT connection; ``received`` is called after each message."""

        def take(topic: str, payload: bytes, retained: bool) -> None:
            self._take(topic, payload, retained)
            received()

        return Exchange(
            topics=tuple(self._names),
            received=take,
            connected=self._connected,
            will=lambda: self._message(topics.CONNECTION, _connection("CONNECTION_BROKEN")),
            farewell=lambda: self._message(topics.CONNECTION, _connection("OFFLINE")),
        )

    def use(self, outbox: Outbox) -> None:
        """Send messages by an outbox from now on."""
        self._outbox = outbox

    # -- messages of the master control --------------------------------------------------------------------------------

    def _take(self, topic: str, payload: bytes, retained: bool) -> None:
        name = self._names.get(topic)
        if name is None:
            return
        if retained:
            logger.warning("ignored a retained message on %s: orders are not to be retained", topic)
            return
        try:
            _, body = decode(name, payload, self._options.version)
        except PPaaSError as error:
            logger.warning("refused a message on %s: %s", topic, error)
            self._agv.refuse_message(str(error))
            return
        if name == topics.ORDER:
            self._agv.take_order(body)
        elif name == topics.INSTANT_ACTIONS:
            self._agv.take_instant_actions(body)
        elif name == topics.ZONE_SET:
            self._agv.take_zone_set(body)
        # responses answer requests, and this AGV makes none

    # -- messages of the AGV -------------------------------------------------------------------------------------------

    def send_factsheet(self) -> None:
        """Publish the factsheet."""
        self._put(topics.FACTSHEET, self._factsheet)

    def publish_due(self) -> None:
        """Publish state and visualization, if it is time."""
        now = monotonic()
        self._pending |= self._agv.take_change()
        age = now - self._state_sent
        if age >= self._options.state_interval or (self._pending and age >= MIN_INTERVAL):
            self._send_state(now)
        interval = self._options.visualization_interval
        if interval and now - self._shown >= interval:
            self._shown = now
            shown = visualization_of(self._agv, self._map_id, self._telemetry, self._state_id)
            self._put(topics.VISUALIZATION, shown)

    def _send_state(self, now: float) -> None:
        self._state_sent, self._pending = now, False
        self._put(topics.STATE, state_of(self._agv, self._map_id, self._telemetry))

    def _connected(self) -> None:
        self._put(topics.CONNECTION, _connection("ONLINE"))
        self.send_factsheet()
        self._state_sent, self._pending = -math.inf, True

    def _put(self, name: str, body: Fields) -> None:
        if self._outbox is not None:
            self._outbox.put_newest(self._message(name, body))

    def _message(self, name: str, body: Fields) -> Outgoing:
        header = self._headers.next(name, epoch())
        if name == topics.STATE:
            self._state_id = header.header_id
        qos, retain = topics.quality_of(name)
        return Outgoing(self._address.topic(name), encode(name, header, body, self._options.version), qos, retain)


def _connection(state: ConnectionState) -> Connection:
    return Connection(connection_state=state)
