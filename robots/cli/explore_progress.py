"""Progress of a robot that explores, as lines."""

from collections.abc import Callable

from ppaas.messages.explore_msgs import ExploreFeedback
from robots.cli.output import duration, printable

EVERY = 5.0
"""Time between two lines while the robot does the same [s]."""


class ExploreProgress:
    """Writes a line when the robot does something else, and every `EVERY` seconds.

    Parameters
    ----------
    write : callable
        Called with each line.
    """

    def __init__(self, write: Callable[[str], None]) -> None:
        self._write = write
        self._text, self._next = "", 0.0

    def __call__(self, feedback: ExploreFeedback) -> None:
        """Take feedback."""
        seconds = feedback.exploration_time.seconds()
        if feedback.text != self._text or seconds >= self._next:
            self._text, self._next = feedback.text, seconds + EVERY
            self._write(line_of(feedback))


def line_of(feedback: ExploreFeedback) -> str:
    """Return a line of progress."""
    left = f"{feedback.frontiers} frontier{'' if feedback.frontiers == 1 else 's'}"
    given_up = f", {feedback.unreachable} given up" if feedback.unreachable else ""
    return (
        f"{duration(feedback.exploration_time.seconds()):>7}  {left}{given_up}, {feedback.area:.1f} m² known, "
        f"{feedback.distance:.1f} m driven: {printable(feedback.text)}"
    )
