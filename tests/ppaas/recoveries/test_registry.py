import pytest

from ppaas.errors import InvalidParameter, NotFound
from ppaas.plugins import PluginRegistry
from ppaas.recoveries import Recovery, create, recovery_names
from ppaas.recoveries.back_up import BackUpRecovery
from ppaas.recoveries.clear_costmap import ClearCostmapRecovery
from ppaas.recoveries.rotate import RotateRecovery
from ppaas.recoveries.wait import WaitRecovery


@pytest.mark.parametrize(
    ("name", "cls"),
    [
        ("clear_costmap_recovery", ClearCostmapRecovery),
        ("clear_costmap_recovery/ClearCostmapRecovery", ClearCostmapRecovery),
        ("rotate_recovery", RotateRecovery),
        ("rotate_recovery/RotateRecovery", RotateRecovery),
        ("back_up", BackUpRecovery),
        ("nav2_behaviors/BackUp", BackUpRecovery),
        ("nav2_behaviors::BackUp", BackUpRecovery),
        ("wait", WaitRecovery),
        ("nav2_behaviors/Wait", WaitRecovery),
    ],
)
def test_a_behaviour_is_made_by_its_name_or_that_of_ros(name, cls):
    assert type(create(name)) is cls


def test_an_unknown_name_is_told_with_the_names_there_are():
    with pytest.raises(NotFound, match=r"recovery behaviour 'jump'; known: back_up, clear_.*, rotate_recovery, wait"):
        create("jump")


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("clear_costmap_recovery", {"reset_distance": -1.0}),
        ("clear_costmap_recovery", {"affected_maps": "none"}),
        ("clear_costmap_recovery", {"layer_names": ["static"]}),
        ("rotate_recovery", {"max_rotational_vel": 0.0}),
        ("rotate_recovery", {"min_in_place_rotational_vel": 2.0}),
        ("back_up", {"backup_dist": "far"}),
        ("back_up", {"backup_speed": float("nan")}),
        ("wait", {"wait_duration": float("inf")}),
        ("wait", {"song": 1}),
    ],
)
def test_a_wrong_parameter_is_refused_by_name(name, wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        create(name, **wrong)


def test_every_behaviour_installed_names_itself_and_its_purpose():
    assert {"back_up", "clear_costmap_recovery", "rotate_recovery", "wait"} <= set(recovery_names())
    for name in recovery_names():
        assert create(name).name == name
        assert create(name).purpose


def test_a_plug_in_of_others_must_be_a_behaviour():
    registry = PluginRegistry("ppaas.planners", "recovery behaviour", Recovery, aliases={})
    with pytest.raises(InvalidParameter, match="is no Recovery"):
        registry.load("dijkstra")
