"""Reasons why a robot is not docked, or not charged, with the codes of Nav2."""

from typing import ClassVar

from ppaas.errors import PPaaSError
from ppaas.messages.nav2_servers import DockError


class DockingFailure(PPaaSError):
    """The robot is not docked, or not charged."""

    slug = "docking-failed"
    code: ClassVar[DockError] = DockError.UNKNOWN
    curable: ClassVar[bool] = True
    """Whether another approach to the same dock may help."""


class DockUnknown(DockingFailure):
    """The map has no such dock."""

    slug = "dock-unknown"
    code = DockError.DOCK_NOT_IN_DB
    curable = False


class DockTypeUnknown(DockingFailure):
    """The robot has no settings for this type of dock."""

    slug = "dock-type-unknown"
    code = DockError.DOCK_NOT_VALID
    curable = False


class NotStaged(DockingFailure):
    """The robot is not at the pose before the dock."""

    slug = "dock-not-staged"
    code = DockError.FAILED_TO_STAGE
    curable = False


class DockNotSeen(DockingFailure):
    """The robot does not see the dock from the pose before it."""

    slug = "dock-not-seen"
    code = DockError.FAILED_TO_DETECT_DOCK


class DockLost(DockingFailure):
    """The robot saw the dock, and lost it while it drove there."""

    slug = "dock-lost"
    code = DockError.FAILED_TO_DETECT_DOCK


class DockNotReached(DockingFailure):
    """Something is in the way, or the robot does not move."""

    slug = "dock-not-reached"
    code = DockError.FAILED_TO_CONTROL


class ContactWithoutCharge(DockingFailure):
    """The robot stands at the dock, and its battery is not charged."""

    slug = "contact-without-charge"
    code = DockError.FAILED_TO_CHARGE


class ChargerLies(DockingFailure):
    """The battery reports that it is charged, while it is discharged."""

    slug = "charger-lies"
    code = DockError.FAILED_TO_CHARGE
    curable = False


class BatterySilent(DockingFailure):
    """Nothing is known of the battery."""

    slug = "battery-silent"
    code = DockError.FAILED_TO_CHARGE
    curable = False


class DockingTimeout(DockingFailure):
    """The time for undocking has passed."""

    slug = "docking-timeout"
    code = DockError.TIMEOUT


class LiftFailed(DockingFailure):
    """The lift does not report that it is up, or down."""

    slug = "lift-failed"
    curable = False


class LoadCarried(DockingFailure):
    """The robot carries a load already."""

    slug = "load-carried"
    code = DockError.DOCK_NOT_VALID
    curable = False


def lift_problem(lifted: bool | None, *, up: bool) -> str:
    """Return why a lift is not where it is wanted, up or down, by what it reports."""
    if lifted is None:
        return "the robot does not report whether its lift is up: publish lift_state"
    return f"the lift does not go {'up' if up else 'down'}"
