"""Clones to check before a robot file is stored."""

from collections.abc import Mapping
from typing import Any

import msgspec

from engine.specs.containers import RobotConfig

DEFAULTS: Mapping[str, Any] = {
    "model": "turtlebot2", "base_global_planner": "dijkstra", "base_local_planner": "dwa", "parameters": {},
}  # fmt: skip
"""Fields of a robot file that its clone is built from, with their defaults."""


class CloneToCheck(msgspec.Struct, frozen=True):
    """Configuration of a robot whose clone is to be checked.

    Parameters
    ----------
    robot : RobotConfig
    resolution : float
        Edge of the cells of its map [m]; of no use if it makes its map.
    """

    robot: RobotConfig
    resolution: float

    @property
    def is_usual(self) -> bool:
        """Whether all parts of the file have their defaults, with which every robot is accepted."""
        robot = self.robot
        return robot.urdf is None and all(getattr(robot, name) == value for name, value in DEFAULTS.items())
