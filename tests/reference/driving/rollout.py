"""Twin of the dynamic window's scoring, written after its definition."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.controllers.kernels.dwa import Scoring
from ppaas.costmap.costmap import Costmap


@dataclass
class Step:
    """Point of a rollout."""

    seconds: float
    x: float
    y: float
    theta: float
    cost: int


def score(
    costmap: Costmap,
    path: NDArray[np.float64],
    remaining: NDArray[np.float64],
    pose: tuple[float, float, float],
    velocity: tuple[float, float],
    how: Scoring,
) -> float:
    """Return the score of the rollout of one velocity; infinite if the robot could not stop in time."""
    speed = abs(velocity[0])
    must_be_free = how.reaction + speed / (2 * how.acc_lim_x)
    seconds = max(how.sim_time, must_be_free)
    leaving = how.leaving
    if leaving:
        seconds = max(seconds, how.way_out / max(speed, 0.05))
    steps = roll_out(costmap, pose, velocity, seconds, how)
    dt = seconds / len(steps)
    every = max(1, len(steps) // 8)
    way_out, distances, highest, to_go = 0.0, [], 0, 0.0
    for number, step in enumerate(steps, start=1):
        if step.cost == 254 or (step.cost == 253 and not leaving):
            before = step.seconds - dt
            return math.inf if leaving or before <= must_be_free else 1000 * (2 - before / seconds) + speed
        leaving = leaving and step.cost == 253
        way_out += speed * dt if leaving else 0.0
        highest = max(highest, step.cost)
        if number % every == 0 or number == len(steps):
            distance, to_go = nearest(path, remaining, step.x, step.y)
            distances.append(distance)
            if to_go <= 0 and step.seconds >= must_be_free:
                to_go = -speed * (seconds - step.seconds)
                break
    if leaving:
        return math.inf
    off_path = sum(distances) / len(distances)
    if to_go > how.forward_point_distance:
        ahead = how.forward_point_distance
        off_path += nearest(
            path, remaining, step.x + ahead * math.cos(step.theta), step.y + ahead * math.sin(step.theta)
        )[0]
    too_fast = max(0.0, speed - how.max_vel_x * (1 - how.cost_slowdown * highest / 253))
    return (
        how.path_distance_bias * off_path
        + how.goal_distance_bias * (to_go + 2 * how.sim_time * too_fast)
        + how.occdist_scale * highest
        + 1000 * way_out
    )


def roll_out(
    costmap: Costmap, pose: tuple[float, float, float], velocity: tuple[float, float], seconds: float, how: Scoring
) -> list[Step]:
    """Return the points reached while keeping a velocity."""
    (x, y, theta), (v, w) = pose, velocity
    count = max(1, math.ceil(abs(v) * seconds / how.sim_granularity), math.ceil(abs(w) * seconds / 0.1))
    dt = seconds / count
    steps = []
    for number in range(1, count + 1):
        middle = theta + w * dt / 2
        x, y, theta = x + v * dt * math.cos(middle), y + v * dt * math.sin(middle), theta + w * dt
        cost = cost_at(costmap, x, y)
        if cost == 255:
            cost = 0 if how.allow_unknown else 254
        steps.append(Step(number * dt, x, y, theta, cost))
    return steps


def cost_at(costmap: Costmap, x: float, y: float) -> int:
    """Return the cost at a point; 255 outside the costmap."""
    cell = costmap.info.cell_of(x, y)
    return 255 if cell is None else int(costmap.data[cell])


def nearest(path: NDArray[np.float64], remaining: NDArray[np.float64], x: float, y: float) -> tuple[float, float]:
    """Return the distance to a polyline, and the remaining distance from its nearest point."""
    found = [(math.dist(path[0], (x, y)), float(remaining[0]))]
    for (a, left_a), (b, left_b) in itertools.pairwise(zip(path, remaining, strict=True)):
        along = b - a
        t = float(np.clip(np.dot((x, y) - a, along) / np.dot(along, along), 0, 1)) if along.any() else 0.0
        found.append((math.dist(a + t * along, (x, y)), float(left_a + t * (left_b - left_a))))
    return min(found, key=lambda pair: pair[0])
