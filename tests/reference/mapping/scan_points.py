"""Naive twin of the points and normals of a scan."""

import numpy as np


def prepare(ranges, laser, parameters, velocity=(0.0, 0.0, 0.0)):
    """Return points, normals and valid, by eigenvectors of the covariance of each neighbourhood."""
    beams = len(ranges)
    points, normals = np.zeros((beams, 2)), np.zeros((beams, 2))
    valid = (ranges > parameters.minimum_laser_range) & (ranges < parameters.max_laser_range)
    for b in np.flatnonzero(valid):
        late = (b - laser.stamped_at * (beams - 1)) * laser.time_increment
        x, y, turn = late * np.asarray(velocity)
        angle = laser.angle_min + b * laser.angle_increment + turn
        points[b] = x + ranges[b] * np.cos(angle), y + ranges[b] * np.sin(angle)
    side = max(2, round(parameters.normal_angle / abs(laser.angle_increment)))
    for b in np.flatnonzero(valid):
        around = [points[k] for k in range(max(0, b - side), min(beams, b + side + 1)) if valid[k]]
        near = within(around, points[b], 0.1 + 0.05 * ranges[b])
        if len(near) < 3 and 0 < b < beams - 1 and valid[b - 1] and valid[b + 1]:
            spacing = max(np.hypot(*(points[b] - points[b - 1])), np.hypot(*(points[b + 1] - points[b])))
            near = within(around, points[b], max(0.1 + 0.05 * ranges[b], min(1.05 * spacing, 0.4 * ranges[b])))
        if len(near) < 3:
            continue
        variances, axes = np.linalg.eigh(np.cov(near.T, bias=True))
        if variances[0] > parameters.normal_thickness**2 or variances[1] < 4.0 * variances[0]:
            continue
        normal = axes[:, 0]
        normals[b] = normal if normal @ points[b] < 0.0 else -normal
    return points, normals, valid


def within(around, point, radius):
    return np.array([other for other in around if np.hypot(*(other - point)) <= radius])
