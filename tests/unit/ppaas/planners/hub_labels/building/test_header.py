"""An index is accepted only if it is complete, of this version and of this map."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.planners.hub_labels.building.assembly import build_index
from ppaas.planners.hub_labels.building.header import fingerprint, unseal
from ppaas.planners.hub_labels.kernels.layout import CHECK, LABELS, MAGIC, TERRAIN, VERSION
from ppaas.planners.hub_labels.planner import HubIndex, HubLabels
from ppaas.planners.watch import proceed
from tests.support.world import grids

FREE = np.random.default_rng(4).random((40, 50)) > 0.25


@pytest.fixture(scope="module")
def index():
    return build_index(FREE, threads=1, check=proceed)


def changed(index, place: int, value: int) -> bytes:
    words = index.copy()
    words[place] = value
    return words.tobytes()


def test_index_is_read_without_a_copy(index):
    content = index.tobytes()
    found = unseal(content)
    np.testing.assert_array_equal(found, index)
    assert found.base is not None
    assert not found.flags.writeable
    start, goal = np.argwhere(FREE)[[0, -1]]
    np.testing.assert_array_equal(HubIndex(found).path(*start, *goal), HubIndex(index).path(*start, *goal))


@pytest.mark.parametrize("keep", [0, 1, 8, 255, 256, 4000, 4001, -8])
def test_truncated_index_is_refused(index, keep):
    with pytest.raises(InvalidInput, match="build"):
        unseal(index.tobytes()[:keep])


def test_invalid_index_is_refused(index):
    with pytest.raises(InvalidInput, match="not an index"):
        unseal(bytes(index.nbytes))
    with pytest.raises(InvalidInput, match="other byte order"):
        unseal(index.byteswap().tobytes())
    with pytest.raises(InvalidInput, match="version 99"):
        unseal(changed(index, VERSION, 99))
    for place in (MAGIC, CHECK, LABELS, int(index[TERRAIN])):
        with pytest.raises(InvalidInput):
            unseal(changed(index, place, 12345))


def test_index_states_its_map(index):
    assert HubIndex(index).is_of(fingerprint(FREE))
    np.testing.assert_array_equal(HubIndex(index).free(), FREE)
    for other in (~FREE, FREE.T, FREE.reshape(50, 40), FREE[:, :-1]):
        assert not HubIndex(index).is_of(fingerprint(other))


def test_planner_uses_a_shared_index_of_its_map_only(index):
    requested = []

    def indexes(planner, check):
        requested.append(planner)
        return memoryview(index.tobytes())

    costmap = grids.of(np.where(FREE, 0, 254).astype(np.uint8), indexes=indexes)
    shared = HubLabels().prepare(costmap)
    assert shared.words.base is not None
    unknown = grids.of(np.where(FREE, 0, 255).astype(np.uint8), indexes=indexes)
    np.testing.assert_array_equal(HubLabels(allow_unknown=False).prepare(unknown).words, index)
    built = HubLabels().prepare(unknown)  # with free unknown cells it is another map
    assert len(built.words) != len(index)
    assert requested == ["hub_labels"] * 3
