"""When a robot counts as lost: where its scans fit worse of late than they did.

Thrun, Burgard, Fox, *Probabilistic Robotics*, table 8.3 (augmented Monte Carlo localization).
"""

import numpy as np

AMISS = 0.1
"""Scans fit now better and now worse: only a short average that is by this part below the long one tells something."""


class FitAverages:
    """How well scans fit, on average over long and over short, and what that says.

    Until there are as many scans as an average is over, it is their mean: else the long one would be for a thousand
    scans what the first one happened to be.

    Parameters
    ----------
    slow, fast : float
        Part of an average that the newest scan is; with 0, nothing is ever amiss.
    """

    def __init__(self, slow: float, fast: float) -> None:
        self._alphas = np.array((slow, fast))
        self._averages = np.zeros(2)
        self._count = 0

    def note(self, fit: float) -> None:
        """Take note of how well a scan fits, weighed over the particles."""
        self._count += 1
        parts = np.where(self._alphas > 0.0, np.maximum(self._alphas, 1.0 / self._count), 0.0)
        self._averages = self._averages + parts * (fit - self._averages)

    @property
    def amiss(self) -> bool:
        """Tell whether scans fit worse of late."""
        slow, fast = self._averages
        return bool(fast < (1.0 - AMISS) * slow)

    def forget(self) -> None:
        """Begin anew."""
        self._averages = np.zeros(2)
        self._count = 0
