"""Short- and long-term averages of scan likelihood, which show whether a robot may be lost.

Thrun, Burgard, Fox, *Probabilistic Robotics*, table 8.3 (augmented Monte Carlo localization).
"""

import numpy as np

AMISS = 0.1
"""Part by which the short-term average must fall below the long-term one to be significant."""


class FitAverages:
    """Exponential averages of how well scans fit the map, one over a long and one over a short time.

    Until 1/alpha scans have arrived, an average is their plain mean: otherwise the first scan would dominate the
    long-term average for a thousand scans.

    Parameters
    ----------
    slow, fast : float
        Weights (alpha) of the newest scan in the long-term and short-term averages; with 0, `amiss` is always False.
    """

    def __init__(self, slow: float, fast: float) -> None:
        self._alphas = np.array((slow, fast))
        self._averages = np.zeros(2)
        self._count = 0

    def note(self, fit: float) -> None:
        """Add a scan by its fit, averaged over the particles by weight."""
        self._count += 1
        parts = np.where(self._alphas > 0.0, np.maximum(self._alphas, 1.0 / self._count), 0.0)
        self._averages = self._averages + parts * (fit - self._averages)

    @property
    def amiss(self) -> bool:
        """Whether recent scans fit significantly worse than earlier ones."""
        slow, fast = self._averages
        return bool(fast < (1.0 - AMISS) * slow)

    def forget(self) -> None:
        """Start over without any scan."""
        self._averages = np.zeros(2)
        self._count = 0
