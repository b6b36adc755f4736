"""The local plan: the path on which the velocity just sent leads the robot, for clients that show it."""

import numpy as np

from ppaas.controllers.base import Velocity
from ppaas.controllers.motion import advance
from ppaas.geometry import Pose2D, quaternion_of
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP
from ppaas.nodes.topics import LOCAL_PLAN
from ppaas.planners.path_json import path_message

AHEAD = 1.7
"""Time that the path covers, ``sim_time`` of dwa_local_planner [s]."""

STEPS = 17
"""Number of poses after the first."""


def publish_local_plan(context: Context, pose: Pose2D, velocity: Velocity) -> None:
    """Publish the arc of a velocity from a pose in the frame of the map, if anybody subscribes to it."""
    if context.has_subscribers(LOCAL_PLAN.name):
        context.publish(LOCAL_PLAN.name, local_plan(pose, velocity, context.now()))


def local_plan(pose: Pose2D, velocity: Velocity, now: float) -> Path:
    """Return the path of a robot that keeps a velocity, stamped ``now`` [s since the epoch]."""
    arc = [advance(pose, velocity, AHEAD * step / STEPS) for step in range(STEPS + 1)]
    rows = np.array([(at.x, at.y, 0.0, *quaternion_of(at.theta)) for at in arc])
    return path_message(rows, Header(stamp=Time.of(now), frame_id=MAP))
