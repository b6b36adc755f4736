from importlib.metadata import EntryPoint

import pytest

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidParameter, NotFound
from ppaas.nodes.graph import Graph
from ppaas.plugins import PluginRegistry
from ppaas.recoveries import Recovery, create, recovery_names
from ppaas.recoveries.back_up import BackUpRecovery
from ppaas.recoveries.clear_costmap import ClearCostmapRecovery
from ppaas.recoveries.registry import RECOVERIES
from ppaas.recoveries.rotate import RotateRecovery
from ppaas.recoveries.wait import WaitRecovery
from tests.support.world.planar_world import walled_map


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
def test_behaviour_is_created_by_its_own_or_ros_name(name, cls):
    assert type(create(name)) is cls


def test_unknown_name_error_lists_the_known_names():
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
def test_invalid_parameter_is_refused_by_name(name, wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        create(name, **wrong)


def test_installed_behaviours_state_their_name_and_purpose():
    assert {"back_up", "clear_costmap_recovery", "rotate_recovery", "wait"} <= set(recovery_names())
    for name in recovery_names():
        assert create(name).name == name
        assert create(name).purpose


class Whistle(Recovery):
    """A recovery behaviour from another distribution."""

    name = "whistle"
    purpose = "Whistles, so that people step aside."

    def __init__(self, tune: str = "") -> None:
        self.tune = tune

    def start(self, request):
        pass

    def step(self, request):
        return None


def test_a_behaviour_of_another_distribution_is_found_by_its_entry_point(monkeypatch):
    entry = EntryPoint("whistle", f"{__name__}:Whistle", "ppaas.recoveries")
    monkeypatch.setitem(RECOVERIES.__dict__, "_entries", {**RECOVERIES._entries, "whistle": entry})
    behaviors = [{"name": "polite", "type": "whistle"}, {"name": "rest", "type": "wait"}]
    graph = Graph()
    build_clone(
        graph,
        build_layers(walled_map(4, 3, [])),
        model="turtlebot2",
        initial_pose=(1.0, 1.0, 0.0),
        parameters={"move_base": {"recovery_behaviors": behaviors}, "polite": {"tune": "C major"}},
    )
    whistle, wait = graph.nodes["move_base"]._executor._recoveries
    assert (type(whistle), whistle.tune) == (Whistle, "C major")
    assert isinstance(wait, WaitRecovery)


def test_plug_in_of_another_type_is_refused():
    registry = PluginRegistry("ppaas.planners", "recovery behaviour", Recovery, aliases={})
    with pytest.raises(InvalidParameter, match="is not a subclass of Recovery"):
        registry.load("dijkstra")
