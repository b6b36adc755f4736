"""Goals of the docking server, as checkpoints contain them."""

import math

import msgspec

from ppaas.docking.dock import MappedDock
from ppaas.docking.docking import DockingPhase
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.nav2_servers import DockPhase, DockRobotGoal, UndockRobotGoal
from ppaas.nodes import topics
from ppaas.nodes.docking_server.carried import Load
from ppaas.nodes.frames import MAP
from ppaas.nodes.message_checks import pose_in
from ppaas.nodes.nav2_actions import (
    BACKUP,
    DRIVE_ON_HEADING,
    FOLLOW_OBJECT,
    FOLLOW_PATH,
    NAVIGATE_THROUGH_POSES,
    SPIN,
    WAIT,
)
from ppaas.transforms.planar import TransformTree

OTHER_GOALS = (
    topics.MOVE_BASE_GOAL, topics.SIMPLE_GOAL, topics.GOAL_POSE, topics.WAYPOINTS_GOAL, NAVIGATE_THROUGH_POSES.goal,
    FOLLOW_PATH.goal, FOLLOW_OBJECT.goal, SPIN.goal, BACKUP.goal, DRIVE_ON_HEADING.goal, WAIT.goal,
)  # fmt: skip
"""Topics of goals that end docking, as they end each other."""

PHASES = {
    DockingPhase.STAGING: DockPhase.NAV_TO_STAGING_POSE,
    DockingPhase.PERCEIVING: DockPhase.INITIAL_PERCEPTION,
    DockingPhase.APPROACHING: DockPhase.CONTROLLING,
    DockingPhase.PRESSING: DockPhase.CONTROLLING,
    DockingPhase.WAITING: DockPhase.WAIT_FOR_CHARGE,
    DockingPhase.LIFTING: DockPhase.WAIT_FOR_CHARGE,
    DockingPhase.BACKING: DockPhase.RETRY,
}
"""States of Nav2's feedback, which has none for a lift."""


class DockGoal(msgspec.Struct, frozen=True):
    """Goal to dock.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    dock : str
        Name of the dock; empty for the nearest one.
    place : MappedDock, optional
        The dock itself, if the goal gives its pose.
    navigate : bool
        Whether the robot drives to the staging pose.
    staging_time : float
        Time for that [s].
    seconds : float
        Time that it took before this executor [s].
    """

    id: str
    stamp: float
    dock: str = ""
    place: MappedDock | None = None
    navigate: bool = True
    staging_time: float = 1000.0
    seconds: float = 0.0


class UndockGoal(msgspec.Struct, frozen=True):
    """Goal to undock; `seconds` as in `DockGoal`.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    dock_type : str
        Type of the dock; empty for the one that the robot stands at.
    allowance : float
        Time for it [s].
    start : Pose2D, optional
        Where the robot began, in the odometry frame.
    placed : str
        Where it has set its load down, in words; empty if it carried none.
    """

    id: str
    stamp: float
    dock_type: str = ""
    allowance: float = 30.0
    start: Pose2D | None = None
    seconds: float = 0.0
    placed: str = ""


class DockedAt(msgspec.Struct, frozen=True):
    """Dock at which the robot stands, and its pose there in the odometry frame."""

    dock: MappedDock
    pose: Pose2D


class DockingState(msgspec.Struct):
    """Checkpoint of the docking server; `near` says whether the robot was beyond the staging pose, `load` what it
    carries.
    """

    dock: DockGoal | None = None
    undock: UndockGoal | None = None
    docked: DockedAt | None = None
    near: bool = False
    counter: int = 0
    load: Load | None = None


def dock_goal(goal_id: str, stamp: float, asked: DockRobotGoal, tree: TransformTree, *, charges: bool) -> DockGoal:
    """Return a goal as a client gives it.

    Raises
    ------
    InvalidInput
        A number is not finite, or a pose has no frame.
    TransformError
        The frame of the pose is unknown.
    """
    seconds = asked.max_staging_time
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise InvalidInput(f"max_staging_time must be above 0 s, not {seconds}")
    place = None
    if not asked.use_dock_id:
        place = MappedDock("", pose_in(tree, MAP, asked.dock_pose, "the dock_pose"), asked.dock_type, charges)
    return DockGoal(goal_id, stamp, asked.dock_id, place, asked.navigate_to_staging_pose, seconds)


def undock_goal(goal_id: str, stamp: float, asked: UndockRobotGoal) -> UndockGoal:
    """Return a goal as a client gives it; ``InvalidInput`` if its time is not valid."""
    seconds = asked.max_undocking_time
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise InvalidInput(f"max_undocking_time must be above 0 s, not {seconds}")
    return UndockGoal(goal_id, stamp, asked.dock_type, seconds)
