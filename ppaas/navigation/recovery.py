"""What Move Base tries when it is stuck, in the order of move_base: clear far obstacles, turn, clear all, turn."""

import math
from collections.abc import Callable
from typing import Protocol

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.navigation.orders import ClearCostmap
from ppaas.navigation.parameters import MoveBaseParameters


class Recovery(Protocol):
    """A recovery under way."""

    def start(self) -> list[ClearCostmap]:
        """Return what to do at once."""
        ...

    def tick(self, now: float, pose: Pose2D) -> Velocity | None:
        """Return the velocity of this control cycle, or None when it is done."""
        ...


class ResetRecovery:
    """Clears what sensors saw farther away than a distance; done when that has been answered.

    Parameters
    ----------
    beyond : float
        [m].
    """

    def __init__(self, beyond: float) -> None:
        self._beyond = beyond

    def start(self) -> list[ClearCostmap]:
        """Clear."""
        return [ClearCostmap(self._beyond)]

    def tick(self, now: float, pose: Pose2D) -> Velocity | None:
        """Stand still while waiting for the answer."""
        return Velocity()


class RotateRecovery:
    """Turns once round on the spot, so that the laser sees what is behind.

    Speeds follow ``rotate_recovery.cpp``: as fast as the rest of the turn lets it brake. A round robot that turns on
    the spot touches nothing it did not touch before, so nothing is checked.

    Parameters
    ----------
    parameters : MoveBaseParameters
        Its limits of turning.
    """

    def __init__(self, parameters: MoveBaseParameters) -> None:
        self._parameters = parameters
        self._left = 2.0 * math.pi
        self._heading: float | None = None
        self._began = 0.0

    def start(self) -> list[ClearCostmap]:
        """Wait for the first cycle."""
        return []

    def tick(self, now: float, pose: Pose2D) -> Velocity | None:
        """Turn on, until once round or out of patience."""
        if self._heading is None:
            self._began = now
        else:
            self._left -= wrap_angle(pose.theta - self._heading)
        self._heading = pose.theta
        p = self._parameters
        if self._left <= 0.0 or now - self._began > p.rotation_patience:
            return None
        speed = math.sqrt(2.0 * p.acc_lim_th * self._left)
        return Velocity(0.0, min(max(speed, p.min_rotational_vel), p.max_rotational_vel))


def recoveries(parameters: MoveBaseParameters) -> tuple[tuple[str, Callable[[], Recovery]], ...]:
    """Return the names of the recoveries and how to make each, in order (``loadDefaultRecoveryBehaviors``)."""
    if not parameters.recovery_behavior_enabled:
        return ()
    conservative = ("conservative_reset", lambda: ResetRecovery(parameters.conservative_reset_dist))
    rotate = ("rotate_recovery", lambda: RotateRecovery(parameters))
    aggressive = ("aggressive_reset", lambda: ResetRecovery(0.0))
    if not parameters.clearing_rotation_allowed:
        return conservative, aggressive
    return conservative, rotate, aggressive, rotate
