"""What a recovery behaviour is given and what it gives.

The interface of ``nav_core::RecoveryBehavior``, one control cycle at a time: ``runBehavior`` blocks until it is done,
and here a goal may be cancelled, or the robot's pose be lost, in the middle of it.
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
"""Of a parameter: above 0, and finite."""

NotNegative = Annotated[float, msgspec.Meta(ge=0.0, le=1e6)]

AffectedMaps = Literal["local", "global", "both"]
"""Where obstacles are forgotten: in the window around the robot, in what lies behind it, or in both."""

Clear = Callable[[Pose2D, float, AffectedMaps], None]
"""Forget the obstacles seen that are farther than so much [m] from a pose."""


class RecoveryFailed(PPaaSError):
    """The behaviour cannot do what it is for, or not all of it; the next one may."""

    slug = "recovery-failed"


@dataclass(frozen=True, slots=True)
class RecoveryRequest:
    """What is known at one control cycle, and what may be done about it.

    Parameters
    ----------
    now : float
        By the clock that all cycles of one run share [s].
    pose : Pose2D
        Of the robot, in the frame of the costmap.
    costmap : Costmap
        Local: a window around the robot.
    clear : callable
        Forgets obstacles.
    """

    now: float
    pose: Pose2D
    costmap: Costmap
    clear: Clear


class Recovery(ABC):
    """A recovery behaviour, found by an entry point in the group ``ppaas.recoveries``.

    It may be run many times, one run at a time; a run that was broken off is followed by another ``start``.
    """

    name: ClassVar[str]
    purpose: ClassVar[str]

    @abstractmethod
    def start(self, request: RecoveryRequest) -> None:
        """Begin a run; ``step`` follows in the same cycle.

        Raises
        ------
        RecoveryFailed
            It cannot be done here; the text says why.
        """

    @abstractmethod
    def step(self, request: RecoveryRequest) -> Velocity | None:
        """Return the velocity of this cycle, or None when it is done.

        Raises
        ------
        RecoveryFailed
            It cannot be gone on with; the text says why.
        """
