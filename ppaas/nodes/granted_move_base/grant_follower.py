"""Grant follower: the local planner of a robot in traffic, which keeps to the granted way."""

from ppaas.controllers.base import Controller, ControlRequest, Velocity
from ppaas.geometry import Pose2D, Poses
from ppaas.nodes.granted_move_base.traffic_link import TrafficLink


class GrantFollower(Controller):
    """Drives by the robot's own local planner while the robot drives freely, and else along the granted way.

    Parameters
    ----------
    link : TrafficLink
    free : Controller
        Local planner of the robot.
    granted : Controller
        Local planner that stays on its path.
    """

    name = "traffic"
    purpose = "Stays on the way that the traffic of the map grants."
    predicts = True

    def __init__(self, link: TrafficLink, free: Controller, granted: Controller) -> None:
        self._link = link
        self._free, self._granted = free, granted
        self._in_use = granted

    def set_plan(self, poses: Poses) -> None:
        """Follow this plan (n, 7) from now on."""
        self._in_use = self._free if self._link.way.free else self._granted
        self._in_use.set_plan(poses)

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether the robot stands at its goal; the end of what is granted so far is none."""
        final = self._in_use is self._free or self._link.path_is_final
        return final and self._in_use.is_goal_reached(pose, velocity)

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return the velocity for this cycle; none for a robot that has to stop.

        Raises
        ------
        NoValidControl
            Something is in the way: the caller must stop.
        """
        if self._link.must_stop:
            return Velocity()
        return self._in_use.compute_velocity(request)
