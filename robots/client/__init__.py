"""Clients of a cloud: WebSocket (rosbridge), Move Base and REST, and the files that they upload.

Each name is imported on first access, so a program that uses one client does not load the others.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from robots.client.move_base import MoveBaseClient
    from robots.client.rest import Login, RestClient
    from robots.client.robot_client import RobotClient
    from robots.client.robot_file import RobotFile, load_robot_file

__all__ = ["Login", "MoveBaseClient", "RestClient", "RobotClient", "RobotFile", "load_robot_file"]


def __getattr__(name: str) -> object:
    if name == "MoveBaseClient":
        from robots.client.move_base import MoveBaseClient  # noqa: PLC0415 - here and below: imported on first access

        return MoveBaseClient
    if name == "RobotClient":
        from robots.client.robot_client import RobotClient  # noqa: PLC0415

        return RobotClient
    if name in ("Login", "RestClient"):
        from robots.client import rest  # noqa: PLC0415

        return getattr(rest, name)
    if name in ("RobotFile", "load_robot_file"):
        from robots.client import robot_file  # noqa: PLC0415

        return getattr(robot_file, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
