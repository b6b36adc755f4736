"""Reasons why the pose of a robot is unknown, in words for the status of its goals."""

import math

from ppaas.diagnosis.rules.sensors import SCANS_ALONE
from ppaas.errors import PPaaSError, TransformError
from ppaas.nodes.frames import ODOM, FrameListener


class PoseWatch:
    """Watches odometry, scans and localization of a robot.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.
    tolerance : float
        Largest age of localization and odometry [s].

    Attributes
    ----------
    moved_frame : (str, str)
        Frames that the last odometry message named, the one of the odometry and the one that it moves; empty before it.
    expects_scans : bool
        Whether localization is by scans of the robot. A robot that localizes itself says at once that it is not.
    localization : str
        Reason for which localization uses no scans, from its own report; empty while it uses them.
    """

    def __init__(self, frames: FrameListener, tolerance: float) -> None:
        self.moved_frame = "", ""
        self.localization = ""
        self._frames = frames
        self._tolerance = tolerance
        self.expects_scans = True
        self._scan_at = -math.inf
        self._odometry_at = -math.inf
        self._refused = self._refused_odometry = ""

    def odometry_came(self, now: float, parent: str, child: str) -> None:
        """Note odometry that can be used, with the frames that it names."""
        self.moved_frame, self._odometry_at, self._refused_odometry = (parent, child), now, ""

    def odometry_refused(self, error: PPaaSError) -> None:
        """Note odometry that cannot be used."""
        self._refused_odometry = f": odometry is refused: {error}"

    def scan_came(self, now: float) -> None:
        """Note a scan that can be used."""
        self._scan_at, self._refused = now, ""

    def scan_refused(self, error: PPaaSError) -> None:
        """Note a scan that cannot be used."""
        self._refused = f"scans are refused: {error}"

    def check(self, now: float) -> None:
        """Raise ``TransformError`` if odometry or localization is missing or too old; the text says what is missing."""
        if self.localization and not self.expects_scans:
            raise TransformError(f"not localized: {self.localization}")
        silence = self._frames.odometry_silence(now)
        if self._refused_odometry:
            silence = max(silence, now - self._odometry_at)
        if silence > self._tolerance:
            raise TransformError(self._without_odometry(silence))
        silence = self._frames.localization_silence(now)
        if silence > self._tolerance:
            reason = self._without_localization(now)
            raise TransformError(f"no localization {_since(silence)}{': ' if reason else ''}{reason}")

    def _without_odometry(self, silence: float) -> str:
        parent, child = self.moved_frame
        odom, base = self._frames.names.odom or ODOM, self._frames.base
        if self._frames.is_without_odometry:
            return SCANS_ALONE + self._refused_odometry
        if math.isfinite(silence) or self._refused_odometry:
            return f"no odometry {_since(silence)}{self._refused_odometry}"
        if not child:
            return f"no odometry yet: publish nav_msgs/Odometry on 'odom', or the transform {odom!r} → {base!r} on 'tf'"
        return (
            f"no odometry yet: no transform connects {odom!r} with {base!r}, but the odometry moves {child!r} in "
            f"{parent!r}: set odom_frame_id and base_frame_id of amcl (or odom_frame and base_frame of grid_slam) to "
            "these, or leave them out"
        )

    def _without_localization(self, now: float) -> str:
        silence = now - self._scan_at
        if not self.expects_scans:
            return self.localization
        if self._refused:
            return self._refused
        if silence > self._tolerance:
            return (
                f"the last scan came {silence:.1f} s ago"
                if math.isfinite(silence)
                else "no scan has come: publish sensor_msgs/LaserScan on 'scan'"
            )
        return self.localization


def _since(silence: float) -> str:
    return f"for {silence:.1f} s" if math.isfinite(silence) else "yet"
