import numpy as np
import pytest

from ppaas.mapping.closures.submaps import Submap, Submaps, travelled


def test_turns_count_as_distance():
    np.testing.assert_allclose(travelled(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, -1.0]])), [5.0, 0.5])


def test_key_frame_beyond_the_length_opens_the_next_submap():
    submaps = Submaps(1.0)
    step = np.array([0.4, 0.0, 0.0])
    finished = [submaps.add(step) for _ in range(7)]
    assert finished[3] == Submap(0, 3)
    assert submaps.finished == [Submap(0, 3), Submap(3, 6)]
    assert submaps.finish() == Submap(6, 7)
    assert submaps.finish() is None


def test_run_without_key_frames_has_no_submap():
    assert Submaps().finish() is None


@pytest.mark.parametrize(("submap", "middle"), [(Submap(0, 3), 1), (Submap(4, 5), 4)])
def test_middle_is_a_key_frame_of_the_submap(submap, middle):
    assert submap.middle == middle
