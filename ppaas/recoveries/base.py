"""Interface of recovery behaviours.

It follows ``nav_core::RecoveryBehavior``, but runs one control cycle per call: ``runBehavior`` blocks until it is done,
whereas here the goal can be cancelled, or the robot's pose be lost, while a behaviour runs.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import msgspec

from ppaas.controllers.base import Velocity
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D

Positive = Annotated[float, msgspec.Meta(gt=0.0, le=1e6)]
"""Type of a parameter that is above 0 and finite."""

NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]
"""Type of a parameter that is at least 0 and finite."""

AffectedMaps = Literal["local", "global", "both"]
"""Place in which obstacles are cleared: the window around the robot, the memory outside it, or both."""

Clear = Callable[[Pose2D, float, AffectedMaps], None]
"""Clears observed obstacles that are farther from a pose than a distance [m]."""


Fits = Callable[[Pose2D], bool]
"""Returns whether a robot touches nothing at a pose."""


class RecoveryFailed(PPaaSError):
    """The behaviour failed, or succeeded only in part; the next behaviour is tried."""

    slug = "recovery-failed"


@dataclass(frozen=True, slots=True)
class RecoveryRequest:
    """Input of one control cycle.

    Parameters
    ----------
    now : float
        Time, by the same clock in all cycles of a run [s].
    pose : Pose2D
        Pose of the robot in the frame of the costmap.
    costmap : Costmap
        Local costmap: a window around the robot.
    clear : callable
        Clears obstacles, see `Clear`.
    fits : callable, optional
        Returns whether the outline of a robot that is longer than wide touches nothing at a pose.
    """

    now: float
    pose: Pose2D
    costmap: Costmap
    clear: Clear
    fits: Fits | None = None


class Recovery(ABC):
    """A recovery behaviour, found by an entry point in the group ``ppaas.recoveries``.

    It may run many times, but only one run at once; ``start`` may be called again before a run has ended.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]

    @abstractmethod
    def start(self, request: RecoveryRequest) -> None:
        """Begin a run; ``step`` follows in the same cycle.

        Raises
        ------
        RecoveryFailed
            It cannot run here; the text says why.
        """

    @abstractmethod
    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return the velocity of this cycle, or None when it is done.

        Raises
        ------
        RecoveryFailed
            It cannot continue; the text says why.
        """
