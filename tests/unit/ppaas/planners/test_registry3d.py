import pytest

from ppaas import planners
from ppaas.errors import InvalidParameter, NotFound
from ppaas.planners import volume
from ppaas.planners.volume.voxel_planner import AStar3D, Dijkstra3D


@pytest.mark.parametrize("create", [planners.create, volume.create])
def test_3d_planner_is_created_by_name_with_parameters(create):
    assert isinstance(create("astar3d"), AStar3D)
    planner = create("dijkstra3d", allow_unknown=False)
    assert isinstance(planner, Dijkstra3D)
    assert planner.allow_unknown is False
    with pytest.raises(InvalidParameter, match="colour"):
        create("dijkstra3d", colour="red")


def test_2d_and_3d_planner_names_are_disjoint():
    with pytest.raises(NotFound, match=r"unknown planner in space 'dijkstra'; known: astar3d, dijkstra3d"):
        volume.create("dijkstra")
    assert not set(volume.planner_names()) & set(planners.planner_names())
