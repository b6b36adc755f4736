"""Figure of a person: a body that follows where the person moves, with the gait of its legs."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from robots.sim.bodies.body import HIP, BodyModel, Stance, body_shapes, leg_discs, random_body
from robots.sim.depth.shapes import Shapes

STILL = 0.08
"""Speed below which a person stands and may turn on the spot [m/s]."""
TURN_RATE = math.radians(240.0)
"""Fastest turn of a body [rad/s]."""
SETTLING = 0.25
"""Time in which the swing of the legs follows the speed [s]."""


class Gait:
    """Stance and heading of a person who moves.

    Parameters
    ----------
    body : BodyModel
    heading : float
        Direction in which the person faces at the start [rad].
    phase : float
        Phase of the gait at the start [rad].
    """

    def __init__(self, body: BodyModel, heading: float, phase: float = 0.0) -> None:
        self.heading = heading
        self._body = body
        self._phase = phase
        self._stride = 0.0

    @property
    def stance(self) -> Stance:
        """Momentary posture of a person who stands or walks."""
        return Stance(self._stride, self._phase)

    def move(self, velocity: tuple[float, float], dt: float, facing: float | None = None) -> None:
        """Advance by one step.

        Parameters
        ----------
        velocity : tuple of float
            Velocity [m/s].
        dt : float
            Length of the step [s].
        facing : float, optional
            Direction to face while standing [rad]; unchanged without one.
        """
        speed = math.hypot(*velocity)
        walking = speed > STILL
        wanted = math.atan2(velocity[1], velocity[0]) if walking else facing
        if wanted is not None:
            turn = wrap_angle(wanted - self.heading)
            self.heading = wrap_angle(self.heading + max(-TURN_RATE * dt, min(TURN_RATE * dt, turn)))
        aim = min(0.22 + 0.13 * speed, 0.45) if walking else 0.0
        self._stride += (aim - self._stride) * min(1.0, dt / SETTLING)
        if self._stride > 0.01:
            # Two steps of a gait take the body as far as its feet reach apart.
            length = 4.0 * HIP * self._body.height * math.sin(max(self._stride, 0.1))
            self._phase = math.fmod(self._phase + 2.0 * math.pi * speed * dt / length, 2.0 * math.pi)


LASER_HEIGHT = 0.2
"""Height of the plane of lasers [m]."""


class PersonFigure:
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
