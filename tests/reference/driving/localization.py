"""Twins of the kernels of localization."""

import math

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo


def move_diff(particles, motion, sigmas, normals):
    """Move one particle after the other (*Probabilistic Robotics*, table 5.6)."""
    first, distance, second = motion
    moved = []
    for (x, y, theta), (n1, n2, n3) in zip(particles, normals, strict=True):
        turn1, step, turn2 = first + n1 * sigmas[0], distance + n2 * sigmas[1], second + n3 * sigmas[2]
        moved.append(Pose2D(x, y, theta) @ Pose2D(0, 0, turn1) @ Pose2D(step, 0, 0) @ Pose2D(0, 0, turn2))
    return np.array(moved)


def move_omni(particles, motion, sigmas, normals):
    """Move along the bearing and to its right, then turn."""
    bearing, distance, turn = motion
    moved = []
    for (x, y, theta), (n1, n2, n3) in zip(particles, normals, strict=True):
        end = Pose2D(x, y, theta) @ Pose2D(0, 0, bearing) @ Pose2D(distance + n1 * sigmas[0], -n2 * sigmas[1], 0)
        moved.append(Pose2D(end.x, end.y, theta + turn + n3 * sigmas[2]))
    return np.array(moved)


def score_scan(particles, beams, distance, info: GridInfo, z_hit, z_random, sigma, max_distance):
    """Return the likelihood field's sums, beam by beam, with the geometry of the grid."""
    weights = []
    for particle in particles:
        weight = 0.0
        for beam in beams:
            end = Pose2D(*particle) @ Pose2D(*beam)
            cell = info.cell_of(end.x, end.y)
            d = max_distance if cell is None else min(float(distance[cell]), max_distance)
            p = z_hit * math.exp(-(d**2) / (2 * sigma**2)) + z_random
            weight += p**3
        weights.append(weight)
    return np.array(weights)


def score_ranges(particles, beams, distance, info: GridInfo, shares, range_max):
    """Return the beam model's sums, with rays followed in steps of a tenth of a cell."""
    sums = []
    for particle in particles:
        total = 0.0
        for x, y, angle, measured in beams:
            begin = Pose2D(*particle) @ Pose2D(x, y, angle)
            expected = _followed(begin, distance, info, range_max)
            p = shares.hit * math.exp(-((measured - expected) ** 2) / (2 * shares.sigma_hit**2))
            if measured < expected:
                p += shares.short * shares.lambda_short * math.exp(-shares.lambda_short * measured)
            p += shares.max if measured >= range_max else shares.rand / range_max
            total += p**3
        sums.append(total)
    return np.array(sums)


def explain_rays(pose, ray, distance, info: GridInfo, sigma, person):
    """Return how well the map explains one ray: by a hit, or by a person in free space."""
    to_x, to_y, from_x, from_y = ray
    begin, end = Pose2D(*pose) @ Pose2D(from_x, from_y), Pose2D(*pose) @ Pose2D(to_x, to_y)
    cell = info.cell_of(end.x, end.y)
    if cell is None:
        return 0.0
    hit = math.exp(-((float(distance[cell]) / sigma) ** 2) / 2.0)
    length, heading = begin.distance_to(end), math.atan2(end.y - begin.y, end.x - begin.x)
    inside = info.cell_of(begin.x, begin.y) is not None
    clear = inside and _followed(Pose2D(begin.x, begin.y, heading), distance, info, length) >= length
    return max(hit, person) if clear else hit


def to_walls(laser, angle, distance, info: GridInfo, most):
    """Return the range of a beam."""
    return _followed(Pose2D(*laser) @ Pose2D(0.0, 0.0, angle), distance, info, most)


def stopped_short(pose, point, distance, info: GridInfo, beyond):
    """Return whether a beam could have been longer by ``beyond`` according to the map."""
    begin, length = Pose2D(*pose), math.hypot(*point) + beyond
    if info.cell_of(begin.x, begin.y) is None:
        return False
    aimed = Pose2D(begin.x, begin.y, begin.theta + math.atan2(point[1], point[0]))
    return _followed(aimed, distance, info, length) >= length


def _followed(begin, distance, info, range_max):
    length = 0.0
    while length < range_max:
        end = begin @ Pose2D(length, 0.0)
        cell = info.cell_of(end.x, end.y)
        if cell is None:
            return range_max
        if distance[cell] == 0.0:
            return length
        length += info.resolution / 10
    return range_max


def draw_low_variance(weights, count, start):
    """Draw particles, searching for each pointer from the start."""
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


def kld_sample_size(particles, weights, picks, least, error, z):
    """Draw one by one, and count the bins in a set."""
    bins, cumulative = set(), np.cumsum(weights)
    for drawn, pick in enumerate(picks):
        k = max(len(bins) - 1, 1)
        a = 2 / (9 * k)
        if drawn >= max(least, k / (2 * error) * (1 - a + math.sqrt(a) * z) ** 3 if bins else 0):
            return drawn
        i = min(int(np.searchsorted(cumulative, pick * cumulative[-1], side="right")), len(weights) - 1)
        bins.add(bin_of(particles[i]))
    return len(picks)


def bin_of(particle):
    """Return the bin of half a metre by half a metre by ten degrees."""
    x, y, theta = particle
    return math.floor(x / 0.5), math.floor(y / 0.5), math.floor(theta / math.radians(10))


def moments_around(particles, weights, pose, radius, turn):
    """Return weight, mean and covariance of the particles near a pose, with angles relative to it."""
    near = [
        (x, y, pose[2] + math.remainder(theta - pose[2], 2 * math.pi), weight)
        for (x, y, theta), weight in zip(particles, weights, strict=True)
        if math.hypot(x - pose[0], y - pose[1]) < radius and abs(math.remainder(theta - pose[2], 2 * math.pi)) < turn
    ]
    poses, shares = np.array(near)[:, :3], np.array(near)[:, 3]
    return shares.sum(), np.average(poses, axis=0, weights=shares), np.cov(poses.T, aweights=shares, ddof=0)
