"""Motion models of people: walking, at a nearly constant velocity, and standing."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
