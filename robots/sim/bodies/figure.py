"""Figure of a person: a body that follows where the person moves."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from robots.sim.bodies.body import BodyModel, Stance, body_shapes, leg_discs, random_body
from robots.sim.bodies.gait import Gait
from robots.sim.depth.shapes import Shapes

LASER_HEIGHT = 0.2
"""Height of the plane of lasers [m]."""


class Figure:
    """Body, gait and posture of one person.

    Parameters
    ----------
    rng : numpy.random.Generator
        Random generator of its size and first heading.

    Attributes
    ----------
    body : BodyModel
    sitting : bool
    facing : float, optional
        Direction to face while standing or sitting [rad].
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self.body: BodyModel = random_body(rng)
        self.sitting = False
        self.facing: float | None = None
        self._gait = Gait(self.body, float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(0.0, 2.0 * math.pi)))

    @property
    def heading(self) -> float:
        """Direction in which the person faces [rad]."""
        return self._gait.heading

    @property
    def stance(self) -> Stance:
        """Momentary posture."""
        return Stance(sitting=True) if self.sitting else self._gait.stance

    def face(self, heading: float) -> None:
        """Turn at once [rad]."""
        self._gait.heading = heading

    def move(self, velocity: tuple[float, float], dt: float) -> None:
        """Advance by a step of ``dt`` [s] at a velocity [m/s]."""
        self._gait.move(velocity, dt, self.facing)

    def shapes(self, x: float, y: float) -> Shapes:
        """Return the body at a position [m]."""
        return body_shapes(self.body, self.stance, Pose2D(x, y, self.heading))

    def legs(self, x: float, y: float) -> NDArray[np.float64]:
        """Return the legs at the height of lasers, (2, 3) x, y, radius [m]."""
        return leg_discs(self.body, self.stance, Pose2D(x, y, self.heading), LASER_HEIGHT)
