"""Docks, and how robots stand at them."""

import math
from typing import NamedTuple

from ppaas.geometry import Pose2D
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Dock, ZoneSet


class MappedDock(NamedTuple):
    """Place where a robot charges, or takes over a load.

    Parameters
    ----------
    name : str
        Empty for a dock that a goal gives by its pose.
    pose : Pose2D
        Pose of a docked robot in the frame of the map.
    type : str
        Type of dock; empty for the robot's usual one.
    charges : bool
        Whether the battery of a docked robot is charged.
    """

    name: str
    pose: Pose2D
    type: str = ""
    charges: bool = True

    @property
    def in_words(self) -> str:
        """Name for texts."""
        return f"dock {self.name!r}" if self.name else f"the dock at ({self.pose.x:.2f}, {self.pose.y:.2f})"


class DockStance(NamedTuple):
    """How a docked robot stands before the face of its dock.

    The frame of a face has its origin in the middle of it, and x points into the dock.

    Parameters
    ----------
    distance : float
        Distance from the robot's origin to the face [m]; negative if the robot stands past it, as under a cart.
    backward : bool
        Whether the robot drives into the dock backwards.
    """

    distance: float
    backward: bool = False

    def face_of(self, docked: Pose2D) -> Pose2D:
        """Return the face of the dock at which a robot stands."""
        return docked @ self._face

    def docked_at(self, face: Pose2D) -> Pose2D:
        """Return the pose of a robot docked at a face."""
        return face @ self._face.inverse()

    @property
    def _face(self) -> Pose2D:
        return Pose2D(-self.distance, 0.0, math.pi) if self.backward else Pose2D(self.distance, 0.0)

    @property
    def ahead(self) -> float:
        """Sign of the velocity with which the robot drives into the dock."""
        return -1.0 if self.backward else 1.0


def docks_of(zones: ZoneSet) -> tuple[MappedDock, ...]:
    """Return the docks that are drawn on a map."""
    found = []
    for zone in zones.zones:
        if isinstance(zone.rule, Dock) and isinstance(zone.geometry, Point):
            x, y = zone.geometry.coordinates[:2]
            found.append(MappedDock(zone.name, Pose2D(x, y, zone.rule.yaw), zone.rule.dock_type, zone.rule.charges))
    return tuple(found)
