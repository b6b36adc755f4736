"""Slow, obvious twins of the kernels of localization."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo


def sample_motion(particles, first_turn, distance, second_turn, alphas, normals):
    """Probabilistic Robotics, table 5.6, one particle after the other."""

    def from_straight(turn):
        return min(abs(math.remainder(turn, 2 * math.pi)), abs(math.remainder(turn - math.pi, 2 * math.pi)))

    a1, a2, a3, a4 = alphas
    first, second = from_straight(first_turn), from_straight(second_turn)
    moved = []
    for (x, y, theta), (n1, n2, n3) in zip(particles, normals, strict=True):
        turn1 = first_turn + n1 * math.sqrt(a1 * first**2 + a2 * distance**2)
        step = distance + n2 * math.sqrt(a3 * distance**2 + a4 * (first**2 + second**2))
        turn2 = second_turn + n3 * math.sqrt(a1 * second**2 + a2 * distance**2)
        moved.append(Pose2D(x, y, theta) @ Pose2D(0, 0, turn1) @ Pose2D(step, 0, 0) @ Pose2D(0, 0, turn2))
    return np.array(moved)


def score_scan(particles, beams, distance, info: GridInfo, z_hit, z_random, sigma, max_distance):
    """The likelihood field, beam by beam through the grid's own geometry."""
    weights = []
    for particle in particles:
        weight = 1.0
        for beam in beams:
            end = Pose2D(*particle) @ Pose2D(*beam)
            cell = info.cell_of(end.x, end.y)
            d = max_distance if cell is None else min(float(distance[cell]), max_distance)
            p = z_hit * math.exp(-(d**2) / (2 * sigma**2)) + z_random
            weight += p**3
        weights.append(weight)
    return np.array(weights)


def draw_low_variance(weights, count, start):
    """Each pointer looks for its particle from the beginning."""
    drawn = []
    for k in range(count):
        pointer = (k + start) / count
        total, index = 0.0, len(weights) - 1
        for i, weight in enumerate(weights):
            total += weight
            if pointer < total:
                index = i
                break
        drawn.append(index)
    return np.array(drawn)


def mean_around(particles, weights, pose, radius, turn):
    """Weighted mean of those that are near, angles as directions."""
    near = [
        (x, y, theta, weight)
        for (x, y, theta), weight in zip(particles, weights, strict=True)
        if math.hypot(x - pose[0], y - pose[1]) < radius and abs(math.remainder(theta - pose[2], 2 * math.pi)) < turn
    ]
    total = sum(weight for *_, weight in near)
    x, y = (sum(p[axis] * p[3] for p in near) / total for axis in (0, 1))
    sine, cosine = (sum(f(p[2]) * p[3] for p in near) for f in (math.sin, math.cos))
    return x, y, math.atan2(sine, cosine)
