"""Frames of ROS# (siemens/ros-sharp): those that its RosBridgeClient writes, over each of its three transports.

No C# runs here; class, method and field names are those of RosBridgeClient. Its serializers write the fields of a
derived class before those of its base ``Communication``, so ``op`` and ``id`` end each frame, and ``null`` where
nothing is set. An id is the name of a topic, or ``NAME:COUNTER`` where answers are recognized by it. Text is ASCII.
"""

import json
import queue
import threading
from collections.abc import Callable, Mapping
from itertools import count
from typing import Any, Literal

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

Transport = Literal["WebSocketSharp", "WebSocketNet", "WebSocketUWP"]
Frame = Mapping[str, Any]
MAX_VALUE = 2**31 - 1
CHUNK = 1024
"""Bytes of a fragment of WebSocketNetProtocol."""


class RosSocket:
    """``RosSocket`` of ROS#: a connection, and the table of what was advertised, subscribed and called."""

    def __init__(self, url: str, transport: Transport) -> None:
        self._socket = connect(url, max_size=None, open_timeout=20, compression=None)
        self._transport = transport
        self._publishers: list[str] = []
        self._subscribers: dict[str, Callable[[Any], None]] = {}
        self._consumers: dict[str, Callable[[Frame], None]] = {}
        threading.Thread(target=self._listen, daemon=True).start()

    def advertise(self, topic: str, kind: str) -> str:
        self._send({"topic": topic, "type": kind}, "advertise", topic)
        self._publishers.append(topic)
        return topic

    def publish(self, identity: str, message: Frame) -> None:
        self._send({"topic": identity, "msg": message}, "publish", identity)

    def subscribe(self, topic: str, kind: str, throttle_rate: int = 0) -> "queue.Queue[Any]":
        heard: queue.Queue[Any] = queue.Queue()
        identity = self._unused(self._subscribers, topic)
        self._subscribers[identity] = heard.put
        fields = {"throttle_rate": throttle_rate, "queue_length": 1, "fragment_size": MAX_VALUE, "compression": "none"}
        self._send({"topic": topic, "type": kind, **fields}, "subscribe", identity)
        return heard

    def call_service(self, service: str, arguments: Frame) -> Any:
        answers: queue.Queue[Frame] = queue.Queue()
        identity = self._unused(self._consumers, service)
        self._consumers[identity] = answers.put
        fields = {"args": arguments, "fragment_size": MAX_VALUE, "compression": "none"}
        self._send({"service": service, **fields}, "call_service", identity)
        return answers.get(timeout=20)["values"]

    def send_action_goal(self, action: str, kind: str, goal: Frame) -> "queue.Queue[Frame]":
        """Send a goal of ROS 2; a program that sets neither a fragment size nor a compression sends 0 and null."""
        answers: queue.Queue[Frame] = queue.Queue()
        identity = self._unused(self._consumers, action)
        self._consumers[identity] = answers.put
        fields = {"args": goal, "feedback": True, "fragment_size": 0, "compression": None}
        self._send({"action": action, "action_type": kind, **fields}, "send_action_goal", identity)
        return answers

    def cancel_action_goal(self, action: str, goal_id: str) -> None:
        self._send({"action": action}, "cancel_action_goal", goal_id)

    def close(self) -> None:
        for topic in self._publishers:
            self._send({"topic": topic}, "unadvertise", topic)
        for identity in self._subscribers:
            self._send({"topic": identity.rpartition(":")[0]}, "unsubscribe", identity)
        self._socket.close()

    def _send(self, fields: Frame, op: str, identity: str) -> None:
        text = json.dumps({**fields, "op": op, "id": identity}, separators=(",", ":"))
        if self._transport == "WebSocketUWP":
            self._socket.send(text)
        elif self._transport == "WebSocketSharp":
            self._socket.send(text.encode("ascii"))
        else:
            self._send_chunks(text.encode("ascii"))

    def _send_chunks(self, data: bytes) -> None:
        with self._socket.send_context():
            for start in range(0, len(data), CHUNK):
                send = self._socket.protocol.send_continuation if start else self._socket.protocol.send_binary
                send(data[start : start + CHUNK], fin=start + CHUNK >= len(data))

    def _listen(self) -> None:
        try:
            for received in self._socket:
                self._receive(json.loads(received))
        except ConnectionClosed:
            pass

    def _receive(self, frame: Frame) -> None:
        """Hand a frame out as ROS# does, which finds topics by their spelling and answers by their id."""
        if frame["op"] == "publish":
            for identity, heard in self._subscribers.copy().items():
                if identity.startswith(frame["topic"] + ":"):
                    heard(frame["msg"])
        elif frame["op"] in ("service_response", "action_feedback", "action_result"):
            self._consumers[frame["id"]](frame)

    @staticmethod
    def _unused(table: Mapping[str, Any], name: str) -> str:
        return next(identity for number in count() if (identity := f"{name}:{number}") not in table)
