"""Twin of the path integral controller's rollouts, written after their definition."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.kernels.mppi import CLOSING, Base, Critics, Terrain
from tests.reference.driving.outline import bilinear

Floats = NDArray[np.float64]


def cost_of_disc(
    commands: Floats, start: Floats, terrain: Terrain, base: Base, radius: float, critics: Critics
) -> float:
    """Return the cost of a command sequence for a disc."""
    distance, seconds, edge, movers = terrain
    x, y, theta, v, w, forward, turning = start.tolist()
    cost, steps = 0.0, len(commands)
    for k, (wanted_forward, wanted_turning) in enumerate(commands.tolist()):
        forward += np.clip(np.clip(wanted_forward, base.slowest, base.fastest) - forward, -base.step_x, base.step_x)
        most = base.max_vel_theta
        turning += np.clip(np.clip(wanted_turning, -most, most) - turning, -base.step_theta, base.step_theta)
        new_v, new_w = v + base.part * (forward - v), w + base.part * (turning - w)
        turned, way = 0.5 * (w + new_w) * base.dt, 0.5 * (v + new_v) * base.dt
        x += way * math.cos(theta + 0.5 * turned)
        y += way * math.sin(theta + 0.5 * turned)
        theta, v, w = theta + turned, new_v, new_w
        free, to_go = bilinear(distance, x, y, edge) - radius, bilinear(seconds, x, y, edge)
        if free < critics.least_clearance:
            return cost + critics.collision_cost * (2.0 - k / steps) + to_go
        speed = abs(v) / base.max_vel_x
        repulsion = critics.repulsion_weight * speed**2 * math.exp(-max(free, 0.0) / critics.inflation_length)
        repulsion = repulsion if free < 5.0 * critics.inflation_length else 0.0
        critical = critics.critical_weight * max(0.0, 1.0 - free / critics.critical_distance)
        backwards = critics.prefer_forward_weight * max(-v, 0.0) / base.max_vel_x
        moving = critics.moving_weight * sum(
            float(np.clip(1.0 - (math.dist((x, y), there) - r - radius) / critics.moving_distance, 0.0, 1.0))
            * (1.0 + CLOSING * max(0.0, v / base.max_vel_x * math.cos(_bearing(x, y, there) - theta)))
            for there, r in _where(movers, (k + 1) * base.dt)
        )
        cost += base.dt * (to_go + repulsion + critical + backwards + moving)
    return cost + to_go + critics.turn_weight * _turn(x, y, theta, seconds, edge, base) / base.max_vel_theta


def _bearing(x: float, y: float, there: tuple[float, float]) -> float:
    return math.atan2(there[1] - y, there[0] - x)


def _where(movers: Floats, seconds: float) -> list[tuple[tuple[float, float], float]]:
    return [((x + seconds * vx, y + seconds * vy), radius) for x, y, vx, vy, radius in movers.tolist()]


def _turn(x: float, y: float, theta: float, seconds: NDArray[np.float32], edge: float, base: Base) -> float:
    right, up = (
        bilinear(seconds, x - edge * dx, y - edge * dy, edge) - bilinear(seconds, x + edge * dx, y + edge * dy, edge)
        for dx, dy in ((1, 0), (0, 1))
    )
    steepness = min(1.0, math.hypot(right, up) * base.max_vel_x / (2.0 * edge))
    return abs(math.remainder(math.atan2(up, right) - theta, 2.0 * math.pi)) * steepness
