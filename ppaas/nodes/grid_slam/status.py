"""Publisher of ``grid_slam/status``: the reason for which scans or parts of the map are left out."""

from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.messages.base.std_msgs import String
from ppaas.nodes import topics
from ppaas.nodes.base import Context


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


def lost_status(mapper: LiveMapper | None) -> str:
    """Return what to do for a robot that was carried away while it mapped; empty if its map is whole."""
    if mapper is None or mapper.parts.is_whole:
        return ""
    return "the robot was carried away: it maps where it is now until it recognizes a place where it was before"
