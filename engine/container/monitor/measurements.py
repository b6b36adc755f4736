"""Measurements of nodes and of the link: medians of recent values, and data rates of topics."""

from collections.abc import Mapping

import msgspec
import numpy as np

KEPT = 31
"""Number of measurements that are kept; one delayed measurement does not affect their median."""


class History(msgspec.Struct):
    """Last measurements of one quantity; part of the node monitor's checkpoint.

    Parameters
    ----------
    values : list of float
        Oldest first.
    """

    values: list[float] = msgspec.field(default_factory=list)

    def note(self, value: float) -> None:
        """Add a measurement; values that are not positive are ignored."""
        if value > 0.0:
            self.values = [*self.values[1 - KEPT :], value]

    @property
    def median(self) -> float | None:
        """Median of the kept values; None if there are none."""
        return float(np.median(self.values)) if self.values else None


class TopicRates:
    """Data rates of topics, measured over windows of some seconds.

    Parameters
    ----------
    window : float
        Length of a window [s].
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
        """Update the rates from the counts, if the window has passed at time ``now`` [s]."""
        if self._since is None:
            self._since, self._bytes = now, {}
        elif now - self._since >= self._window:
            # A silent topic keeps its rate: a laser that pauses will send again.
            self._rates |= {topic: size / (now - self._since) for topic, size in self._bytes.items()}
            self._since, self._bytes = now, {}

    def of(self, expected: Mapping[str, float]) -> dict[str, float]:
        """Return the measured rates of alternative topics [bytes/s], or the expected ones if none was measured.

        Parameters
        ----------
        expected : mapping of str to float
            Expected rate of each topic [bytes/s]; a robot sends one or several of them.
        """
        measured = {topic: self._rates[topic] for topic in expected if topic in self._rates}
        return measured or dict(expected)
