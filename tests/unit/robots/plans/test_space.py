"""Offline planning in 3D for a given body."""

import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidMap, NotFound
from ppaas.planners.volume import Pose3D
from robots.plans import space
from tests.support.sources import ROOT

TABLE = ROOT / "docs" / "examples" / "table.bt"
ACROSS = (Pose3D(0.5, 1.5, 0.0), Pose3D(3.5, 1.5, 0.0))


@pytest.mark.parametrize("planner", ["astar3d", "dijkstra3d"])
def test_the_body_decides_between_under_around_and_over_the_table(planner):
    bodies = space.SpaceBody(0.18), space.SpaceBody(0.18, 1.2), space.SpaceBody(0.18, 1.0, flies=True)
    under, around, over = (space.plan(space.costmap_of_file(TABLE, body), *ACROSS, planner, 0.0) for body in bodies)
    assert under.length < 3.1 < over.length < around.length
    assert under.poses[:, 2].max() == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(around.poses[:, 1]) > 0.9
    assert np.ptp(over.poses[:, 1]) < 0.6


def test_the_default_step_is_one_voxel():
    one, none = (space.costmap_of_file(TABLE, space.SpaceBody(0.1, step=step)) for step in (None, 0.0))
    assert np.flatnonzero((one.data == 0).any(axis=(1, 2))).tolist()[:2] == [1, 2]
    assert not (none.data[2] == 0).any()
    assert space.costmap_of_file(TABLE, space.SpaceBody(0.1), depth=15).info.resolution == 0.2


def test_invalid_maps_bodies_and_planners_are_refused(tmp_path):
    with pytest.raises(InvalidMap, match="No such file"):
        space.costmap_of_file(tmp_path / "none.bt", space.SpaceBody(0.1))
    with pytest.raises(InvalidInput):
        space.costmap_of_file(TABLE, space.SpaceBody(0.1, height=-1.0))
    with pytest.raises(NotFound, match="astar3d, dijkstra3d"):
        space.plan(space.costmap_of_file(TABLE, space.SpaceBody(0.1)), *ACROSS, "navfn", 0.0)
