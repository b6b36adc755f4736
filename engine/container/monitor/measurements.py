"""What was measured of a node and of the link, over the last while."""

from collections.abc import Mapping

import msgspec
import numpy as np

KEPT = 31
"""Measurements that are kept; the median of them is not moved by one that was held up."""


class History(msgspec.Struct):
    """The last measurements of one thing, which may go on elsewhere.

    Parameters
    ----------
    values : list of float
        Oldest first.
    """

    values: list[float] = msgspec.field(default_factory=list)

    def note(self, value: float) -> None:
        """Take a measurement; zero and less are none."""
        if value > 0.0:
            self.values = [*self.values[1 - KEPT :], value]

    @property
    def median(self) -> float | None:
        """The middle of those that are kept; None where there are none."""
        return float(np.median(self.values)) if self.values else None


class Rates:
    """How many bytes a second come on topics, as measured over some seconds at a time.

    Parameters
    ----------
    window : float
        Seconds over which bytes are counted.
    """

    def __init__(self, window: float = 5.0) -> None:
        self._window = window
        self._since: float | None = None
        self._bytes: dict[str, int] = {}
        self._rates: dict[str, float] = {}

    def note(self, topic: str, size: int) -> None:
        """Count a message."""
        self._bytes[topic] = self._bytes.get(topic, 0) + size

    def look(self, now: float) -> None:
        """Make rates of what was counted, once it was counted for long enough."""
        if self._since is None:
            self._since, self._bytes = now, {}
        elif now - self._since >= self._window:
            # A topic that fell silent keeps its rate: a laser that rests for a while would come back.
            self._rates |= {topic: size / (now - self._since) for topic, size in self._bytes.items()}
            self._since, self._bytes = now, {}

    def of(self, expected: Mapping[str, float]) -> dict[str, float]:
        """Return the rates of topics of which a robot sends one or several [bytes/s].

        Parameters
        ----------
        expected : mapping of str to float
            The topics, and the rate of each where none of them was measured yet [bytes/s].
        """
        measured = {topic: self._rates[topic] for topic in expected if topic in self._rates}
        return measured or dict(expected)
