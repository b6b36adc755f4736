"""The map is replaced while a robot drives: its goal stays, and its plan is checked on the new map."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.planners.base import PlanResult
from ppaas.plans.reuse.setup import ReuseSetup
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

START, GOAL = Pose2D(1.0, 1.6, 0.0), Pose2D(4.5, 1.6, 0.0)
NEAR_DOOR, FAR_DOOR = (0.9, 2.2), (4.2, 5.5)


def room(*doors: tuple[float, float]) -> GridMap:
    """Return a room with a wall at x = 3 m that has doors, each from y to y [m]."""
    ends = [0.0, *(end for door in sorted(doors) for end in door), 6.0]
    return walled_map(6, 6, [(2.9, a, 3.1, b) for a, b in zip(ends[::2], ends[1::2], strict=True)])


def shifted(grid: GridMap, cells: int) -> GridMap:
    """Return a map with more unknown cells around it, so that its corner is elsewhere."""
    info, data = grid.info, np.pad(grid.data, cells, constant_values=-1)
    corner = info.origin @ Pose2D(-cells * info.resolution, -cells * info.resolution)
    return GridMap(data, GridInfo(info.resolution, data.shape[1], data.shape[0], corner))


BOTH, FAR, CLOSED = (build_layers(room(*doors)) for doors in ((NEAR_DOOR, FAR_DOOR), (FAR_DOOR,), ()))


class Jobs:
    """Worker that runs jobs at once, or keeps them while ``held``."""

    def __init__(self) -> None:
        self.held = False
        self.waiting: list[Callable[[], None]] = []

    def __call__(self, work: Any, cancelled: Any, done: Callable[[Any], None]) -> None:
        if self.held:
            result = work(cancelled)
            self.waiting.append(lambda: done(result))
        else:
            done(work(cancelled))

    def finish(self) -> None:
        """Hand over the results of jobs that wait, and of those that they start."""
        self.held = False
        while self.waiting:
            self.waiting.pop(0)()


def loop(**options: Any) -> ClosedLoop:
    """Return a robot in a room with two doors that has driven for a second to its goal."""
    driving = ClosedLoop(World(room(NEAR_DOOR, FAR_DOOR), START), **options)
    driving.run(0.3)
    driving.send_goal(GOAL)
    driving.run(1.0)
    return driving


def move_base(driving: ClosedLoop) -> MoveBaseNode:
    node = driving.graph.nodes["move_base"]
    assert isinstance(node, MoveBaseNode)
    return node


def crosses(plan: PlanResult, door: tuple[float, float]) -> bool:
    at_wall = np.abs(plan.poses[:, 0] - 3.0) < 0.1
    return bool(at_wall.any() and ((door[0] < plan.poses[at_wall, 1]) & (plan.poses[at_wall, 1] < door[1])).all())


def test_a_plan_that_is_blocked_on_the_new_map_is_replaced() -> None:
    driving = loop(parameters={"move_base": {"planner_frequency": 0.0}})
    assert len(driving.plans) == 1 and crosses(driving.plans[0], NEAR_DOOR)
    move_base(driving).use_layers(FAR)
    driving.run(0.1)
    assert len(driving.plans) == 2 and crosses(driving.plans[1], FAR_DOOR)
    assert move_base(driving).busy


@pytest.mark.parametrize("cells", [0, 7])
def test_a_plan_that_is_free_on_the_new_map_is_followed_to_the_goal(cells: int) -> None:
    driving = loop(parameters={"move_base": {"planner_frequency": 0.0}})
    move_base(driving).use_layers(build_layers(shifted(room(NEAR_DOOR), cells)))
    driving.run(30.0)
    assert len(driving.plans) == 1
    assert driving.last_status() is Status.SUCCEEDED


def test_a_goal_that_no_path_leads_to_any_more_ends_with_the_reason() -> None:
    driving = loop()
    move_base(driving).use_layers(CLOSED)
    driving.run(1.0)
    assert driving.last_status() is Status.ABORTED
    assert "no free path" in driving.results[0].status.text


def test_obstacles_seen_before_are_still_avoided() -> None:
    world = World(room(NEAR_DOOR, FAR_DOOR), START)
    world.truth[:] = room(FAR_DOOR).data >= 50
    driving = ClosedLoop(world)
    driving.run(0.5)
    driving.send_goal(GOAL)
    driving.run(1.0)
    assert move_base(driving)._surroundings.seen() is not driving.layers.costmap
    grown = build_layers(shifted(room(NEAR_DOOR, FAR_DOOR), 9))
    move_base(driving).use_layers(grown)
    seen = move_base(driving)._surroundings.seen()
    cell = grown.grid.info.cell_of(2.95, 1.6)
    assert cell is not None and seen.data[cell] >= 253 and grown.costmap.data[cell] < 253


def test_plans_are_stored_under_the_version_of_their_map() -> None:
    ids: list[str] = []
    driving = loop(reuse=ReuseSetup("office", "v1"))
    for version in ("v1", "v2", None):
        move_base(driving).use_layers(BOTH, version)
        driving.plans.clear()
        driving.run(1.0)
        ids.append(driving.plans[-1].id)
    assert ids[2] == "" and len({*ids}) == 3
    assert move_base(driving)._planner._processor._scope.version == ""


# -- plans that are made while the map is replaced ---------------------------------------------------------------------


def planning(jobs: Jobs, *doors: tuple[float, float]) -> ClosedLoop:
    """Return a robot whose first plan is being made, on a map with these doors."""
    driving = ClosedLoop(World(room(*doors), START), worker=jobs, reuse=ReuseSetup("office", "v1"))
    driving.run(0.3)
    jobs.held = True
    driving.send_goal(GOAL)
    assert len(jobs.waiting) == 1
    return driving


def test_a_plan_that_was_made_on_the_map_before_is_followed_but_not_stored() -> None:
    jobs = Jobs()
    driving = planning(jobs, NEAR_DOOR, FAR_DOOR)
    moved = build_layers(shifted(room(NEAR_DOOR), 5))
    move_base(driving).use_layers(moved, "v2")
    jobs.finish()
    [plan] = driving.plans
    assert plan.id == "" and crosses(plan, NEAR_DOOR)
    centres = moved.grid.info.to_world(plan.cells)
    assert np.hypot(*(centres[-1] - GOAL[:2])) < 0.05


def test_a_plan_that_was_made_on_the_map_before_is_made_again_if_it_is_blocked() -> None:
    jobs = Jobs()
    driving = planning(jobs, NEAR_DOOR, FAR_DOOR)
    move_base(driving).use_layers(FAR, "v2")
    jobs.finish()
    [plan] = driving.plans
    assert plan.id and crosses(plan, FAR_DOOR)


def test_a_path_that_was_not_found_on_the_map_before_is_searched_again() -> None:
    jobs = Jobs()
    driving = planning(jobs)
    move_base(driving).use_layers(BOTH, "v2")
    jobs.finish()
    driving.run(1.2)
    assert not driving.results and driving.plans


# -- masks -------------------------------------------------------------------------------------------------------------


def masked(limit: int) -> MapLayers:
    grid = room(NEAR_DOOR, FAR_DOOR)
    return build_layers(grid, speed=GridMap(np.full(grid.info.shape, limit, np.int8), grid.info))


def test_the_speed_mask_is_that_of_the_new_map() -> None:
    parameters = {"speed_filter": {"filter_mask": "slow", "type": 1}}
    speed = GridMap(np.full(BOTH.grid.info.shape, 100, np.int8), BOTH.grid.info)
    driving = loop(masks={"speed": speed}, parameters=parameters)
    assert max(command.linear.x for command in driving.commands) > 0.25
    move_base(driving).use_layers(masked(20))
    driving.run(0.5)
    assert driving.commands[-1].linear.x < 0.2
    with pytest.raises(Unavailable, match="mask 'slow' was not loaded"):
        move_base(driving).use_layers(BOTH)
    driving.run(0.2)
    assert driving.commands[-1].linear.x < 0.2
