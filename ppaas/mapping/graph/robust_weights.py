"""Weights of edges by their errors: least squares, dynamic covariance scaling, graduated non-convexity."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TRUSTED = 0.3
"""Least weight of a closure that counts as part of the map; one with less contradicts the others."""


class WeightRule(Protocol):
    """Loss function of the edges, and the weights of its reweighted least squares."""

    def weights(self, chi2: Floats) -> Floats:
        """Return the weight (m,) of each edge: the derivative of the loss by its squared Mahalanobis distance."""
        ...

    def loss(self, chi2: Floats) -> float:
        """Return the total loss of the edges."""
        ...


class FixedWeights:
    """Least squares with given weights (m,)."""

    def __init__(self, weights: Floats) -> None:
        self._weights = weights

    def weights(self, chi2: Floats) -> Floats:
        """Return the given weights."""
        return self._weights

    def loss(self, chi2: Floats) -> float:
        """Return the weighted sum of the squared distances."""
        return float(self._weights @ chi2)


class CovarianceScaling:
    """Dynamic covariance scaling of closures (Agarwal et al., *Robust map optimization using DCS*, ICRA 2013).

    Parameters
    ----------
    closures : (m,) bool array
        Edges that may lose weight.
    limit : float
        Φ: squared Mahalanobis distance at which they start to.
    """

    def __init__(self, closures: NDArray[np.bool_], limit: float) -> None:
        self._closures, self._limit = closures, limit

    def weights(self, chi2: Floats) -> Floats:
        """Return the squared scales: min(1, 2 Φ / (Φ + χ²))²."""
        scales = np.where(self._closures, 2.0 * self._limit / (self._limit + chi2), 1.0)
        weights: Floats = np.minimum(1.0, scales) ** 2
        return weights

    def loss(self, chi2: Floats) -> float:
        """Return the sum of χ², or of 4 Φ χ² / (Φ + χ²) − Φ above Φ (MacTavish, Barfoot, *At all costs*, CRV 2015)."""
        scaled = 4.0 * self._limit * chi2 / (self._limit + chi2) - self._limit
        return float(np.where(self._closures & (chi2 > self._limit), scaled, chi2).sum())


def truncated_weights(chi2: Floats, limit: float, control: float) -> Floats:
    """Return the weights of graduated truncated least squares.

    Yang, Antonante, Tzoumas, Carlone, *Graduated non-convexity for robust spatial perception*, RA-L 5(2), 2020, eq. 14.

    Parameters
    ----------
    chi2 : (m,) array
        Squared Mahalanobis distances.
    limit : float
        Distance above which an edge is an outlier, c².
    control : float
        μ > 0: the loss is convex near 0, and truncated least squares in the limit.
    """
    inner, outer = control / (control + 1.0) * limit, (control + 1.0) / control * limit
    between = np.sqrt(limit * control * (control + 1.0) / np.maximum(chi2, inner)) - control
    weights: Floats = np.where(chi2 <= inner, 1.0, np.where(chi2 >= outer, 0.0, between))
    return weights
