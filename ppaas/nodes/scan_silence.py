"""Silence of localization: why a robot's pose is not renewed although no scan was refused."""

import math

from ppaas.nodes.frames import FrameListener

SILENT = 2.0
"""Time without a scan that is used after which the pose counts as not renewed [s]."""


ODOMETRY_SILENT = 0.8
"""Time without odometry after which it has stopped, and scans that are ahead of it do not blame the clocks [s].

It is shorter than ``robot_scans.MOST_AHEAD``, so that the first scan that is ahead of stopped odometry is judged
correctly.
"""


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
            return "no scan comes any more, or none that can be read"
        if self._frames.odometry_silence(now) <= SILENT:
            return "scans wait for odometry, whose stamps do not reach theirs: stamp both with the same clock"
        return self._lacks_odometry(now)

    def reason_ahead(self, problem: str, now: float) -> str:
        """Return why scans are ahead of the odometry: their clock, as ``problem`` says, or odometry that has stopped.

        Parameters
        ----------
        problem : str
            Text on the clocks; empty if no scan is ahead.
        now : float
            Time by the executor's clock [s].
        """
        if problem and self._frames.odometry_silence(now) > ODOMETRY_SILENT:
            return self._lacks_odometry(now)
        return problem

    def _lacks_odometry(self, now: float) -> str:
        why = "has not come" if math.isinf(self._frames.odometry_silence(now)) else "does not come any more"
        refused = f"; a transform is refused: {self._refused_transform}" if self._refused_transform else ""
        return f"scans wait for odometry, which {why} or is refused{refused}"
