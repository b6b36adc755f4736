"""Docks in ``ppaas robot``: docks a robot until it is charged, and undocks it."""

import argparse
from typing import TYPE_CHECKING, Any

from ppaas.errors import PPaaSError, Unavailable
from robots.cli.output import print_line, show
from robots.cli.session import add_session_arguments, logged_in, token_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.messages.nav2_servers import DockRobotFeedback

DOCK_COLUMNS = ("state", "text", "error_code", "num_retries")
UNDOCK_COLUMNS = ("state", "text", "error_code")
LACKING = "the robot has no node 'docking_server': the cloud is of an earlier release, or the robot is starting"

PHASES = {
    1: "driving to the staging pose",
    2: "looking for the dock",
    3: "driving to the dock",
    4: "waiting for charge",
    5: "backing off",
}
"""States of feedback in words."""


def configure_dock(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``ppaas robot dock``."""
    parser.add_argument("id")
    parser.add_argument("dock", nargs="?", default="", help="name of a dock of the map (the nearest; then the others)")
    parser.add_argument(
        "--pose", type=float, nargs=3, metavar=("X", "Y", "YAW"), help="pose of the docked robot [m, m, rad] instead"
    )
    parser.add_argument("--type", default="", metavar="TYPE", help="with --pose: type of the dock")
    add_session_arguments(parser)


def configure_undock(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``ppaas robot undock``."""
    parser.add_argument("id")
    parser.add_argument("--type", default="", metavar="TYPE", help="type of the dock, if the robot did not dock itself")
    add_session_arguments(parser)


async def dock(arguments: argparse.Namespace) -> None:
    """Dock a robot; Ctrl-C cancels.

    Raises
    ------
    PPaaSError
        The robot is not docked, or not charged; the text has the reason.
    """
    from ppaas.geometry import Pose2D  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.messages.base.std_msgs import Header  # noqa: PLC0415
    from ppaas.messages.geometry_msgs import Pose, PoseStamped  # noqa: PLC0415
    from ppaas.messages.nav2_servers import DockRobotGoal  # noqa: PLC0415
    from ppaas.nodes.nav2_actions import DOCK_ROBOT  # noqa: PLC0415

    goal = DockRobotGoal(dock_id=arguments.dock)
    if arguments.pose is not None:
        x, y, yaw = arguments.pose
        pose = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(x, y, yaw)))
        goal = DockRobotGoal(use_dock_id=False, dock_pose=pose, dock_type=arguments.type)
    said: set[str] = set()

    def tell(feedback: "DockRobotFeedback") -> None:
        text = PHASES.get(feedback.state, "")
        if text not in said and not arguments.json:
            print_line(text)
        said.clear()
        said.add(text)

    await _run(arguments, DOCK_ROBOT, goal, DOCK_COLUMNS, tell)


async def undock(arguments: argparse.Namespace) -> None:
    """Undock a robot; raises as `dock`."""
    from ppaas.messages.nav2_servers import UndockRobotGoal  # noqa: PLC0415 - as above
    from ppaas.nodes.nav2_actions import UNDOCK_ROBOT  # noqa: PLC0415

    await _run(arguments, UNDOCK_ROBOT, UndockRobotGoal(arguments.type), UNDOCK_COLUMNS)


async def _run(
    arguments: argparse.Namespace, topics: Any, goal: Any, columns: tuple[str, ...], tell: Any = None
) -> None:
    from ppaas.messages.actionlib_msgs import Status  # noqa: PLC0415 - as above
    from robots.client.action_client import ActionClient  # noqa: PLC0415
    from robots.client.robot_client import RobotClient  # noqa: PLC0415

    if not (await logged_in(arguments).get(path_of("robots", arguments.id, "state")))["connected"]:
        raise Unavailable(f"robot {arguments.id!r} is not connected: start it, and try again")
    async with RobotClient(
        arguments.url, robot=arguments.id, token=token_of(arguments), role="operator", hold=False
    ) as client:
        action: ActionClient[Any, Any] = ActionClient(client, topics, lacking=LACKING, on_feedback=tell)
        status, result = await action.run(goal)
    ended = {"state": Status(status.status).name.lower(), "text": status.text, "error_code": 0, "num_retries": 0}
    if result is not None:
        ended |= {name: getattr(result, name) for name in columns[2:]}
    show({name: ended[name] for name in columns}, columns, as_json=arguments.json)
    if status.status != Status.SUCCEEDED:
        raise _failed(ended)


def _failed(ended: dict[str, Any]) -> PPaaSError:
    return Unavailable(f"{ended['state']}: {ended['text'] or 'no reason was given'}")
