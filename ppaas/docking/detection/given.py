"""Detectors that find nothing themselves: a pose of a topic, an AprilTag's pose, the pose on the map."""

import math
from typing import ClassVar

from ppaas.docking.detection.base import SEARCH, DockDetector, DockView
from ppaas.geometry import Pose2D, wrap_angle, yaw_of
from ppaas.transforms.spatial import matrix_of


class PoseOfTopic(DockDetector):
    """Takes the poses of ``detected_dock_pose``: x points into the dock.

    Parameters
    ----------
    translation_x, translation_y, rotation_yaw : float
        Pose of the face in the frame of the detected pose [m, rad].
    search : float
        Distance from where the face is expected up to which a pose counts [m].
    """

    name: ClassVar[str] = "pose"
    purpose: ClassVar[str] = "a pose on the topic detected_dock_pose, whose x points into the dock"

    def __init__(
        self, translation_x: float = 0.0, translation_y: float = 0.0, rotation_yaw: float = 0.0, search: float = SEARCH
    ) -> None:
        if not search > 0.0:
            raise ValueError("search must be above 0 m")
        self.translation_x, self.translation_y, self.rotation_yaw = translation_x, translation_y, rotation_yaw
        self.search = search

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the pose if it is near the expected one."""
        given = view.detected
        if given is None:
            return None
        pose = Pose2D(given.x, given.y, yaw_of(given.qx, given.qy, given.qz, given.qw))
        face = pose @ Pose2D(self.translation_x, self.translation_y, self.rotation_yaw)
        return face if expected.distance_to(face) <= self.search else None


UPRIGHT = 0.6
"""Largest slope of a tag's normal: a tag on a floor shows no direction."""


class AprilTag(DockDetector):
    """Takes the pose of a tag as detectors of AprilTags give it, in the frame of a camera or another.

    The normal of a tag is its z axis, which some detectors let point to the camera, and others into the tag. The face
    of the dock is where the tag is, and its x is the normal that points away from the robot.

    Parameters
    ----------
    translation_x, translation_y : float
        Place of the face, from the tag: into the dock, and to the left of that [m].
    search : float
        Distance from where the face is expected up to which a tag counts [m].
    """

    name: ClassVar[str] = "april_tag"
    purpose: ClassVar[str] = "the pose of an AprilTag on the topic detected_dock_pose, whose z is the tag's normal"

    def __init__(self, translation_x: float = 0.0, translation_y: float = 0.0, search: float = SEARCH) -> None:
        if not search > 0.0:
            raise ValueError("search must be above 0 m")
        self.translation_x, self.translation_y, self.search = translation_x, translation_y, search

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the face at the tag, if it is near the expected one."""
        given = view.detected
        if given is None:
            return None
        x, y, up = matrix_of(given)[:3, 2].tolist()
        if abs(up) > UPRIGHT:
            return None
        normal = math.atan2(y, x)
        if abs(wrap_angle(normal - expected.theta)) > 0.5 * math.pi:
            normal = wrap_angle(normal + math.pi)
        face = Pose2D(given.x, given.y, normal) @ Pose2D(self.translation_x, self.translation_y)
        return face if expected.distance_to(face) <= self.search else None


class MappedPose(DockDetector):
    """Trusts the map and the robot's localization, for docks that no sensor of the robot sees."""

    name: ClassVar[str] = "map"
    purpose: ClassVar[str] = "nothing: the dock is where the map has it, as exact as the robot is localized"

    def detect(self, view: DockView, expected: Pose2D) -> Pose2D | None:
        """Return the face by the map."""
        return view.mapped
