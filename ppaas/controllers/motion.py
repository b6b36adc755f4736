"""Motion of a base with limited acceleration in one control cycle."""

import math
from typing import Protocol

from ppaas.controllers.base import Velocity
from ppaas.geometry import Pose2D, wrap_angle


class TurnLimits(Protocol):
    """Parameters of a controller that limit braking and turning in place."""

    @property
    def acc_lim_x(self) -> float: ...  # noqa: D102
    @property
    def acc_lim_theta(self) -> float: ...  # noqa: D102
    @property
    def max_vel_theta(self) -> float: ...  # noqa: D102
    @property
    def min_vel_theta(self) -> float: ...  # noqa: D102


def advance(pose: Pose2D, velocity: Velocity, seconds: float) -> Pose2D:
    """Return the pose of a robot after it has kept a velocity for a time, along an arc."""
    turned = velocity.angular * seconds
    half = 0.5 * turned
    chord = velocity.linear * seconds * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    heading = pose.theta + half
    return Pose2D(
        pose.x + chord * math.cos(heading), pose.y + chord * math.sin(heading), wrap_angle(pose.theta + turned)
    )


def in_force(commanded: Velocity, measured: Velocity, limits: TurnLimits, late: float) -> Velocity:
    """Return the last command if the measured velocity, ``late`` seconds old, is consistent with it; otherwise that."""
    linear_off = abs(commanded.linear - measured.linear)
    angular_off = abs(commanded.angular - measured.angular)
    explained = linear_off <= limits.acc_lim_x * late and angular_off <= limits.acc_lim_theta * late
    return commanded if explained else measured


def brake(velocity: Velocity, limits: TurnLimits, period: float) -> Velocity:
    """Return the velocity after one cycle of braking, on the same arc as far as ``acc_lim_theta`` allows."""
    linear = towards(velocity.linear, 0.0, limits.acc_lim_x * period)
    part = linear / velocity.linear if linear else 0.0
    return Velocity(linear, towards(velocity.angular, part * velocity.angular, limits.acc_lim_theta * period))


def turn(error: float, velocity: Velocity, limits: TurnLimits, period: float) -> Velocity:
    """Return the velocity for turning in place by ``error`` [rad], slow enough to stop in time."""
    if abs(velocity.linear) > limits.acc_lim_x * period:
        return brake(velocity, limits, period)
    # Brakes with half of what is allowed, and never passes the target within a cycle, since odometry is late.
    fastest = min(limits.max_vel_theta, math.sqrt(limits.acc_lim_theta * abs(error)), abs(error) / (2.0 * period))
    wanted = math.copysign(max(fastest, limits.min_vel_theta), error)
    step = limits.acc_lim_theta * period
    if velocity.angular * wanted < 0.0:
        return Velocity(0.0, towards(velocity.angular, 0.0, step))
    turning = towards(velocity.angular, wanted, step)
    return Velocity(0.0, math.copysign(max(abs(turning), limits.min_vel_theta), wanted))


def towards(value: float, target: float, step: float) -> float:
    """Return the value moved towards a target by at most ``step``."""
    return value + min(step, max(-step, target - value))
