"""The check of a robot file refuses what a container refuses, in the same words."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from engine.container.clone_check import CloneCheck, write_empty_map
from engine.container.current_map import CurrentMap
from engine.container.graph_building import build_graph
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.specs.clone_to_check import CloneToCheck
from engine.specs.containers import ContainerSpec, Launch, RobotConfig
from engine.specs.layer_files import write_layers
from ppaas import plugins
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError
from ppaas.nodes.graph import Graph
from ppaas.planners.registry import PLANNERS
from ppaas.plans.reuse.time_estimates import Times
from ppaas.recoveries.registry import RECOVERIES
from ppaas.robot_model.known_models import model_names
from ppaas.thread_budget import one_thread
from tests.support.engine.specs import HOUSE, robot_config
from tests.support.world.planar_world import walled_map

REFUSED: dict[str, dict[str, Any]] = {
    "model": {"model": "toaster"},
    "base_global_planner": {"base_global_planner": "guess"},
    "planner in space": {"base_global_planner": "astar3d"},
    "base_local_planner": {"base_local_planner": "guess"},
    "parameters.move_base.base_global_planner": {"parameters": {"move_base": {"base_global_planner": "guess"}}},
    "parameters.move_base.base_local_planner": {"parameters": {"move_base": {"base_local_planner": "guess"}}},
    "parameters.move_base.controller_frequency": {"parameters": {"move_base": {"controller_frequency": 0}}},
    "parameters.move_base.recovery_behaviors.1": {
        "parameters": {
            "move_base": {"recovery_behaviors": [{"name": "a", "type": "wait"}, {"name": "b", "type": "wink"}]}
        }
    },
    "parameters.a.wait_duraton": {
        "parameters": {
            "move_base": {"recovery_behaviors": [{"name": "a", "type": "wait"}]}, "a": {"wait_duraton": 1.0}
        }
    },
    "parameters.movebase": {"parameters": {"movebase": {}}},
    "parameters.amcl": {"parameters": {"amcl": [1]}},
    "parameters.amcl.min_particles": {"parameters": {"amcl": {"min_particles": "many"}}},
    "parameters.dwa.sim_time": {"parameters": {"dwa": {"sim_time": -1.0}}},
    "parameters.DWAPlannerROS.speed": {"parameters": {"DWAPlannerROS": {"speed": 1.0}}},
    "parameters.astar.weight": {"parameters": {"astar": {"weight": 3}}},
    "parameters.global_costmap.footprint": {"parameters": {"global_costmap": {"footprint": [[0.0, 0.0]]}}},
    "parameters.global_costmap.robot_radius": {"parameters": {"global_costmap": {"robot_radius": 1000.0}}},
    "parameters.global_costmap.inflation_radius": {"parameters": {"global_costmap": {"inflation_radius": -1.0}}},
    "parameters.local_costmap.width": {"parameters": {"local_costmap": {"width": 4000.0}}},
    "parameters.local_costmap.publish_frequency": {"parameters": {"local_costmap": {"publish_frequency": 99.0}}},
    "parameters.voxel_layer.max_obstacle_height": {"parameters": {"voxel_layer": {"max_obstacle_height": -1.0}}},
    "parameters.social_layer.cutoff": {"parameters": {"social_layer": {"cutoff": -1.0}}},
    "parameters.static_layer.track_unknown_space": {"parameters": {"static_layer": {"track_unknown_space": "yes"}}},
    "parameters.speed_filter.filter_mask": {"parameters": {"speed_filter": {"filter_mask": 7}}},
    "parameters.robot_state_publisher.laser": {"parameters": {"robot_state_publisher": {"laser": 1}}},
    "parameters.waypoint_follower.loop_rate": {"parameters": {"waypoint_follower": {"loop_rate": "slow"}}},
    "parameters.depthimage_to_laserscan.scan": {"parameters": {"depthimage_to_laserscan": {"scan": 1}}},
    "parameters.octomap_server.resolution": {"parameters": {"octomap_server": {"resolution": -1.0}}},
    "parameters.torso_detector.shoulders": {"parameters": {"torso_detector": {"shoulders": 2}}},
    "parameters.leg_detector.legs": {"parameters": {"leg_detector": {"legs": 2}}},
    "parameters.people_tracker.eyes": {"parameters": {"people_tracker": {"eyes": 2}}},
    "parameters.follow_person.who": {"parameters": {"follow_person": {"who": "ann"}}},
    "parameters.node_monitor.patience": {"parameters": {"node_monitor": {"patience": 0.0}}},
    "parameters.recorder.topics": {"parameters": {"recorder": {"topics": []}}},
    "parameters.traffic.reaction": {"parameters": {"traffic": {"reaction": -1.0}}},
    "parameters.follow_path.way": {"parameters": {"follow_path": {"way": 1}}},
    "parameters.traffic": {"parameters": {"traffic": {}, "follow_path": {}}},
    "new map, parameters.traffic": {"new_map": "office", "parameters": {"traffic": {}}},
    "new map, parameters.follow_path": {"new_map": "office", "parameters": {"follow_path": {}}},
    "parameters.grid_slam.resolution": {"new_map": "office", "parameters": {"grid_slam": {"resolution": 0.0}}},
    "parameters.grid_slam.mode": {"new_map": "office", "parameters": {"grid_slam": {"mode": "localization"}}},
    "parameters.explore.speed": {"new_map": "office", "parameters": {"explore": {"speed": 1}}},
    "parameters.explore.visits": {"parameters": {"explore": {"visits": 1}}},
}  # fmt: skip
"""Files that a container refuses, by the part at fault."""

ACCEPTED: list[dict[str, Any]] = [
    {},
    {"in_space": True},
    {"new_map": "office"},
    *({"model": name} for name in model_names()),
    *({"base_global_planner": name} for name in PLANNERS.names()),
    *({"base_local_planner": name} for name in CONTROLLERS.names()),
    *({"parameters": {name: {}}} for name in PLANNERS.names()),
    {"parameters": {"move_base": {"recovery_behaviors": [{"name": n, "type": n} for n in RECOVERIES.names()]}}},
    {"parameters": {"torso_detector": {}, "leg_detector": {}, "follow_person": {}, "traffic": {}}},
    {"parameters": {"depthimage_to_laserscan": {}, "octomap_server": {}, "node_monitor": {}, "recorder": {}}},
    {"parameters": {"follow_path": {}}},
    {"parameters": {name: {"filter_mask": "m"} for name in ("keepout_filter", "speed_filter")}},
    {"parameters": {"voxel_layer": {}}, "in_space": True},
    {"new_map": "office", "parameters": {"grid_slam": {}, "explore": {}, "depthimage_to_laserscan": {}}},
    {"new_map": "office", "parameters": {"grid_slam": {"map_file_name": "house"}}, "continued": HOUSE},
]  # fmt: skip


ON_A_MAP = [fields for fields in (*REFUSED.values(), *ACCEPTED) if not fields.get("new_map")]


@pytest.fixture
def check(tmp_path: Path) -> CloneCheck:
    return CloneCheck(tmp_path)


def refusal(robot: RobotConfig, folder: Path) -> str | None:
    """Return why a container on a real map refuses a robot."""
    mask = walled_map(4, 3, [])
    write_layers(folder, build_layers(walled_map(4, 3, []), keepout=mask, speed=mask), 0.0)
    spec = ContainerSpec("c1", "ann", HOUSE, 1.0, robot)
    launch, times = Launch(spec, str(folder), "", "", "", (), 1), Times()
    try:
        current = CurrentMap(launch, SharedPlans(times, lambda: None), times, PlanningNotes(times))
        build_graph(Graph(), launch, one_thread, current)
    except PPaaSError as error:
        return str(error)
    return None


@pytest.mark.parametrize("part", REFUSED)
def test_a_file_is_refused_in_the_words_of_its_container(check: CloneCheck, part: str, tmp_path: Path) -> None:
    robot = robot_config(**REFUSED[part])
    said = refusal(robot, tmp_path)
    assert said is not None
    [fault] = check.faults(CloneToCheck(robot, 0.05))
    assert fault.text == said
    if part.startswith(("parameters.", "base", "model")):
        assert fault.parameter == part


@pytest.mark.parametrize("fields", ACCEPTED, ids=str)
def test_a_file_that_its_container_accepts_has_no_fault(check: CloneCheck, fields: dict[str, Any]) -> None:
    assert check.faults(CloneToCheck(robot_config(**fields), 0.05)) == []


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.sampled_from(ON_A_MAP), min_size=2, max_size=4))
def test_what_has_no_fault_is_accepted_and_what_has_one_is_refused(
    check: CloneCheck, tmp_path: Path, several: list[dict[str, Any]]
) -> None:
    fields = {name: value for each in several for name, value in each.items()}
    fields["parameters"] = {name: part for each in several for name, part in each.get("parameters", {}).items()}
    robot = robot_config(**fields)
    found, said = check.faults(CloneToCheck(robot, 0.05)), refusal(robot, tmp_path)
    assert (found[0].text if found else None) == said


def test_all_faults_of_a_file_are_listed(check: CloneCheck) -> None:
    given = {"amcl": {"min_particles": "many"}, "dwa": {"speed": 1, "sim_time": -1.0}, "movebase": {}, "recorder": []}
    found = check.faults(CloneToCheck(robot_config(model="toaster", parameters=given), 0.05))
    assert {fault.parameter for fault in found} == {
        "model", "parameters.amcl.min_particles", "parameters.dwa.speed", "parameters.dwa.sim_time",
        "parameters.movebase", "parameters.recorder",
    }  # fmt: skip


def test_the_cells_of_the_map_count(check: CloneCheck) -> None:
    robot = robot_config(parameters={"local_costmap": {"width": 60.0, "height": 60.0}})
    assert check.faults(CloneToCheck(robot, 0.05)) == []
    [fault] = check.faults(CloneToCheck(robot, 0.01))
    assert "cells" in fault.text


def test_an_allowed_plug_in_that_only_machines_have_is_left_to_them(
    check: CloneCheck, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plugins, "_permitted", frozenset({"ppaas.planners:mine"}))
    assert check.faults(CloneToCheck(robot_config(base_global_planner="mine"), 0.05)) == []
    [fault] = check.faults(CloneToCheck(robot_config(base_global_planner="theirs"), 0.05))
    assert fault.parameter == "base_global_planner"


def test_empty_maps_have_no_walls(tmp_path: Path) -> None:
    write_empty_map(tmp_path, 0.05)
    assert not np.load(tmp_path / "costmap.npy").any()


def test_a_check_leaves_no_file(check: CloneCheck, tmp_path: Path) -> None:
    assert check.faults(CloneToCheck(robot_config(model="toaster"), 0.05))
    assert list(tmp_path.iterdir()) == []
