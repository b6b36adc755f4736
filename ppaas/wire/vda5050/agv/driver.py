"""Drive of an AGV from node to node."""

import math
from collections.abc import Callable, Mapping

from ppaas.geometry import wrap_angle
from ppaas.wire.vda5050.agv import faults
from ppaas.wire.vda5050.agv.commands import Command, Drive, LimitSpeed, Outcome, RobotPose, Stop
from ppaas.wire.vda5050.agv.faults import fault
from ppaas.wire.vda5050.orders import Node
from ppaas.wire.vda5050.states import Error


class Driver:
    """Keeps the node to which the robot was ordered to drive, and the end of that drive.

    Parameters
    ----------
    command : callable
        Takes commands for the robot.

    Attributes
    ----------
    driving : bool
        Whether the robot was ordered to drive.
    goal : Node or None
        Node to which it drives, or drove until it was stopped.
    error : Error or None
        Why the robot did not reach the node; it stands until it is ordered to try again.
    """

    def __init__(self, command: Callable[[Command], None]) -> None:
        self._command = command
        self._number, self._speed = 0, 0.0
        self.driving = False
        self.goal: Node | None = None
        self.error: Error | None = None

    def drive(self, target: Node, pose: RobotPose | None) -> None:
        """Drive to a node; its heading is the direction of the way to it if it has none."""
        position = target.node_position
        assert position is not None  # orders without positions are refused
        theta = position.theta
        if theta is None:
            theta = _heading(pose, position.x, position.y)
        self._number += 1
        self.driving, self.goal = True, target
        self._command(Drive(self._number, position.x, position.y, wrap_angle(theta)))

    def stand(self) -> None:
        """Stop the robot, if it drives."""
        if self.driving:
            self.driving = False
            self._command(Stop())

    def limit(self, speed: float) -> None:
        """Limit the speed [m/s]; 0 for no limit."""
        if speed != self._speed:
            self._speed = speed
            self._command(LimitSpeed(speed))

    def ended(self, number: int, outcome: Outcome, reason: str, references: Mapping[str, str]) -> bool:
        """Note the end of a drive; return whether it is the current one, as those that were replaced are not."""
        if number != self._number or not self.driving:
            return False
        self.driving = False
        if outcome is Outcome.FAILED:
            text = reason or "the node was not reached"
            self.error = fault(faults.NODE_UNREACHABLE, "CRITICAL", text, references)
        return True

    def again(self) -> None:
        """Forget the failure of the last drive."""
        self.error = None


def _heading(pose: RobotPose | None, x: float, y: float) -> float:
    if pose is None:
        return 0.0
    return math.atan2(y - pose.y, x - pose.x) if pose.distance(x, y) > 1e-6 else pose.theta
