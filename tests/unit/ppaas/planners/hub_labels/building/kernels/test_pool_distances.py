"""Labels give the distances of all corners from a root."""

import math

import numpy as np
import pytest
from hypothesis import given, settings

from ppaas.planners.hub_labels.building.kernels.pool_distances import lengths_from
from ppaas.planners.hub_labels.kernels.layout import FAR
from ppaas.planners.hub_labels.kernels.scan import STRAIGHT
from tests.reference.planners import hub_labels as twin
from tests.support.budget import examples
from tests.unit.ppaas.planners.hub_labels.building.test_gates import fringe_of
from tests.unit.ppaas.planners.hub_labels.kernels.test_scan import maps


@given(free=maps(14))
@settings(max_examples=examples(15))
def test_distances_from_a_root_agree_with_the_twin(free):
    pool, _, cells, _ = fringe_of(free, 60)
    of_root, far = np.full((2, pool.labelled), FAR, np.int32)
    for root in range(pool.labelled):
        lengths_from(root, pool.labelled, pool.hubs, pool.lengths, pool.begins, pool.ends, of_root, far)
        assert (of_root == FAR).all()
        lengths = twin.lengths_from(free, cells[root])
        for node in range(pool.labelled):
            distance = far[node] / STRAIGHT if far[node] < FAR else math.inf
            assert distance == pytest.approx(lengths[cells[node]])
