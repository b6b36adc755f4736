import math

import numpy as np

from benchmarks.mapping.simulated_drive import cast


def distance_by_steps(walls, origin, angle):
    """Naive twin: follow the ray in steps of a millimetre until it is on the other side of a wall."""
    direction = np.array((math.cos(angle), math.sin(angle)))
    best = math.inf
    for x0, y0, x1, y1 in walls.tolist():
        matrix = np.array([direction, (x0 - x1, y0 - y1)]).T
        if abs(np.linalg.det(matrix)) > 1e-12:
            distance, place = np.linalg.solve(matrix, np.array((x0, y0)) - origin)
            if distance > 0.0 and 0.0 <= place <= 1.0:
                best = min(best, distance)
    return best


def test_rays_end_at_the_nearest_wall():
    random = np.random.default_rng(3)
    walls = random.uniform(-5.0, 5.0, (30, 4))
    origins, angles = random.uniform(-4.0, 4.0, (40, 2)), random.uniform(-math.pi, math.pi, 40)
    expected = [distance_by_steps(walls, origin, angle) for origin, angle in zip(origins, angles, strict=True)]
    np.testing.assert_allclose(cast(walls, origins, angles), expected)


def test_a_ray_along_a_wall_passes_it():
    walls = np.array([(1.0, 0.0, 2.0, 0.0), (3.0, -1.0, 3.0, 1.0)])
    origins = np.zeros((2, 2))
    np.testing.assert_allclose(cast(walls, origins, np.array((0.0, math.pi))), (3.0, math.inf))
