import numpy as np
import pytest

from ppaas.perception.torso.patches import (
    COLUMNS,
    EDGES,
    FIRST,
    LOWEST,
    NO_READING,
    OUTSIDE,
    ROW_HEIGHT,
    patches_at,
    propose,
)
from robots.sim.depth.shapes import Shapes, box, capsule, shapes_of
from tests.support.world.depth_images import image_of, person, view_of

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


def places_of(*parts: Shapes, range_max: float = 6.0) -> np.ndarray:
    view = view_of()
    return propose(view, view.points(image_of(*parts)), 0.5, range_max)


@pytest.mark.parametrize("sitting", [False, True])
def test_a_person_has_a_proposal_at_the_front_of_the_torso(sitting: bool) -> None:
    places = places_of(person(3.0, 0.4, sitting=sitting))
    assert np.hypot(places[:, 0] - 2.88, places[:, 1] - 0.4).min() < 0.08
    assert np.hypot(places[:, 0] - 3.0, places[:, 1] - 0.4).max() < 0.5


def test_what_is_lower_than_a_chest_has_no_proposal() -> None:
    assert not len(places_of(shapes_of([], [box((2.0, 0.0, 0.35), (0.3, 0.3, 0.35))])))
    assert not len(places_of())


def test_thin_poles_and_far_surfaces_have_no_proposal() -> None:
    assert not len(places_of(shapes_of([capsule((3.0, 0.0, 1.2), (3.0, 0.0, 1.23), 0.01)])))
    assert not len(places_of(person(5.0, 0.0), range_max=4.0))


def test_a_wall_has_one_proposal_for_each_place_across() -> None:
    places = places_of(shapes_of([], [box((3.05, 0.0, 1.0), (0.05, 0.6, 1.0))]))
    across = np.sort(places[:, 1])
    assert np.diff(across).min() > 0.03
    assert abs(places[:, 0] - 3.0).max() < 0.03
