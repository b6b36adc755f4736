"""Silence of localization: why a robot's pose is not renewed although no scan was refused."""

import math

from ppaas.nodes.frames import FrameListener

SILENT = 2.0
"""Time without a scan that is used after which the pose counts as not renewed [s]."""


class ScanSilence:
    """Watches whether scans come and are used.

    Parameters
    ----------
    frames : FrameListener
        Frames of the robot.
    """

    def __init__(self, frames: FrameListener) -> None:
        self._frames = frames
        self._came_at = self._used_at = -math.inf
        self._refused_transform = ""

    def scan_came(self, now: float) -> None:
        """Note that a scan came, whether it can be used or not [s]."""
        self._came_at = now

    def scan_used(self, now: float) -> None:
        """Note that a scan was used [s]."""
        self._used_at, self._refused_transform = now, ""

    def transform_refused(self, error: Exception) -> None:
        """Note that a transform cannot be used."""
        self._refused_transform = str(error)

    def reason(self, now: float) -> str:
        """Return why no scan was used for `SILENT`; empty if one was, or if no scan has ever come.

        A robot that has never sent a scan may localize itself.
        """
        if now - self._used_at <= SILENT or not math.isfinite(self._came_at):
            return ""
        if now - self._came_at > SILENT:
            return "no scan comes any more"
        silence = self._frames.odometry_silence(now)
        if silence <= SILENT:
            return "scans wait for odometry, whose stamps do not reach theirs: stamp both with the same clock"
        why = "has not come" if math.isinf(silence) else "does not come any more"
        refused = f"; a transform is refused: {self._refused_transform}" if self._refused_transform else ""
        return f"scans wait for odometry, which {why} or is refused{refused}"
