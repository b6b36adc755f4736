import numpy as np

from ppaas.perception.torso.patches import COLUMNS, EDGES, FIRST, LOWEST, NO_READING, OUTSIDE, ROW_HEIGHT, patches_at
from robots.sim.depth.shapes import Shapes, box, shapes_of
from tests.support.world.depth_images import image_of, view_of

SAME = FIRST + int(np.searchsorted(EDGES, 0.0))
"""Step of the depth of the surface itself."""


def patch_of(*parts: Shapes, at: tuple[float, float]) -> np.ndarray:
    view = view_of()
    [patch] = patches_at(view, view.points(image_of(*parts)), np.array([at], np.float32))
    return patch


def row_at(height: float) -> int:
    return round((height - LOWEST) / ROW_HEIGHT)


def test_a_patch_has_the_relief_of_a_surface_whatever_its_distance() -> None:
    near, far = (
        patch_of(
            shapes_of([], [box((x + 0.1, 0.0, 1.0), (0.1, 0.15, 0.8)), box((x + 0.6, 0.0, 1.0), (0.1, 2.0, 1.5))]),
            at=(x, 0.0),
        )
        for x in (2.0, 4.0)
    )
    for patch in (near, far):
        middle = patch[row_at(0.5) : row_at(1.3), COLUMNS // 2 - 2 : COLUMNS // 2 + 2]
        assert (middle == SAME).mean() > 0.9
        assert (patch[row_at(1.0), [2, -3]] == FIRST + len(EDGES)).all()


def test_cells_outside_the_image_and_without_a_reading_have_steps_of_their_own() -> None:
    patch = patch_of(shapes_of([], [box((1.1, 0.0, 1.0), (0.1, 0.15, 0.9))]), at=(1.0, 0.0))
    assert (patch[row_at(1.8)] == OUTSIDE).all()
    assert (patch_of(at=(4.0, 0.0))[row_at(1.3)] == NO_READING).all()
