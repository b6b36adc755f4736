"""Exploration in progress, as checkpoints contain it."""

import msgspec

from ppaas.geometry import Pose2D
from ppaas.navigation.events import Goal

FAR = 1e9
"""Length of a path that is not known yet [m]."""


class Target(msgspec.Struct):
    """Pose that the robot drives to.

    Parameters
    ----------
    goal : Goal
        The goal of Move Base.
    seen : (float, float), optional
        Place on the frontier that it is to see, x, y [m]; None if the robot drives back to its start.
    points : list of (float, float)
        Tiles that the frontier is in, by their centres x, y [m].
    nearest : float
        Shortest remaining path so far [m].
    since : float
        Time at which it was reached, by the clock of the executor [s].
    turned : bool
        Whether the robot turned to see more.
    """

    goal: Goal
    seen: tuple[float, float] | None = None
    points: list[tuple[float, float]] = msgspec.field(default_factory=list)
    nearest: float = FAR
    since: float = 0.0
    turned: bool = False


class Exploration(msgspec.Struct):
    """Goal of the action ``explore``, with its progress.

    Parameters
    ----------
    id, stamp
        As of any action's goal.
    return_to_start : bool
        Whether the robot drives back at the end.
    start : Pose2D, optional
        Pose of the robot when the goal came, in the map frame; None while it is not known.
    seconds : float
        Time spent until the checkpoint [s].
    distance : float
        Distance driven [m].
    targets : int
        Number of goals sent to Move Base.
    reached : int
        Number of them that the robot reached, or whose frontier it saw before.
    given_up : int
        Number of frontiers that the robot gave up.
    frontiers : int
        Number of frontiers left.
    area : float
        Known area of the map [m²].
    target : Target, optional
        Where the robot drives; None while it looks around.
    arrived : Target, optional
        Where the robot has arrived; its frontier should disappear from the map.
    tiles : list of (int, int)
        Places that the robot gave up.
    """

    id: str
    stamp: float
    return_to_start: bool = False
    start: Pose2D | None = None
    seconds: float = 0.0
    distance: float = 0.0
    targets: int = 0
    reached: int = 0
    given_up: int = 0
    frontiers: int = 0
    area: float = 0.0
    target: Target | None = None
    arrived: Target | None = None
    tiles: list[tuple[int, int]] = msgspec.field(default_factory=list)

    def next_goal(self, pose: Pose2D) -> Goal:
        """Return a pose as the next goal of Move Base, with a new id."""
        self.targets += 1
        return Goal(f"{self.id}/{self.targets}", pose, self.stamp)
