from itertools import pairwise

import numpy as np

from ppaas.mapping.parts.joining import LEAST_TRAVEL, JoiningSchedule, join, placed_beside
from ppaas.mapping.parts.map_parts import WHOLE
from ppaas.mapping.serialization.mapping import Mapping
from tests.support.world.mappings import room_mapping


def straight(length: float) -> np.ndarray:
    """Return poses of key frames every 0.5 m along x."""
    x = np.arange(0.0, length + 0.25, 0.5)
    return np.column_stack((x, np.zeros((len(x), 2))))


def test_a_part_is_compared_when_it_has_grown_enough_and_again_when_it_has_grown_further():
    schedule, parts = JoiningSchedule(), WHOLE.begin(2)
    due = [at for at in np.arange(1.0, 60.0, 0.5) if schedule.is_due(parts, straight(at + 1.0))]
    assert due[0] == LEAST_TRAVEL
    assert np.all(np.diff(due) >= 6.0)
    assert np.diff(due)[-1] > 6.0
    assert not schedule.is_due(parts.begin(100), straight(60.0))
    assert not schedule.is_due(WHOLE, straight(60.0))


def test_a_comparison_can_be_cancelled():
    asked = []
    mapping = room_mapping(30)
    assert join(mapping, WHOLE.begin(10), lambda: asked.append(1) or True) is None
    assert len(asked) < 5


def test_parts_that_do_not_overlap_enough_are_left_apart():
    assert join(room_mapping(30), WHOLE.begin(15), lambda: False) is None


def test_parts_lie_beside_each_other():
    mapping, parts = room_mapping(12), WHOLE.begin(4).begin(8)
    poses = placed_beside(Mapping(mapping.frames, mapping.graph), parts, 2.0)
    np.testing.assert_array_equal(poses[:4], mapping.graph.poses[:4])
    np.testing.assert_allclose(poses[:, 1:], mapping.graph.poses[:, 1:], atol=1e-12)
    seen = [_seen(mapping, poses, parts.indices(number, 12)) for number in range(3)]
    gaps = [after[0] - before[1] for before, after in pairwise(seen)]
    np.testing.assert_allclose(gaps, 2.0, atol=1e-6)


def _seen(mapping: Mapping, poses: np.ndarray, chosen: np.ndarray) -> tuple[float, float]:
    xs = np.concatenate([
        poses[k, 0] + np.cos(poses[k, 2]) * mapping.frames.points[k, :, 0][mapping.frames.valid[k]]
        - np.sin(poses[k, 2]) * mapping.frames.points[k, :, 1][mapping.frames.valid[k]]
        for k in chosen
    ])  # fmt: skip
    return float(xs.min()), float(xs.max())
