"""A log of a drive in a room, in the text format of CARMEN graphs."""

import math
from itertools import pairwise

from ppaas.geometry import Pose2D
from tests.support.world.planar_world import World, walled_map

ROOM = walled_map(6, 5, [(3, 0, 3.2, 2), (4.5, 3.5, 5.5, 4), (1.5, 3.5, 2.0, 4.0)])
NOTHING = 81.0
"""Range of a beam that hits nothing [m]."""
START = Pose2D(1.0, 1.0, 0.8)


def graph_log(steps: int) -> str:
    """Return ``VERTEX2``, ``ROBOTLASER1`` and ``EDGE2`` lines of a circle in the room."""
    world, lines, odom = World(ROOM, START), ["#COMMENT"], []
    for number in range(steps):
        scan, pose = world.scan(0.0), _text(world.pose)
        ranges = [NOTHING if value is None else value for value in scan.ranges]
        lines.append(f"VERTEX2 {number} {pose}")
        lines.append(
            f"ROBOTLASER1 0 {scan.angle_min} {math.tau} {scan.angle_increment} 50.0 0.1 0 {len(scan.ranges)} "
            f"{' '.join(map(str, ranges))} 0 {pose} {pose} 0 0 0 0 0 {number * 0.5 + 10.0} x {number * 0.5}"
        )
        odom.append(world.odom)
        world.move(0.3, 0.25, 0.5)
    for number, (before, after) in enumerate(pairwise(odom)):
        lines.append(f"EDGE2 {number} {number + 1} {_text(before.inverse() @ after)} 1 0 1 1 0 0")
    return "\n".join([*lines, "EDGE2 0 5 1 1 0 1 0 1 1 0 0", ""])


def _text(pose: Pose2D) -> str:
    return " ".join(map(str, pose))
