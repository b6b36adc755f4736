"""Publisher of ``grid_slam/status``: the reason for which scans or parts of the map are left out."""

from ppaas.diagnosis.observations.scans import scan_facts
from ppaas.diagnosis.rules.scans import BLIND, missing_readings
from ppaas.diagnosis.rules.sensors import SCANS_ALONE
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.messages.base.std_msgs import String
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.frames import FrameListener


class StatusPublisher:
    """Publishes the status when it changes.

    Parameters
    ----------
    context : Context
        Of the node.

    Attributes
    ----------
    reported : str
        The newest status.
    """

    def __init__(self, context: Context) -> None:
        self._context, self.reported = context, ""

    def report(self, text: str) -> None:
        """Publish the reason for which scans or parts of the map are left out; empty if none is."""
        if text != self.reported:
            self.reported = text
            self._context.publish(topics.GRID_SLAM_STATUS.name, String(text))


def odometry_status(frames: FrameListener) -> str:
    """Return what a robot without odometry has to do without; empty if it has some."""
    return SCANS_ALONE if frames.is_without_odometry else ""


def lost_status(mapper: LiveMapper | None) -> str:
    """Return what to do for a robot that was carried away while it mapped; empty if its map is whole."""
    if mapper is None or mapper.parts.is_whole:
        return ""
    return "the robot was carried away: it maps where it is now until it recognizes a place where it was before"


def blindness_status(scan: LaserScan) -> str:
    """Return why a scan without a reading shows nothing, as the doctor says it, and what to do; empty if it shows some.

    Space without anything in range is unknown, unless ``inf_is_valid`` says that it is free.
    """
    problem = missing_readings(scan_facts(scan))
    if problem is None:
        return ""
    text, advice = problem
    return f"{BLIND}{text} {advice}"
