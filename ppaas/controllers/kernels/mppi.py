"""Kernels: roll out command sequences over a terrain, and compute the cost of each [s].

Model predictive path integral control after Williams et al., *Information Theoretic MPC for Model-Based Reinforcement
Learning* (2017). The cost of a rollout is in seconds: the mean travel time from its steps to the goal, and penalties
for speed near obstacles. Coordinates are in the frame of the grid: metres from the corner of cell (0, 0), x along the
rows.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import prange
from numpy.typing import NDArray

from ppaas.controllers.kernels.clearance import Field, Floats, RobotOutline, bilinear, clearance
from ppaas.kernel_cache.decorators import compiled
from ppaas.maps.kernels.serial import serial_copy

NEGLIGIBLE = 5.0
"""Distance beyond which the repulsion of an obstacle is neglected [inflation lengths]."""

CLOSING = 4.0
"""Additional weight of a moving obstacle if the robot drives towards it at full speed."""


class Terrain(NamedTuple):
    """Terrain of the rollouts.

    Parameters
    ----------
    distance : (h, w) float32 array
        Distance from each cell's centre to that of the nearest occupied cell [m].
    seconds : (h, w) float32 array
        Travel time from each cell to the goal [s].
    resolution : float
        Edge of a cell [m].
    movers : (m, 5) array
        Moving obstacles: x, y at the start of a rollout [m], vx, vy [m/s], radius [m].
    """

    distance: Field
    seconds: Field
    resolution: float
    movers: Floats


class Base(NamedTuple):
    """Kinematic limits of the base in a step of ``dt`` [s].

    Commands are limited to ``slowest`` … ``fastest`` [m/s] and ±``max_vel_theta`` [rad/s]; in a step they change by at
    most ``step_x`` [m/s] and ``step_theta`` [rad/s]. Motors reduce the difference to the command by ``part`` in each
    step. Costs of speed are relative to ``max_vel_x`` [m/s].
    """

    dt: float
    max_vel_x: float
    fastest: float
    slowest: float
    max_vel_theta: float
    step_x: float
    step_theta: float
    part: float


class Critics(NamedTuple):
    """Weights of the cost terms, see `ppaas.controllers.mppi.parameters.MppiParameters`.

    ``least_clearance`` is the clearance that must be kept [m]: ``collision_margin_distance``, or the current clearance
    if that is less.
    """

    collision_cost: float
    least_clearance: float
    critical_weight: float
    critical_distance: float
    repulsion_weight: float
    inflation_length: float
    prefer_forward_weight: float
    turn_weight: float
    moving_weight: float
    moving_distance: float


@compiled
def _turn_to_go(terrain: Terrain, x: float, y: float, cosine: float, sine: float, speed: float) -> float:
    """Return the angle from the heading to the direction in which the travel time decreases [rad].

    It is reduced where the travel time is flatter than at full speed, so where no direction leads on.
    """
    edge = terrain.resolution
    column, row = x / edge, y / edge
    left = bilinear(terrain.seconds, column - 1.0, row)
    right = bilinear(terrain.seconds, column + 1.0, row)
    below = bilinear(terrain.seconds, column, row - 1.0)
    above = bilinear(terrain.seconds, column, row + 1.0)
    onwards_x, onwards_y = left - right, below - above
    steepness = math.hypot(onwards_x, onwards_y) * speed / (2.0 * edge)
    angle = math.atan2(cosine * onwards_y - sine * onwards_x, cosine * onwards_x + sine * onwards_y)
    return abs(angle) * min(1.0, steepness)


@compiled
def _near_movers(
    movers: Floats, seconds: float, x: float, y: float, ahead_x: float, ahead_y: float, reach: float, distance: float
) -> float:
    """Return the sum of the proximities of moving obstacles after a time: each from 1 at contact to 0 at ``distance``.

    The proximity is up to 1 + `CLOSING` times as high if the robot drives towards the obstacle: a robot that cannot
    avoid a contact should stand still.

    Parameters
    ----------
    movers : (m, 5) array
        See `Terrain`.
    seconds : float
        Time since the start of the rollout [s].
    x, y : float
        Position of the robot [m].
    ahead_x, ahead_y : float
        Velocity of the robot relative to its top speed.
    reach : float
        Radius of the robot [m].
    distance : float
        Distance from which an obstacle has no effect [m].
    """
    near = 0.0
    for i in range(len(movers)):
        right = movers[i, 0] + seconds * movers[i, 2] - x
        up = movers[i, 1] + seconds * movers[i, 3] - y
        away = math.hypot(right, up)
        closing = max(0.0, ahead_x * right + ahead_y * up) / max(away, 1e-9)
        near += max(0.0, 1.0 - max(away - movers[i, 4] - reach, 0.0) / distance) * (1.0 + CLOSING * closing)
    return near


@compiled
def _follow(now: float, wanted: float, lowest: float, highest: float, step: float) -> float:
    """Return a command limited to its range, and to a change of at most ``step``."""
    wanted = min(max(wanted, lowest), highest)
    return min(max(wanted, now - step), now + step)


@compiled
def roll_out(
    commands: Floats, start: Floats, terrain: Terrain, base: Base, body: RobotOutline, critics: Critics
) -> float:
    """Return the cost of a command sequence [s], and limit its commands in place.

    Parameters
    ----------
    commands : (steps, 2) array
        Forward [m/s], turning [rad/s]; modified.
    start : (7,) array
        x, y [m], heading [rad], current velocity (forward [m/s], turning [rad/s]), and last command (the same).
    terrain, base, body, critics
        See their types.
    """
    x, y, v, w, forward, turning = start[0], start[1], start[3], start[4], start[5], start[6]
    cosine, sine = math.cos(start[2]), math.sin(start[2])
    steps, edge = len(commands), terrain.resolution
    # Lever arm by which turning brings a corner nearer to an obstacle beside the robot; 0 for a disc.
    lever = math.sqrt(max(body.circumscribed * body.circumscribed - body.inscribed * body.inscribed, 0.0))
    cost = 0.0
    for k in range(steps):
        # 1. Limit the command, and let the motors follow it.
        forward = _follow(forward, commands[k, 0], base.slowest, base.fastest, base.step_x)
        turning = _follow(turning, commands[k, 1], -base.max_vel_theta, base.max_vel_theta, base.step_theta)
        commands[k, 0], commands[k, 1] = forward, turning
        v_before, w_before = v, w
        v += base.part * (forward - v)
        w += base.part * (turning - w)
        # 2. Integrate the pose to second order: half the turn, the distance, the other half of the turn. Cosine and
        #    sine of the small angle are Taylor series.
        half = 0.25 * (w_before + w) * base.dt
        s = half - half * half * half / 6.0
        c = 1.0 - 0.5 * half * half + half * half * half * half / 24.0
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        distance = 0.5 * (v_before + v) * base.dt
        x += distance * cosine
        y += distance * sine
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        # 3. Collision: ends the rollout. A later one costs less, since there is more time to avoid it.
        free = clearance(terrain.distance, edge, body, x, y, cosine, sine)
        to_go = bilinear(terrain.seconds, x / edge, y / edge)
        if free < critics.least_clearance:
            return cost + critics.collision_cost * (2.0 - k / steps) + to_go
        # 4. Cost of the step: travel time to the goal, reversing, critical clearance, moving obstacles, and speed near
        #    obstacles.
        cost += base.dt * (to_go + critics.prefer_forward_weight * max(-v, 0.0) / base.max_vel_x)
        if free < critics.critical_distance:
            cost += base.dt * critics.critical_weight * (1.0 - free / critics.critical_distance)
        if len(terrain.movers) > 0:
            seconds = (k + 1) * base.dt
            part = v / base.max_vel_x
            near = _near_movers(
                terrain.movers, seconds, x, y, part * cosine, part * sine, body.circumscribed, critics.moving_distance
            )
            cost += base.dt * critics.moving_weight * near
        if free < NEGLIGIBLE * critics.inflation_length:
            speed = (abs(v) + lever * abs(w)) / base.max_vel_x
            near = math.exp(-max(free, 0.0) / critics.inflation_length)
            cost += base.dt * critics.repulsion_weight * speed * speed * near
    # 5. Final cost: remaining travel time, and the turn towards the path.
    turn = _turn_to_go(terrain, x, y, cosine, sine, base.max_vel_x)
    return cost + to_go + critics.turn_weight * turn / base.max_vel_theta


def _roll_out_all(
    commands: NDArray[np.float64], start: Floats, terrain: Terrain, base: Base, body: RobotOutline, critics: Critics
) -> Floats:
    costs = np.empty(len(commands))
    for i in prange(len(commands)):
        costs[i] = roll_out(commands[i], start, terrain, base, body, critics)
    return costs


RollOut = Callable[[NDArray[np.float64], Floats, Terrain, Base, RobotOutline, Critics], Floats]
"""Rolls out commands (n, steps, 2), which are limited in place; the other arguments as `roll_out`. Returns costs (n,)
[s]."""

roll_out_parallel: RollOut = compiled(parallel=True)(_roll_out_all)
roll_out_serial: RollOut = compiled(serial_copy(_roll_out_all))


@compiled
def fill_blocked(seconds: Field, beside: float, far: float) -> None:
    """Replace infinite travel times by finite ones, so that values can be interpolated between cells.

    Parameters
    ----------
    seconds : (h, w) float32 array
        Travel times, infinite in cells from which no path leads to the goal; modified.
    beside : float
        Time added to the smallest one of the eight neighbours [s].
    far : float
        Time of cells without a finite neighbour [s].
    """
    height, width = seconds.shape
    blocked = ~np.isfinite(seconds)
    for row in range(height):
        for column in range(width):
            if not blocked[row, column]:
                continue
            least = np.inf
            for r in range(max(row - 1, 0), min(row + 2, height)):
                for c in range(max(column - 1, 0), min(column + 2, width)):
                    if not blocked[r, c]:
                        least = min(least, seconds[r, c])
            seconds[row, column] = least + beside if least < far else far


def warm() -> None:
    """Call each kernel once, so that it is compiled or loaded from the cache."""
    terrain = Terrain(np.ones((2, 2), np.float32), np.ones((2, 2), np.float32), 0.05, np.zeros((0, 5)))
    base = Base(0.05, 0.5, 0.5, 0.0, 1.5, 0.05, 0.15, 1.0)
    body = RobotOutline(np.zeros((0, 5)), 0.18, 0.18)
    critics = Critics(100.0, 0.0, 1.0, 0.1, 1.0, 0.1, 1.0, 1.0, 1.0, 0.3)
    for roll in (roll_out_parallel, roll_out_serial):
        roll(np.zeros((2, 2, 2)), np.zeros(7), terrain, base, body, critics)
    fill_blocked(np.ones((2, 2), np.float32), 1.0, 10.0)
