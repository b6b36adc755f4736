"""State machine of a goal to undock: the robot sets its load down, and drives straight out of the dock."""

from ppaas.controllers.base import Velocity
from ppaas.docking.approach import BodyOutline, along_axis, is_in_way
from ppaas.docking.failures import DockingFailure, DockingTimeout, LiftFailed, lift_problem
from ppaas.docking.orders import STAND, Sight
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.geometry import Pose2D

REACHED = 0.02
"""Distance from the end of the way that counts as there [m]."""


class Undocking:
    """Drives a robot away from a dock, by the distance of its staging pose.

    Parameters
    ----------
    start : Pose2D
        Pose of the docked robot in the odometry frame.
    kind : DockType
        Type of the dock.
    parameters : DockingParameters
    body : BodyOutline
    braking : float
        Deceleration of the robot [m/s²].
    until : float
        Time until which it must be there [s].
    loaded : bool
        Whether the robot carries a load, which it sets down first.

    Attributes
    ----------
    text : str
        What the robot does, in words.
    lift : bool or None
        False if the lift is to be down; None if it is not used.
    """

    def __init__(
        self, start: Pose2D, kind: DockType, parameters: DockingParameters, body: BodyOutline, *, braking: float,
        until: float, loaded: bool = False,
    ) -> None:  # fmt: skip
        self.lift = False if loaded else None
        self._start, self._kind, self._parameters = start, kind, parameters
        self._body, self._braking, self._until = body, braking, until
        self._ahead = kind.stance(body).ahead
        self.text = "undocking"

    def step(self, sight: Sight) -> Velocity | DockingFailure | None:
        """Return what the robot does now, None once it is out of the dock."""
        if self.lift is False and sight.lifted is not False:
            self.text = "setting the load down"
            late = sight.now > self._until
            return LiftFailed(lift_problem(sight.lifted, up=False)) if late else STAND
        there = self._start.inverse() @ sight.odometry
        place = Pose2D(self._ahead * there.x, self._ahead * there.y, there.theta)
        goal = -self._kind.staging_distance
        if place.x <= goal + REACHED:
            return None
        if sight.now > self._until:
            return DockingTimeout(f"the robot is {-place.x:.2f} m out of the dock after its time: {self.text}")
        if sight.held:
            self.text = f"waiting: {sight.held}"
            return STAND
        velocity = along_axis(place, self._parameters.controller, to=goal, ahead=self._ahead)
        if sight.view is not None and is_in_way(sight.view.points, self._body, velocity, self._braking):
            self.text = "waiting: something is in the way"
            return STAND
        self.text = "undocking"
        return velocity
