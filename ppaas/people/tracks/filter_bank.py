"""Filters of many people at once: interacting multiple models (IMM) of people who walk and who stand.

Source: Blom and Bar-Shalom, "The interacting multiple model algorithm for systems with Markovian switching
coefficients", IEEE Trans. Automatic Control 33 (1988).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


# -- motion models of people -------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class MotionModel:
    """Integrated Ornstein–Uhlenbeck process: a velocity that is forgotten with time, driven by white noise.

    For times well below ``memory`` it is the model of constant velocity with white noise in the acceleration. Unlike
    that, a prediction over a long time stops, and its speed stays a person's.

    Parameters
    ----------
    memory : float
        Time constant with which the velocity decays [s].
    speed : float
        Standard deviation of the velocity in the long run, along x and along y [m/s].
    """

    memory: float
    speed: float

    def moments(self, seconds: float) -> tuple[float, float, float, float, float]:
        """Return how a state changes in a time [s].

        Returns
        -------
        reach : float
            Displacement per velocity [s].
        decay : float
            Factor of the velocity.
        position, mixed, velocity : float
            Added variance of the position [m²], covariance [m²/s] and variance of the velocity [m²/s²] (Uhlenbeck and
            Ornstein, Phys. Rev. 36, 1930).
        """
        decay = float(np.exp(-seconds / self.memory))
        reach = self.memory * (1.0 - decay)
        square = self.speed**2
        inner = seconds - 2.0 * reach + 0.5 * self.memory * (1.0 - decay**2)
        return (
            reach,
            decay,
            2.0 * square * self.memory * max(inner, 0.0),
            square * self.memory * (1.0 - decay) ** 2,
            square * (1.0 - decay**2),
        )


@dataclass(frozen=True, slots=True)
class MotionParameters:
    """Motion of people for the interacting models.

    Parameters
    ----------
    walking, standing : MotionModel
    stays : float
        Mean time for which a person keeps walking, or standing [s].
    first_speed : float
        Standard deviation of the velocity of a person who was seen once, along x and along y [m/s].
    """

    walking: MotionModel = MotionModel(memory=8.0, speed=1.5)
    standing: MotionModel = MotionModel(memory=0.3, speed=0.08)
    stays: float = 4.0
    first_speed: float = 0.8

    def switching(self, seconds: float) -> float:
        """Return the probability that the model is another one after a time [s]."""
        return 0.5 * (1.0 - float(np.exp(-2.0 * seconds / self.stays)))


# -- filters of many people at once ------------------------------------------------------------------------------------

Rows = NDArray[np.intp]

MODELS = 2
"""Number of models: 0 walking, 1 standing."""
SMALLEST_WEIGHT = 1e-3
"""Least probability of a model, from which it can recover."""


class FilterBank:
    """States of n people, one row each; every method works on all of its rows at once.

    Parameters
    ----------
    parameters : MotionParameters

    Attributes
    ----------
    means : (n, 2, 4) array
        State x, y, vx, vy of each model [m, m/s].
    covariances : (n, 2, 4, 4) array
        Their covariances.
    weights : (n, 2) array
        Probability of each model.
    """

    def __init__(self, parameters: MotionParameters = MotionParameters()) -> None:
        self.parameters = parameters
        self.means: Array = np.zeros((0, MODELS, 4))
        self.covariances: Array = np.zeros((0, MODELS, 4, 4))
        self.weights: Array = np.zeros((0, MODELS))

    def __len__(self) -> int:
        return len(self.means)

    def add(self, positions: ArrayLike, covariances: ArrayLike) -> Rows:
        """Add people at (k, 2) positions [m] with (k, 2, 2) covariances [m²]; return their rows, the last ones."""
        at, spread = np.asarray(positions, np.float64), np.asarray(covariances, np.float64)
        count = len(at)
        means, new = np.zeros((count, MODELS, 4)), np.zeros((count, MODELS, 4, 4))
        means[:, :, :2] = at[:, np.newaxis]
        new[:, :, :2, :2] = spread[:, np.newaxis]
        speeds = self.parameters.first_speed, self.parameters.standing.speed
        for model, speed in enumerate(speeds):
            new[:, model, 2, 2] = new[:, model, 3, 3] = speed**2
        first = len(self)
        self.means = np.concatenate((self.means, means))
        self.covariances = np.concatenate((self.covariances, new))
        self.weights = np.concatenate((self.weights, np.full((count, MODELS), 1.0 / MODELS)))
        return np.arange(first, first + count)

    def keep(self, rows: ArrayLike) -> None:
        """Keep these rows alone, in this order; rows may be numbers or a mask."""
        kept = np.asarray(rows)
        self.means, self.covariances, self.weights = self.means[kept], self.covariances[kept], self.weights[kept]

    def predict(self, seconds: float) -> None:
        """Predict all people by a time [s]."""
        if seconds <= 0.0 or not len(self):
            return
        self._mix(self.parameters.switching(seconds))
        for model, motion in enumerate((self.parameters.walking, self.parameters.standing)):
            reach, decay, *noise = motion.moments(seconds)
            _propagate(self.means[:, model], self.covariances[:, model], reach, decay, noise)

    def _mix(self, switching: float) -> None:
        """Mix the models by the probability that a person changed from one to another (steps 1 and 2 of IMM)."""
        stay = np.array([[1.0 - switching, switching], [switching, 1.0 - switching]])
        joint = self.weights[:, :, np.newaxis] * stay
        ahead = joint.sum(axis=1)
        share = joint / ahead[:, np.newaxis]
        means = np.einsum("nij,nik->njk", share, self.means)
        apart = self.means[:, :, np.newaxis] - means[:, np.newaxis]
        spread = self.covariances[:, :, np.newaxis] + apart[..., :, np.newaxis] * apart[..., np.newaxis, :]
        self.covariances = (share[..., np.newaxis, np.newaxis] * spread).sum(axis=1)
        self.means, self.weights = means, ahead

    def update(self, rows: ArrayLike, positions: ArrayLike, covariances: ArrayLike) -> None:
        """Update people by one measured position each.

        Parameters
        ----------
        rows : (k,) array
            Different rows.
        positions : (k, 2) array
            Measured x, y [m].
        covariances : (k, 2, 2) array
            Their covariances [m²].
        """
        at = np.asarray(rows, np.intp)
        if not len(at):
            return
        seen, noise = np.asarray(positions, np.float64), np.asarray(covariances, np.float64)
        means, spread = self.means[at], self.covariances[at]
        cross = spread[..., :2]
        total = spread[..., :2, :2] + noise[:, np.newaxis]
        inverse, determinant = inverse_2x2(total)
        off = seen[:, np.newaxis] - means[..., :2]
        gain = cross @ inverse
        square = np.einsum("nmi,nmij,nmj->nm", off, inverse, off)
        self.means[at] = means + (gain @ off[..., np.newaxis])[..., 0]
        corrected = spread - gain @ np.swapaxes(cross, -1, -2)
        self.covariances[at] = 0.5 * (corrected + np.swapaxes(corrected, -1, -2))
        self.weights[at] = _reweighed(self.weights[at], -0.5 * (square + np.log(determinant)))

    def states(self) -> tuple[Array, Array]:
        """Return the (n, 4) states over all models, and their (n, 4, 4) covariances."""
        mean = np.einsum("nm,nmk->nk", self.weights, self.means)
        apart = self.means - mean[:, np.newaxis]
        spread = self.covariances + apart[..., :, np.newaxis] * apart[..., np.newaxis, :]
        return mean, np.einsum("nm,nmij->nij", self.weights, spread)

    def copy(self, source: int, target: int) -> None:
        """Make one row the same as another."""
        for array in (self.means, self.covariances, self.weights):
            array[target] = array[source]


def inverse_2x2(matrices: Array) -> tuple[Array, Array]:
    """Return the inverses of (…, 2, 2) symmetric positive definite matrices, and their determinants (…)."""
    a, b, d = matrices[..., 0, 0], matrices[..., 0, 1], matrices[..., 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-18)
    inverse = np.empty_like(matrices)
    inverse[..., 0, 0], inverse[..., 1, 1] = d / determinant, a / determinant
    inverse[..., 0, 1] = inverse[..., 1, 0] = -b / determinant
    return inverse, determinant


def squared_distances(off: Array, covariances: Array) -> Array:
    """Return the squared Mahalanobis distances (…) of differences (…, 2) [m] with covariances (…, 2, 2) [m²]."""
    inverse, _ = inverse_2x2(covariances)
    x, y = off[..., 0], off[..., 1]
    return inverse[..., 0, 0] * x * x + 2.0 * inverse[..., 0, 1] * x * y + inverse[..., 1, 1] * y * y


def _propagate(means: Array, covariances: Array, reach: float, decay: float, noise: list[float]) -> None:
    """Propagate (n, 4) states and their (n, 4, 4) covariances in place."""
    means[:, :2] += reach * means[:, 2:]
    means[:, 2:] *= decay
    step = np.eye(4)
    step[0, 2] = step[1, 3] = reach
    step[2, 2] = step[3, 3] = decay
    covariances[:] = step @ covariances @ step.T
    position, mixed, velocity = noise
    for axis in (0, 1):
        covariances[:, axis, axis] += position
        covariances[:, axis + 2, axis + 2] += velocity
        covariances[:, axis, axis + 2] += mixed
        covariances[:, axis + 2, axis] += mixed


def _reweighed(weights: Array, log_likelihoods: Array) -> Array:
    """Return the (n, 2) probabilities of the models after measurements with these log-likelihoods."""
    relative = np.exp(log_likelihoods - log_likelihoods.max(axis=1, keepdims=True))
    product = np.maximum(weights * relative, SMALLEST_WEIGHT)
    normalized: Array = product / product.sum(axis=1, keepdims=True)
    return normalized
