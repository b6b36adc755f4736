"""Place without sockets whose container is a real clone with a simulated robot, on the clock of the test."""

from typing import Any

from engine.container.container import topic_info
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from ppaas.errors import PPaaSError
from ppaas.messages.base.message import Message
from ppaas.messages.codec import decode, encode
from ppaas.nodes.base import Payload
from tests.support.endpoints.still_place import StillClient, StillPlace
from tests.support.world.closed_loop import ClosedLoop


class DrivenPlace(StillPlace):
    """Carries frames between clients and the clone of a closed loop."""

    def __init__(self, driving: ClosedLoop) -> None:
        super().__init__()
        self.driving = driving
        self.services = {
            name: robot_link.ServiceInfo(name, service.type.name) for name, service in driving.graph.services.items()
        }
        self.topics = {name: topic_info(topic) for name, topic in driving.graph.topics.items()}
        self._wanted: set[str] = set()
        for name in driving.graph.topics:
            driving.graph.tap(name, self._on_published)

    def _on_published(self, topic: str, message: Payload) -> None:
        if topic in self._wanted:
            sent = message if isinstance(message, Message) else message.to_message()
            self.say(robot_link.Published(topic, encode(sent)))

    def carry(self) -> None:
        """Deliver what clients have sent."""
        frames, self.far.written = self.far.written, []
        for frame in frames:
            match frame:
                case robot_link.SubscribeTopic():
                    self._wanted.add(frame.topic)
                case robot_link.UnsubscribeTopic():
                    self._wanted.discard(frame.topic)
                case robot_link.Deliver():
                    self._deliver(frame)
                case robot_link.ServiceCall():
                    self._call(frame)

    def _deliver(self, frame: robot_link.Deliver) -> None:
        graph = self.driving.graph
        try:
            graph.inject(frame.topic, decode(graph.topics[frame.topic].type, frame.payload))
        except PPaaSError as error:
            refusal = Refusal(error.slug, str(error))
            self.say(robot_link.MessageRefused(frame.client, frame.topic, refusal, frame.sequence))

    def _call(self, frame: robot_link.ServiceCall) -> None:
        graph = self.driving.graph

        def reply(result: Payload | PPaaSError) -> None:
            assert isinstance(result, Message), result
            self.say(robot_link.ServiceAnswer(frame.call, encode(result)))

        graph.call(frame.service, decode(graph.service(frame.service).type.request, frame.payload), reply)

    def run(self, seconds: float) -> None:
        """Simulate for a time [s]."""
        end = self.driving.clock() + seconds
        while self.driving.clock() < end:
            self.carry()
            self.driving.step()

    def result(self, client: StillClient, goal: dict[str, Any], seconds: float = 90.0) -> dict[str, Any]:
        """Send an action goal, and simulate until its result comes; return the result with all feedback before it.

        The key ``feedback`` has the values of the feedback. Other frames for the client are dropped.
        """
        client.say(op="send_action_goal", feedback=True, **goal)
        return self.next_result(client, seconds)

    def next_result(self, client: StillClient, seconds: float = 90.0) -> dict[str, Any]:
        """Simulate until a result comes, at most for a time [s]; return it as `result` does."""
        feedback: list[Any] = []
        end = self.driving.clock() + seconds
        while self.driving.clock() < end:
            for frame in client.received():
                if frame["op"] == "action_feedback":
                    feedback.append(frame["values"])
                elif frame["op"] == "action_result":
                    return {**frame, "feedback": feedback}
            self.run(0.05)
        raise AssertionError(f"no result within {seconds} s; feedback: {feedback[-1:]}")
