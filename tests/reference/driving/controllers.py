"""Twins of controllers: outlines, the plan ahead, arcs, and rollouts, written after their definitions."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from ppaas.controllers.kernels.dwa import Scoring
from ppaas.controllers.kernels.followed_path import LOST, MOST_POINTS, SEARCH_AHEAD, SPACING
from ppaas.controllers.kernels.mppi import CLOSING, Base, Critics, Terrain
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo

Floats = NDArray[np.float64]


def bilinear(field: NDArray[np.float32], x: float, y: float, edge: float) -> float:
    """Return a value interpolated between the centres of cells; outside, that of the nearest edge."""
    at = np.array([[y / edge - 0.5], [x / edge - 0.5]])
    return float(map_coordinates(field.astype(np.float64), at, order=1, mode="nearest")[0])


def outline_distance(
    lethal: NDArray[np.bool_], edge: float, corners: Floats, pose: tuple[float, float, float]
) -> float:
    """Return the distance of an outline to the centre of the nearest lethal cell, measured every millimetre."""
    placed = _placed(corners, pose)
    points = []
    for a, b in zip(placed, np.roll(placed, -1, axis=0), strict=True):
        count = max(2, round(float(np.hypot(*(b - a))) / 0.001))
        points.append(a + np.linspace(0.0, 1.0, count)[:, None] * (b - a))
    outline = np.concatenate(points)
    return float(min(np.hypot(*(outline - middle).T).min() for middle in _middles(lethal, edge)))


def outline_holds(lethal: NDArray[np.bool_], edge: float, corners: Floats, pose: tuple[float, float, float]) -> bool:
    """Return whether the centre of a lethal cell is in a convex outline with counterclockwise corners."""
    placed = _placed(corners, pose)
    sides = np.roll(placed, -1, axis=0) - placed
    return any(
        all(
            side[0] * (middle - corner)[1] >= side[1] * (middle - corner)[0]
            for corner, side in zip(placed, sides, strict=True)
        )
        for middle in _middles(lethal, edge)
    )


def _placed(corners: Floats, pose: tuple[float, float, float]) -> Floats:
    x, y, theta = pose
    rotation = np.array(((math.cos(theta), -math.sin(theta)), (math.sin(theta), math.cos(theta))))
    return corners @ rotation.T + (x, y)


def _middles(lethal: NDArray[np.bool_], edge: float) -> Floats:
    return (np.argwhere(lethal)[:, ::-1] + 0.5) * edge


def locate(points: Floats, along: Floats, reached: int, x: float, y: float) -> int:
    """Return the index of the point at which a robot is, after it was at ``reached``."""

    def nearest(first: int, last: int) -> tuple[int, float]:
        distances = np.hypot(points[first:last, 0] - x, points[first:last, 1] - y)
        found = int(np.argmin(distances))
        return first + found, float(distances[found])

    before, distance = -1, 0.0
    while reached > before:
        before = reached
        last = int(np.searchsorted(along, along[before] + SEARCH_AHEAD, side="right"))
        reached, distance = nearest(before, last)
    return nearest(0, len(points))[0] if distance > LOST else reached


def point_at(points: Floats, along: Floats, s: float) -> tuple[float, float]:
    """Return the point at a distance from the first, along the plan."""
    return float(np.interp(s, along, points[:, 0])), float(np.interp(s, along, points[:, 1]))


def points_ahead(points: Floats, along: Floats, reached: int, distance: float, info: GridInfo) -> tuple[Floats, Floats]:
    """Return the points ahead within a grid, and the distance from each to the last."""
    first, last = max(0.0, along[reached] - SPACING), min(along[-1], along[reached] + distance)
    s = np.linspace(first, last, min(MOST_POINTS, 2 + int((last - first) / SPACING)))
    ahead = np.stack([np.interp(s, along, points[:, axis]) for axis in (0, 1)], axis=-1)
    cells = info.to_cells(ahead)
    outside = ((cells < 0) | (cells >= info.shape)).any(axis=1)
    inside = max(1, int(np.argmax(outside)) if outside.any() else len(s))
    return ahead[:inside], s[inside - 1] - s[:inside]


def carrot(points: NDArray[np.float64], robot: tuple[float, float], distance: float) -> tuple[float, float]:
    """Return the first point of a path, sampled every millimetre, at a distance from the robot; otherwise the last.

    The segment between two points within the circle stays within it.
    """
    if math.dist(points[0], robot) >= distance:
        return float(points[0][0]), float(points[0][1])
    for a, b in itertools.pairwise(points):
        for part in np.linspace(0.0, 1.0, max(2, math.ceil(math.dist(a, b) / 0.001))):
            point = a + part * (b - a)
            if math.dist(point, robot) >= distance:
                return float(point[0]), float(point[1])
    return float(points[-1][0]), float(points[-1][1])


def arc(start: tuple[float, float, float], length: float, turn: float, count: int) -> list[tuple[float, float, float]]:
    """Return ``count + 1`` poses along an arc, the first and the last included."""
    x, y, theta = start
    poses = []
    for part in np.linspace(0.0, 1.0, count + 1).tolist():
        if abs(turn) < 1e-9:
            poses.append((x + part * length * math.cos(theta), y + part * length * math.sin(theta), theta))
            continue
        radius, heading = length / turn, theta + part * turn
        poses.append((
            x + radius * (math.sin(heading) - math.sin(theta)),
            y - radius * (math.cos(heading) - math.cos(theta)),
            heading,
        ))  # fmt: skip
    return poses


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
