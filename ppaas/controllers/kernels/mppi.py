"""Kernels: roll many command sequences out over a terrain, and tell what each would cost [s].

Model predictive path integral control after Williams et al., "Information theoretic MPC for model-based reinforcement
learning" (2017). The cost of a rollout is in seconds: those still to go from each of its steps, and penalties for being
fast where obstacles are near. All in the frame of the grid: metres from the corner of cell (0, 0), along its rows.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.controllers.kernels.clearance import Body, Field, Floats, between, clearance
from ppaas.maps.kernels.serial import serial_copy

NEGLIGIBLE = 5.0
"""An obstacle farther than so many inflation lengths does not repel."""
CLOSING = 4.0
"""What comes near is worse by so much more, at full speed, where it is the robot that drives up to it."""


class Terrain(NamedTuple):
    """What is driven over: (h, w) distances to obstacles [m] and seconds to go [s], and the edge of a cell [m].

    A row of the (m, 5) ``movers`` is one that moves there: x, y [m] when a rollout begins, velocity [m/s], radius [m].
    """

    distance: Field
    seconds: Field
    resolution: float
    movers: Floats


class Base(NamedTuple):
    """What the base can do, in one step of ``dt`` [s].

    Commands lie within ``slowest`` to ``fastest`` [m/s] and ±``max_vel_theta`` [rad/s] and change by ``step_x`` and
    ``step_theta`` at most; the motors make up for ``part`` of what is missing to the command. Costs of speed are
    measured by ``max_vel_x`` [m/s].
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
    """What counts for how much, as `ppaas.controllers.mppi.parameters` has it.

    ``least_clearance`` is what must be kept [m]: the margin, or what the robot has if that is less.
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


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_to_go(terrain: Terrain, x: float, y: float, cosine: float, sine: float, speed: float) -> float:
    """Return the angle from the heading to the way onwards [rad]; less where none leads on."""
    edge = terrain.resolution
    column, row = x / edge, y / edge
    left = between(terrain.seconds, column - 1.0, row)
    right = between(terrain.seconds, column + 1.0, row)
    below = between(terrain.seconds, column, row - 1.0)
    above = between(terrain.seconds, column, row + 1.0)
    onwards_x, onwards_y = left - right, below - above
    steepness = math.hypot(onwards_x, onwards_y) * speed / (2.0 * edge)
    angle = math.atan2(cosine * onwards_y - sine * onwards_x, cosine * onwards_x + sine * onwards_y)
    return abs(angle) * min(1.0, steepness)


@njit(cache=True, nogil=True, error_model="numpy")
def _near_movers(
    movers: Floats, seconds: float, x: float, y: float, ahead_x: float, ahead_y: float, reach: float, distance: float
) -> float:
    """Return how near a disc comes to all that move, after some time: each counts 1 where it touches, 0 so far away.

    It counts more where the disc moves towards it, by ``ahead``, its velocity as a part of the fastest: who cannot
    avoid to be touched had better stand.
    """
    near = 0.0
    for i in range(len(movers)):
        right = movers[i, 0] + seconds * movers[i, 2] - x
        up = movers[i, 1] + seconds * movers[i, 3] - y
        away = math.hypot(right, up)
        closing = max(0.0, ahead_x * right + ahead_y * up) / max(away, 1e-9)
        near += max(0.0, 1.0 - max(away - movers[i, 4] - reach, 0.0) / distance) * (1.0 + CLOSING * closing)
    return near


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(now: float, wanted: float, lowest: float, highest: float, step: float) -> float:
    wanted = min(max(wanted, lowest), highest)
    return min(max(wanted, now - step), now + step)


@njit(cache=True, nogil=True, error_model="numpy")
def roll_out(commands: Floats, start: Floats, terrain: Terrain, base: Base, body: Body, critics: Critics) -> float:
    """Return what one sequence of commands would cost [s], and bring its commands within the limits.

    Parameters
    ----------
    commands : (steps, 2) array
        Forward [m/s], turning [rad/s]; written to.
    start : (7,) array
        x, y [m], heading [rad], velocity driven (forward, turning), velocity commanded before (forward, turning).
    terrain, base, body, critics
        As their types say.
    """
    x, y, v, w, forward, turning = start[0], start[1], start[3], start[4], start[5], start[6]
    cosine, sine = math.cos(start[2]), math.sin(start[2])
    steps, edge = len(commands), terrain.resolution
    # How fast a turn can bring a corner nearer to what is beside; a disc comes no nearer by turning.
    lever = math.sqrt(max(body.circumscribed * body.circumscribed - body.inscribed * body.inscribed, 0.0))
    cost = 0.0
    for k in range(steps):
        forward = _follow(forward, commands[k, 0], base.slowest, base.fastest, base.step_x)
        turning = _follow(turning, commands[k, 1], -base.max_vel_theta, base.max_vel_theta, base.step_theta)
        commands[k, 0], commands[k, 1] = forward, turning
        v_before, w_before = v, w
        v += base.part * (forward - v)
        w += base.part * (turning - w)
        # Half the turn, the way, and the other half: the arc to second order. The sine of a small angle is a series.
        half = 0.25 * (w_before + w) * base.dt
        s = half - half * half * half / 6.0
        c = 1.0 - 0.5 * half * half + half * half * half * half / 24.0
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        way = 0.5 * (v_before + v) * base.dt
        x += way * cosine
        y += way * sine
        cosine, sine = c * cosine - s * sine, s * cosine + c * sine
        free = clearance(terrain.distance, edge, body, x, y, cosine, sine)
        to_go = between(terrain.seconds, x / edge, y / edge)
        if free < critics.least_clearance:
            # What would be hit later is less bad: there is more time to find a way round.
            return cost + critics.collision_cost * (2.0 - k / steps) + to_go
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
    turn = _turn_to_go(terrain, x, y, cosine, sine, base.max_vel_x)
    return cost + to_go + critics.turn_weight * turn / base.max_vel_theta


def _roll_out_all(
    commands: NDArray[np.float64], start: Floats, terrain: Terrain, base: Base, body: Body, critics: Critics
) -> Floats:
    costs = np.empty(len(commands))
    for i in prange(len(commands)):
        costs[i] = roll_out(commands[i], start, terrain, base, body, critics)
    return costs


RollOut = Callable[[NDArray[np.float64], Floats, Terrain, Base, Body, Critics], Floats]
"""(n, steps, 2) commands, written to as `roll_out` does, and what that takes → (n,) costs [s]."""

roll_out_parallel: RollOut = njit(cache=True, nogil=True, error_model="numpy", parallel=True)(_roll_out_all)
roll_out_serial: RollOut = njit(cache=True, nogil=True, error_model="numpy")(serial_copy(_roll_out_all))


@njit(cache=True, nogil=True, error_model="numpy")
def fill_blocked(seconds: Field, beside: float, far: float) -> None:
    """Give cells without a value one, so that there is something between them and their neighbours.

    Parameters
    ----------
    seconds : (h, w) array
        Infinite where nothing leads on; written to.
    beside : float
        More than the least of the neighbours [s].
    far : float
        Of cells whose neighbours have none either [s].
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
    """Compile and call each kernel once."""
    terrain = Terrain(np.ones((2, 2), np.float32), np.ones((2, 2), np.float32), 0.05, np.zeros((0, 5)))
    base = Base(0.05, 0.5, 0.5, 0.0, 1.5, 0.05, 0.15, 1.0)
    body = Body(np.zeros((0, 5)), 0.18, 0.18)
    critics = Critics(100.0, 0.0, 1.0, 0.1, 1.0, 0.1, 1.0, 1.0, 1.0, 0.3)
    for roll in (roll_out_parallel, roll_out_serial):
        roll(np.zeros((2, 2, 2)), np.zeros(7), terrain, base, body, critics)
    fill_blocked(np.ones((2, 2), np.float32), 1.0, 10.0)
