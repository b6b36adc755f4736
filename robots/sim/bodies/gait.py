"""Gait of a person: how legs swing and where the body faces while the person moves."""

import math

from ppaas.geometry import wrap_angle
from robots.sim.bodies.body import HIP, BodyModel, Stance

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
