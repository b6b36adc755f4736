"""Base class of local planners that drive along a plan and stop at its end."""

from ppaas.controllers.arrival import ArrivalDetector
from ppaas.controllers.base import Controller, Velocity
from ppaas.controllers.drive_parameters import DriveParameters, body_of
from ppaas.controllers.followed_path import FollowedPath
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, Poses


class PathFollower(Controller):
    """Holds the plan, and detects arrival at its end.

    Parameters
    ----------
    parameters : DriveParameters
    """

    def __init__(self, parameters: DriveParameters) -> None:
        self._path: FollowedPath | None = None
        self._body = body_of(parameters.footprint, parameters.robot_radius)
        self._arrival = ArrivalDetector(parameters, self._body)

    def set_plan(self, poses: Poses) -> None:
        """Follow this plan from now on; a new plan to the same goal does not undo an arrival.

        Raises
        ------
        InvalidInput
            The plan is empty, has another shape than (n, 7), or is not finite.
        """
        path = FollowedPath(poses)
        if self._arrival.head_for(path.end):
            self._on_new_goal()
        self._path = path

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether the robot stands still at the end of the plan, within the tolerances."""
        return self._arrival.is_reached(pose, velocity, self._plan().end)

    def _on_new_goal(self) -> None:
        """Reset the state that belongs to a single goal."""

    def _plan(self) -> FollowedPath:
        if self._path is None:
            raise InvalidInput("no plan to follow: call set_plan first")
        return self._path
