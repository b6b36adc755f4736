"""Clones to check before a robot file is stored."""

import msgspec

from engine.specs.containers import RobotConfig

FIELDS = ("model", "base_global_planner", "base_local_planner", "parameters")
"""Fields of a robot file that its clone is built from."""


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
