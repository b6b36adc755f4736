import numpy as np

from ppaas.perception.torso.relief import COLUMNS, FEATURES, LEVELS, ROWS, features_at, mirrored
from robots.sim.depth.shapes import Shapes
from tests.support.world.depth_images import image_of, person, view_of


def features_of(*parts: Shapes, y: float = 0.0) -> np.ndarray:
    view = view_of()
    places, ones = np.array([(2.88, y)], np.float32), np.ones(1, np.float32)
    return features_at(view, view.points(image_of(*parts)), places, 1.75 * ones, 2.0 * ones)


def test_features_are_levels() -> None:
    features = features_of(person(3.0, 0.0))
    assert features.shape == (1, FEATURES)
    assert features.max() < LEVELS


def test_widths_tell_the_head_from_the_shoulders() -> None:
    features = features_of(person(3.0, 0.0))
    cells = features[0, -3 - ROWS : -3]
    head, shoulders = cells[6], cells[11]
    assert 3 <= head <= 7
    assert 10 <= shoulders <= 20


def test_the_mirror_image_of_a_person_has_mirrored_features() -> None:
    right, left = features_of(person(3.0, 0.2, 2.8), y=0.2), features_of(person(3.0, -0.2, -2.8), y=-0.2)
    # Shadows are on one side only, and the noise is another.
    same = mirrored(right) == left
    assert same[0, : ROWS * COLUMNS].mean() > 0.75
    assert np.array_equal(mirrored(mirrored(right)), right)
