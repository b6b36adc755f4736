"""Yardstick: ``foxglove-sdk``'s own server, which publishes scans, transforms and poses of as many robots.

``python -m benchmarks.foxglove.sdk_server PORT ROBOTS RATE`` runs until it is terminated. Its messages are there
already, so that it decodes nothing.
"""

import sys
import time
from typing import TypeAlias

import foxglove
from foxglove import Channel, Schema, messages

Message: TypeAlias = messages.LaserScan | messages.FrameTransforms | messages.PoseInFrame


def _channels(robots: int) -> list[tuple[Channel, Message]]:
    pose = messages.Pose(position=messages.Vector3(), orientation=messages.Quaternion(w=1.0))
    found: list[tuple[Channel, Message]] = []
    for number in range(robots):
        frame = f"bench{number}/base_link"
        moved = messages.FrameTransform(parent_frame_id="map", child_frame_id=frame)
        for topic, message in (
            ("scan", messages.LaserScan(frame_id=frame, pose=pose, end_angle=6.28, ranges=[1.5] * 360)),
            ("tf", messages.FrameTransforms(transforms=[moved])),
            ("amcl_pose", messages.PoseInFrame(frame_id="map", pose=pose)),
        ):
            schema = message.get_schema()
            described = Schema(name=schema.name, encoding=schema.encoding, data=schema.data)
            channel = Channel(f"/bench{number}/{topic}", schema=described, message_encoding="protobuf")
            found.append((channel, message))
    return found


def _serve(port: int, robots: int, rate: float) -> None:
    server = foxglove.start_server(port=port)
    channels, due = _channels(robots), time.monotonic()
    try:
        while True:
            for channel, message in channels:
                channel.log(message.encode())
            due += 1.0 / rate
            time.sleep(max(due - time.monotonic(), 0.0))
    finally:
        server.stop()


if __name__ == "__main__":
    _serve(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))
