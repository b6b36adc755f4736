"""The dock at which the robot stands, and whether it is charged there."""

from ppaas.docking.charge import ChargeReading
from ppaas.docking.watch import DockedWatch, has_left
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import String
from ppaas.nodes import topics
from ppaas.nodes.base import Context
from ppaas.nodes.docking_server.goals import DockedAt


class DockedRobot:
    """Keeps where the robot docked, and reports on ``docking_server/status`` how that goes.

    Parameters
    ----------
    context : Context
        Context of the node.
    patience : float
        Time after which a battery that is not charged is reported [s].

    Attributes
    ----------
    at : DockedAt or None
        Where it stands; None if it is not docked.
    carries : str
        What it carries, in words; empty if nothing.
    """

    def __init__(self, context: Context, patience: float) -> None:
        self.at: DockedAt | None = None
        self.carries = ""
        self._context, self._patience = context, patience
        self._watch: DockedWatch | None = None
        self._said = ""

    def is_charged_at(self, name: str) -> bool:
        """Return whether the robot stands at a dock of a name, or at any if it is empty, and is charged there."""
        return (
            self.at is not None and name in ("", self.at.dock.name) and self._watch is not None and self._watch.charges
        )

    def dock(self, at: DockedAt | None, threshold: float = 0.0) -> None:
        """Begin to watch a robot that has docked, with the current from which it counts as charged [A]; or end it."""
        self.at, self._watch = at, None
        if at is not None:
            self._watch = DockedWatch(at.dock, threshold, self._patience, self._context.elapsed())
        self.report()

    def take(self, reading: ChargeReading) -> None:
        """Take a reading of the battery."""
        if self._watch is not None:
            self._watch.take(reading)

    def look(self, odometry: Pose2D | None) -> None:
        """Look whether the robot is still there and charged, from time to time."""
        if self.at is not None and odometry is not None and has_left(self.at.pose, odometry):
            self.dock(None)
        elif self._watch is not None:
            self._watch.look(self._context.elapsed())
            self.report()

    def report(self) -> None:
        """Publish the status if it has changed."""
        watch = self._watch
        text = self.carries if watch is None else watch.problem or self.carries or watch.report
        if text != self._said:
            self._said = text
            self._context.publish(topics.DOCK_STATUS.name, String(text))
