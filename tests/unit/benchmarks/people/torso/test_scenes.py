import math

import numpy as np
import pytest

from benchmarks.people.torso.scenes import CLUTTER, DetectorScene, PersonTruth, SceneGenerator, clutter
from benchmarks.people.torso.score import DetectorScore
from benchmarks.people.torso.training import samples_of, tilted, tree_samples_of, view_of
from ppaas.maps.grid import GridMap
from ppaas.perception.torso.detector import TorsoDetection, TorsoDetector
from ppaas.perception.torso.trained import trained_templates
from robots.sim.depth.camera import DepthCameraModel
from tests.support.world.rooms import room

MODEL = DepthCameraModel(160, 120)


@pytest.fixture(scope="module")
def grid() -> GridMap:
    return room(9.0, 9.0)


@pytest.fixture(scope="module")
def seen(grid: GridMap) -> list[DetectorScene]:
    generator = SceneGenerator(grid, MODEL, np.random.default_rng(0))
    return [generator.scene() for _ in range(12)]


def test_scenes_have_people_and_furniture_ahead(seen: list[DetectorScene]) -> None:
    people = [person for scene in seen for person in scene.people]
    assert people
    assert all(person.x > 0.0 and 1.0 < person.top < 2.0 and 0.0 <= person.share <= 1.0 for person in people)
    assert any(person.share > 0.8 for person in people)
    assert any(person.sitting for person in people)
    assert {kind for scene in seen for kind, _, _ in scene.furniture} >= {"chair", "table", "coat_stand"}


def test_equal_seeds_give_equal_scenes(grid: GridMap, seen: list[DetectorScene]) -> None:
    again = SceneGenerator(grid, MODEL, np.random.default_rng(0)).scene()
    np.testing.assert_array_equal(again.image, seen[0].image)
    assert again.people == seen[0].people


def test_samples_are_people_and_nobody(seen: list[DetectorScene]) -> None:
    templates = samples_of(seen, MODEL)
    assert (templates.tops > 1.0).any()
    assert (templates.tops == 0.0).any()
    trees = tree_samples_of(seen, MODEL, trained_templates())
    assert set(trees.labels.tolist()) <= {0.0, 1.0}
    assert trees.labels.any()


def test_clutter_is_seen_by_tilted_cameras(grid: GridMap) -> None:
    rng = np.random.default_rng(3)
    model = tilted(rng)
    scene = SceneGenerator(grid, model, rng, [CLUTTER]).scene(0, 4)
    assert TorsoDetector(view_of(model)).detect(scene.image) is not None
    heap = clutter(rng)
    assert len(heap.capsules) + len(heap.solids) >= 2


def detection(x: float, y: float) -> TorsoDetection:
    return TorsoDetection(x, y, 1.2, 0.9, 1.7, [0.0] * 9)


def person(x: float, y: float, share: float) -> PersonTruth:
    return PersonTruth(x, y, 1.7, share, sitting=False)


def test_a_score_counts_people_of_whom_half_is_visible() -> None:
    scene = DetectorScene(
        np.zeros((2, 2), np.uint16),
        [person(2.0, 0.0, 0.9), person(3.0, 1.0, 0.6), person(4.0, 0.0, 0.2)],
        [("chair", 3.0, -1.0)],
    )  # fmt: skip
    score = DetectorScore()
    score.add(scene, [detection(2.1, 0.0), detection(4.0, 0.1), detection(3.1, -1.0), detection(2.5, 3.0)])
    assert (score.found, score.missed, score.wrong) == (1, 1, 2)
    assert score.errors == [pytest.approx(0.1)]
    assert dict(score.mistaken) == {"chair": 1, "wall": 1}
    assert score.precision == pytest.approx(1 / 3)
    assert score.recall == pytest.approx(1 / 2)
    assert math.isclose(sum(score.missed_kinds.values()), 1)
