import pytest

from ppaas import planners
from ppaas.errors import InvalidParameter, NotFound
from ppaas.planners import create, planner_names, volume
from ppaas.planners.grid.astar import AStar
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.planners.volume.voxel_planner import AStar3D, Dijkstra3D
from ppaas.plugins import parameters_in_use


def test_planner_is_created_by_name_with_parameters():
    planner = create("dijkstra", allow_unknown=False)
    assert isinstance(planner, Dijkstra)
    assert planner.allow_unknown is False


def test_ros_names_are_known():
    assert isinstance(create("global_planner/GlobalPlanner"), Dijkstra)
    assert isinstance(create("nav2_smac_planner/SmacPlanner2D"), AStar)


def test_an_unknown_name_is_refused_with_the_known_names():
    with pytest.raises(NotFound, match=r"unknown planner 'teleport'; known: .*dijkstra"):
        create("teleport")


def test_an_unknown_parameter_is_refused_with_the_known_ones():
    with pytest.raises(InvalidParameter, match="'navfn' has no parameter 'colour'; known: allow_unknown, use_astar"):
        create("navfn", colour="red")


@pytest.mark.parametrize("value", ["yes", 1, None, []])
def test_a_parameter_of_another_type_is_refused(value):
    with pytest.raises(InvalidParameter, match="'allow_unknown' of planner 'dijkstra': Expected `bool`"):
        create("dijkstra", allow_unknown=value)


def test_installed_planners_have_twins_with_equal_parameters():
    for name in planner_names():
        planner = (
            create(name, allow_unknown=False) if "allow_unknown" in parameters_in_use(create(name)) else create(name)
        )
        twin = planner.twin()
        assert type(twin) is type(planner)
        assert twin is not planner
        assert parameters_in_use(twin) == parameters_in_use(planner)


def test_installed_planners_state_their_name_and_purpose():
    assert "dijkstra" in planner_names()
    for name in planner_names():
        planner = create(name)
        assert planner.name == name
        assert planner.purpose


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
