"""A node for tests of executors: it echoes messages, answers calls, and raises errors on request."""

import threading
from typing import ClassVar

from ppaas.errors import InvalidInput
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.nav_msgs import Path
from ppaas.messages.ppaas_msgs import RobotStates
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from ppaas.nodes.base import Context, Node, Payload, Reply, Service, Topic


class EchoNode(Node):
    """Publishes messages of ``say`` on ``echo``; it refuses the message ``refuse``, and crashes on ``break``."""

    name: ClassVar[str] = "echo"
    subscribes: ClassVar[tuple[Topic, ...]] = (Topic("say", String), Topic("robots", RobotStates))
    publishes: ClassVar[tuple[Topic, ...]] = (
        Topic("echo", String),
        Topic("last", String, latched=True),
        Topic("amcl_pose", PoseWithCovarianceStamped),
        Topic("plan", Path),
    )
    services: ClassVar[tuple[Service, ...]] = (
        Service("heard", Trigger),
        Service("refuse", Trigger),
        Service("break", Trigger),
        Service("job", Trigger),
    )

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.heard: list[str] = []
        self.robots: list[RobotStates] = []
        self.job_may_end = threading.Event()
        self.job_may_end.set()

    def on_message(self, topic: str, message: Payload) -> None:
        if isinstance(message, RobotStates):
            self.robots.append(message)
            return
        assert isinstance(message, String)
        if message.data == "refuse":
            raise InvalidInput("this is refused")
        if message.data == "break":
            raise ZeroDivisionError("this breaks the node")
        self.heard.append(message.data)
        self.context.publish("echo", message)
        self.context.publish("last", message)

    def on_call(self, service: str, request: Message, reply: Reply) -> None:
        match service:
            case "heard":
                reply(TriggerResponse(True, ",".join(self.heard)))
            case "refuse":
                raise InvalidInput("this is refused")
            case "break":
                raise ZeroDivisionError("this breaks the node")
            case "job":
                self.context.start(lambda _: self._job(), reply)

    def _job(self) -> TriggerResponse:
        assert self.job_may_end.wait(10)
        return TriggerResponse(True, threading.current_thread().name)

    def checkpoint(self) -> bytes:
        return ",".join(self.heard).encode()

    def restore(self, state: bytes) -> None:
        self.heard = state.decode().split(",")
