"""Goals that ``explore`` sends to Move Base, one at once, their outcomes, and the exploration in checkpoints."""

import dataclasses

import msgspec
import numpy as np
from msgspec.structs import replace

from ppaas.exploration.approaches import Approach
from ppaas.exploration.choice import NOBODY, choose, same_frontier
from ppaas.exploration.given_up import GivenUp, thinned
from ppaas.exploration.parameters import ExploreParameters
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseGoal
from ppaas.navigation.events import Goal
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.explore.known_map import Points, Survey
from ppaas.nodes.frames import MAP
from ppaas.planar_poses import moved_points

# -- exploration in progress, as checkpoints contain it ----------------------------------------------------------------

FAR = 1e9
"""Length of a path that is not known yet [m]."""


class ExplorationTarget(msgspec.Struct):
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
    target : ExplorationTarget, optional
        Where the robot drives; None while it looks around.
    arrived : ExplorationTarget, optional
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
    target: ExplorationTarget | None = None
    arrived: ExplorationTarget | None = None
    tiles: list[tuple[int, int]] = msgspec.field(default_factory=list)

    def next_goal(self, pose: Pose2D) -> Goal:
        """Return a pose as the next goal of Move Base, with a new id."""
        self.targets += 1
        return Goal(f"{self.id}/{self.targets}", pose, self.stamp)


# -- goals that the node ``explore`` sends to Move Base ----------------------------------------------------------------

FOLLOWED = 1.5
"""Distance by which a frontier may move away from a place on it and still be the same [m]."""

MOVED = 0.5
"""Distance by which the pose to see a frontier from must move before the robot is sent to the new one [m]."""

PROGRESS = 0.2
"""Least progress of a robot that is under way [m]."""


class ExplorationGoals:
    """Chooses targets from surveys, and sends them to Move Base.

    Parameters
    ----------
    context : Context
        Of the node.
    parameters : ExploreParameters
    exploration : Exploration
        Its target and its counts are kept up to date.

    Attributes
    ----------
    last_reason : str
        Why the last frontier was given up.
    """

    def __init__(self, context: Context, parameters: ExploreParameters, exploration: Exploration) -> None:
        self._context, self._parameters, self._exploration = context, parameters, exploration
        self.last_reason = ""
        self._given_up, self._failures = GivenUp(exploration.tiles), GivenUp()
        if exploration.target is not None:
            exploration.target.since = context.elapsed()

    @property
    def returning(self) -> bool:
        """Whether the robot drives back to its start."""
        target = self._exploration.target
        return target is not None and target.seen is None

    def move(self, motion: Pose2D) -> None:
        """Move all places with the map frame; the goal of Move Base moves there too."""
        exploration = self._exploration
        exploration.start = exploration.start and motion @ exploration.start
        exploration.target, exploration.arrived = (
            None if target is None else moved_target(target, motion)
            for target in (exploration.target, exploration.arrived)
        )
        self._given_up, self._failures = self._given_up.moved(motion), self._failures.moved(motion)
        exploration.tiles = self._given_up.tiles

    # -- choice --------------------------------------------------------------------------------------------------------

    def steer(self, surveyed: Survey, others: Points = NOBODY) -> str:
        """Send the robot to the best frontier of a survey; return what it does now, empty if no frontier is left.

        Parameters
        ----------
        surveyed : Survey
        others : (n, 2) array
            Positions of the other robots on the map, x, y [m].
        """
        exploration = self._exploration
        self._judge_arrival(surveyed)
        left = surveyed.without(self._given_up)
        exploration.area, exploration.frontiers = surveyed.area, len(left.approaches)
        if exploration.arrived is not None:
            return self._look_around(exploration.arrived)
        kept = self._followed(left)
        if kept is not None and self._is_stuck(kept):
            self.give_up("no progress")
            return self.steer(surveyed, others)
        chosen = choose(left.approaches, self._parameters, kept, others)
        if chosen is None:
            exploration.reached += exploration.target is not None
            return ""
        self._head_for(chosen, left.points_of(chosen), same=chosen is kept)
        x, y = chosen.pose[:2]
        return f"driving to a frontier at ({x:.1f}, {y:.1f})"

    def _followed(self, left: Survey) -> Approach | None:
        """Return the approach to the frontier that the robot drives to, if it is still there."""
        target = self._exploration.target
        if target is None or target.seen is None:
            return None
        return same_frontier(left.approaches, left.points, np.array(target.seen), FOLLOWED)

    def _is_stuck(self, approach: Approach) -> bool:
        """Return whether the robot has made no progress for too long; note its progress."""
        target, now = self._exploration.target, self._context.elapsed()
        assert target is not None
        if approach.distance < target.nearest - PROGRESS:
            target.nearest, target.since = approach.distance, now
        return now - target.since > self._parameters.progress_timeout

    def _head_for(self, approach: Approach, points: Points, *, same: bool) -> None:
        target = self._exploration.target
        places = thinned(points).tolist()
        if same and target is not None and target.goal.pose.distance_to(approach.pose) <= MOVED:
            target.points = places
            return
        if target is not None:
            self._exploration.reached += 1  # its frontier is gone, or has moved away: the robot has seen it
        since, nearest = self._context.elapsed(), approach.distance
        x, y = approach.seen.tolist()
        goal = self._exploration.next_goal(approach.pose)
        self._send(approach.pose, ExplorationTarget(goal, (x, y), places, nearest, since))

    # -- arrival -------------------------------------------------------------------------------------------------------

    def reached(self) -> None:
        """Note that the robot has reached its target: the frontier should disappear from the next map."""
        exploration = self._exploration
        exploration.reached += 1
        exploration.arrived, exploration.target = exploration.target, None

    def _judge_arrival(self, surveyed: Survey) -> None:
        """Forget where the robot has arrived if its frontier is gone; else let it turn, or give the frontier up."""
        exploration = self._exploration
        arrived = exploration.arrived
        if arrived is None:
            return
        stays = GivenUp()
        stays.add(np.array(arrived.points).reshape(-1, 2))
        left = [points for points in surveyed.without(self._given_up).points if stays.covers(points)]
        if left and not arrived.turned:
            return
        exploration.arrived = None
        for points in left:
            self._give_up(points)

    def _look_around(self, arrived: ExplorationTarget) -> str:
        """Turn the robot around once: a laser that sees less than a circle shows more then."""
        pose = arrived.goal.pose
        turned = Pose2D(pose.x, pose.y, wrap_angle(pose.theta + np.pi))
        goal = self._exploration.next_goal(turned)
        self._exploration.arrived = None
        self._send(
            turned, ExplorationTarget(goal, arrived.seen, arrived.points, FAR, self._context.elapsed(), turned=True)
        )
        return "looking around"

    # -- giving up -----------------------------------------------------------------------------------------------------

    def failed(self, reason: str) -> bool:
        """Drop a target whose goal Move Base aborted; return whether its frontier is given up: the second time.

        The map may have changed while the robot drove, so that the frontier has another pose to see it from now.
        """
        target = self._exploration.target
        assert target is not None and target.seen is not None
        points = np.array(target.points or [target.seen]).reshape(-1, 2)
        if self._failures.covers(points):
            self.give_up(reason)
            return True
        self._failures.add(points)
        self._exploration.target, self.last_reason = None, reason
        return False

    def give_up(self, reason: str) -> None:
        """Give up the frontier of the target, and drop the target."""
        target = self._exploration.target
        assert target is not None and target.seen is not None
        self._give_up(np.array(target.points or [target.seen]).reshape(-1, 2))
        self.drop()
        self.last_reason = reason

    def _give_up(self, points: Points) -> None:
        self._given_up.add(points)
        self._exploration.given_up += 1
        self._exploration.tiles = self._given_up.tiles

    # -- Move Base -----------------------------------------------------------------------------------------------------

    def return_to(self, start: Pose2D) -> None:
        """Send the robot back to its start."""
        goal = self._exploration.next_goal(start)
        self._send(start, ExplorationTarget(goal, since=self._context.elapsed()))

    def drop(self) -> None:
        """Cancel the goal of Move Base, if there is one; its result is ignored."""
        target, self._exploration.target = self._exploration.target, None
        if target is not None:
            self._context.publish(topics.MOVE_BASE_CANCEL.name, GoalID(id=target.goal.id))

    def _send(self, pose: Pose2D, target: ExplorationTarget) -> None:
        self._exploration.target = target
        stamped = PoseStamped(Header(stamp=Time.of(self._context.now()), frame_id=MAP), Pose.of(pose))
        goal_id = GoalID(Time.of(target.goal.stamp), target.goal.id)
        self._context.publish(topics.MOVE_BASE_GOAL.name, MoveBaseActionGoal(MoveBaseGoal(stamped), goal_id))


def moved_target(target: ExplorationTarget, motion: Pose2D) -> ExplorationTarget:
    """Return a target after a motion of the map frame."""
    goal = dataclasses.replace(target.goal, pose=motion @ target.goal.pose)
    points = moved_points(motion, np.array(target.points).reshape(-1, 2)).tolist()
    seen = None if target.seen is None else moved_points(motion, np.array([target.seen]))[0].tolist()
    return replace(target, goal=goal, points=list(map(tuple, points)), seen=None if seen is None else tuple(seen))
