"""Stand-in for a cloud with many robots: answers REST of the bridge, and publishes poses to its operators."""

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from http import HTTPStatus

import msgspec
from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.http11 import Request, Response

from ppaas.clock import monotonic

MAP = "hall"
"""Map of the robots."""

POSE_PERIOD = 0.2
"""Time between two poses of a robot, and between two messages of odometry [s]."""


STEPS = 64
"""Number of different frames of a topic."""

PRECISION = 0.02
"""Time by which a frame may be early [s]."""


class _Frame(msgspec.Struct):
    op: str
    topic: str = ""
    throttle_rate: float = 0.0


def _answer(connection: ServerConnection, request: Request) -> Response | None:
    """Answer requests of REST; others open a WebSocket."""
    if not request.path.startswith("/v1/"):
        return None
    answer = {"map": MAP, "model": "turtlebot2", "version": "1", "parameters": {}}
    response = connection.respond(HTTPStatus.OK, msgspec.json.encode(answer).decode())
    response.headers["Connection"] = "close"
    return response


def _pose(step: int) -> str:
    angle = 0.01 * step
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = 0.01
    pose = {
        "position": {"x": math.cos(angle), "y": math.sin(angle), "z": 0.0},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    }
    header = {"stamp": {"secs": step, "nsecs": 0}, "frame_id": "map"}
    message = {"header": header, "pose": {"pose": pose, "covariance": covariance}}
    return msgspec.json.encode({"op": "publish", "topic": "amcl_pose", "msg": message}).decode()


def _odometry(step: int) -> str:
    twist = {"linear": {"x": 0.3, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.01}}
    pose = {"position": {"x": 0.1 * step, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    message = {
        "header": {"stamp": {"secs": step, "nsecs": 0}, "frame_id": "odom"},
        "child_frame_id": "base_link",
        "pose": {"pose": pose, "covariance": [0.0] * 36},
        "twist": {"twist": twist, "covariance": [0.0] * 36},
    }
    return msgspec.json.encode({"op": "publish", "topic": "odom", "msg": message}).decode()


FRAMES: dict[str, list[str]] = {
    "amcl_pose": [_pose(step) for step in range(STEPS)],
    "odom": [_odometry(step) for step in range(STEPS)],
}
"""Frames of the topics, which are published over and over."""

Subscribers = dict[tuple[str, float], set[ServerConnection]]
"""Operators by topic and period [s]."""


@asynccontextmanager
async def fleet_stand_in() -> AsyncIterator[str]:
    """Run a stand-in on a free port of the loopback interface; yields its URL."""
    subscribers: Subscribers = {}
    decoder = msgspec.json.Decoder(_Frame)

    async def serve_robot(connection: ServerConnection) -> None:
        async for text in connection:
            frame = decoder.decode(text)
            if frame.op == "subscribe" and frame.topic in FRAMES:
                period = max(frame.throttle_rate / 1000.0, POSE_PERIOD)
                for (topic, _), others in subscribers.items():
                    if topic == frame.topic:
                        others.discard(connection)
                subscribers.setdefault((frame.topic, period), set()).add(connection)

    publishing = asyncio.create_task(_publish(subscribers))
    async with serve(serve_robot, "127.0.0.1", 0, compression=None, process_request=_answer) as server:
        try:
            yield f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        finally:
            publishing.cancel()
            await asyncio.gather(publishing, return_exceptions=True)


async def _publish(subscribers: Subscribers) -> None:
    """Publish each topic to its subscribers at the periods that they asked for."""
    due: dict[tuple[str, float], float] = {}
    step = 0
    while True:
        now = monotonic()
        for key, connections in subscribers.items():
            if now >= due.get(key, 0.0):
                due[key] = now + key[1] - PRECISION
                broadcast(connections, FRAMES[key[0]][step % STEPS])
        step += 1
        await asyncio.sleep(POSE_PERIOD / 4)
