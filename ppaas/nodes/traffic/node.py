"""Node ``traffic``: grants the robots of a map how far they may drive."""

from typing import ClassVar

from ppaas.errors import NotFound
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.traffic import GetTraffic, PutBack, TakeOut, TrafficReport, TrafficState
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import expect

TRAFFIC = "traffic"
"""Name of the node, and of the parameters of the robots that take part."""

GET_TRAFFIC = Service("traffic/get_traffic", GetTraffic)
TAKE_OUT = Service("traffic/take_out", TakeOut)
PUT_BACK = Service("traffic/put_back", PutBack)


class TrafficNode(Node):
    """Takes the reports of all robots of a user on a map that take part, and publishes their grants."""

    name: ClassVar[str] = TRAFFIC
    subscribes: ClassVar[tuple[Topic, ...]] = (topics.TRAFFIC_REPORT,)
    publishes: ClassVar[tuple[Topic, ...]] = (topics.TRAFFIC_GRANTS, topics.TRAFFIC_STATE)
    services: ClassVar[tuple[Service, ...]] = (GET_TRAFFIC, TAKE_OUT, PUT_BACK)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._reports: dict[str, TrafficReport] = {}

    def on_message(self, topic: str, message: Payload) -> None:
        """Take the report of a robot."""
        report = expect(message, TrafficReport)
        self._reports[report.robot] = report

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        """Answer a call."""
        if service != GET_TRAFFIC.name:
            raise NotFound("service", service, [GET_TRAFFIC.name])
        reply(TrafficState(Header(stamp=Time.of(self.context.now()), frame_id=MAP), 0, 0.0))
