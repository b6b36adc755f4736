"""Slow, obvious twin of hybrid A*: nodes in a dictionary, a heap of the standard library, the twin of driving."""

import heapq
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.lattice.kernels.dubins import dubins
from ppaas.planners.lattice.kernels.reeds_shepp import MAX_PIECES, CurveWord, reeds_shepp, spell
from ppaas.planners.lattice.kernels.steering import Car
from tests.reference.planners import driving

Pose = tuple[float, float, float]
Piece = tuple[float, float]


@dataclass
class World:
    """The costmap and the robot."""

    costs: NDArray[np.uint8]
    rates: NDArray[np.float64]
    car: Car


@dataclass
class Node:
    """The cheapest pose of a cell and heading bin."""

    pose: Pose
    cost: float
    before: float
    key: float = 0.0
    closed: bool = False


def weigh(car: Car, piece: Piece, before: float) -> float:
    """Return the factor on the length of a piece that follows one of the curvature ``before``."""
    curvature, length = piece
    turning = 1.0 if curvature == 0 else car.turn + (0.0 if curvature * before > 0 else car.change)
    return turning * (car.reverse if length < 0 else 1.0)


def curve(car: Car, start: Pose, goal: Pose) -> tuple[float, list[Piece]]:
    """Return the cost of the cheapest curve without obstacles, and its pieces, in cells."""
    (x, y, theta), (gx, gy, gtheta) = start, goal
    dx, dy = (gx - x) / car.radius, (gy - y) / car.radius
    local = dx * math.cos(theta) + dy * math.sin(theta), dy * math.cos(theta) - dx * math.sin(theta), gtheta - theta
    words: list[CurveWord] = [dubins(*local, car.turn)]
    if car.backing:
        words.append(reeds_shepp(*local, car.reverse, car.turn))
    word = min(words, key=lambda w: w.cost)
    pieces = np.empty((MAX_PIECES, 2))
    count = spell(word, pieces)
    return word.cost * car.radius, [(k / car.radius, s * car.radius) for k, s in pieces[:count].tolist()]


def cost_of(world: World, start: Pose, pieces: list[Piece], before: float) -> float:
    """Return the cost of pieces; infinite in a collision."""
    total = 0.0
    for piece in pieces:
        total += driving.drive(world.costs, world.rates, start, piece) * weigh(world.car, piece, before)
        start, before = driving.pose_along(start, *piece), piece[0]
    return total


def search(
    world: World, field: NDArray[np.float64], motions: list[tuple[float, float, int]], start: Pose, goal: Pose,
    greed: float,
) -> tuple[float, int]:  # fmt: skip
    """Return the cost of the path, infinite if there is none, and the number of expanded nodes."""
    car = world.car

    def left(pose: Pose) -> float:
        around = field[math.floor(pose[1]), math.floor(pose[0])] / 50.0
        return max(around, curve(car, start=pose, goal=goal)[0] * world.rates[0])

    nodes = {(math.floor(start[1]), math.floor(start[0]), 0): Node(start, 0.0, math.nan)}
    queue = [(0.0, 0.0, next(iter(nodes)))]
    best, expanded, wait = math.inf, 0, 0
    while queue:
        key, _, name = heapq.heappop(queue)
        node = nodes[name]
        if node.closed or key != node.key:
            continue
        if best <= key:
            break
        node.closed = True
        expanded, wait = expanded + 1, wait - 1
        far = math.dist(node.pose[:2], goal[:2])
        if wait <= 0 and far <= car.longest:
            wait = int(far / car.ratio)
            _, pieces = curve(car, node.pose, goal)
            if sum(abs(length) for _, length in pieces) <= car.longest:
                before = 0.0 if math.isnan(node.before) else node.before
                best = min(best, node.cost + cost_of(world, node.pose, pieces, before))
        for curvature, length, turned in motions:
            before = curvature if math.isnan(node.before) else node.before
            cost = node.cost + cost_of(world, node.pose, [(curvature, length)], before)
            if math.isinf(cost):
                continue
            pose = driving.pose_along(node.pose, curvature, length)
            other = math.floor(pose[1]), math.floor(pose[0]), (name[2] + turned) % car.bins
            if other in nodes and (nodes[other].closed or nodes[other].cost <= cost):
                continue
            nodes[other] = Node(pose, cost, curvature, cost + greed * left(pose))
            heapq.heappush(queue, (nodes[other].key, left(pose), other))
    return best, expanded
