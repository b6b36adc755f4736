"""Memory of blocked paths: places are closed for a while after a plan was blocked there."""

import numpy as np
import pytest

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED, GridInfo, GridMap
from ppaas.navigation.blocked_path_memory import CLEAR, FIRST, LONGEST, WAIT, BlockedPathMemory
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.grid.dijkstra import Dijkstra
from tests.support.world import grids
from tests.support.world.rooms import room

START, GOAL = Pose2D(1.0, 1.0), Pose2D(1.0, 7.0)
NEAR_DOOR, FAR_DOOR = (2.5, 4.0), (8.5, 4.0)


def costs(*, near_open: bool) -> Costmap:
    """Return two rooms with a near door, which may be closed, and another one farther away."""
    grid = room(10.0, 8.0)
    cells = grid.data.copy()
    cells[79:81] = OCCUPIED
    for x, is_open in ((NEAR_DOOR[0], near_open), (FAR_DOOR[0], True)):
        column = round(x / 0.05)
        cells[79:81, column - 8 : column + 8] = 0 if is_open else OCCUPIED
    return build_layers(GridMap(cells, grid.info), robot_radius=0.18).costmap


OPEN, SHUT = costs(near_open=True), costs(near_open=False)


def plan(costmap: Costmap, start: Pose2D = START) -> PlanResult:
    return Dijkstra().plan(costmap, PlanRequest(start, GOAL))


def leads_by(found: PlanResult, door: tuple[float, float]) -> bool:
    return bool((np.hypot(*(found.poses[:, :2] - door).T) < 0.3).any())


def see_blocked(memory: BlockedPathMemory, now: float, pose: Pose2D = START) -> None:
    """Follow the plan through the near door, and find it blocked until ``now``, for the whole waiting time."""
    memory.take(plan(OPEN), OPEN, START, now - WAIT - 1.0)
    assert memory.take(plan(SHUT), SHUT, pose, now - WAIT) > 0.0
    assert memory.take(plan(SHUT), SHUT, pose, now) == 0.0


def test_detour_is_deferred_while_the_old_path_may_reopen() -> None:
    memory = BlockedPathMemory()
    assert memory.take(plan(OPEN), OPEN, START, 0.0) == 0.0
    longer = plan(SHUT).length - plan(OPEN).length
    for now in (1.0, 2.0, 1.0 + WAIT - 0.1):
        assert memory.take(plan(SHUT), SHUT, START, now) == pytest.approx(longer, abs=0.1)
        assert memory.mark(OPEN, now) is OPEN
    assert memory.take(plan(OPEN), OPEN, START, 1.0 + WAIT) == 0.0
    assert memory.take(plan(SHUT), SHUT, START, 2.0 + WAIT) > 0.0, "after the robot has driven on, waiting starts again"


def test_waiting_counts_from_when_the_path_was_blocked() -> None:
    memory = BlockedPathMemory()
    memory.take(plan(OPEN), OPEN, START, 0.0)
    assert memory.take(None, SHUT, START, 1.0) == 0.0
    assert memory.take(plan(SHUT), SHUT, START, WAIT) > 0.0
    assert memory.take(plan(SHUT), SHUT, START, 1.0 + WAIT) == 0.0


def test_short_detour_is_taken_sooner() -> None:
    memory = BlockedPathMemory()
    halfway = Pose2D(6.5, 1.0)
    through_near, through_far = plan(OPEN, halfway), plan(SHUT, halfway)
    longer = through_far.length - through_near.length
    assert 1.0 < longer < WAIT / 2
    memory.take(through_near, OPEN, halfway, 0.0)
    assert memory.take(through_far, SHUT, halfway, 1.0) > 0.0
    assert memory.take(through_far, SHUT, halfway, 1.1 + longer) == 0.0


def test_robot_keeps_its_detour_although_the_first_door_reopened() -> None:
    memory = BlockedPathMemory()
    see_blocked(memory, 0.0)
    marked = memory.mark(OPEN, 2.0)
    assert leads_by(plan(OPEN), NEAR_DOOR)
    assert leads_by(plan(marked), FAR_DOOR)
    assert (OPEN.data[marked.data == LETHAL_OBSTACLE] < LETHAL_OBSTACLE).any(), "the given costmap is not modified"


def test_closed_places_are_kept_as_changes_of_the_map() -> None:
    memory, static = BlockedPathMemory(), OPEN.read_only()
    see_blocked(memory, 0.0)
    marked = memory.mark(static, 2.0)
    assert (marked.data != static.data).any()
    assert grids.keeps_its_changes(marked, static)


def test_blocked_door_is_retried_after_growing_times() -> None:
    memory = BlockedPathMemory()
    now, waits = 0.0, []
    for _ in range(5):
        see_blocked(memory, now)
        shut = [wait for wait in range(1, 400) if memory.mark(OPEN, now + wait) is not OPEN]
        waits.append(len(shut) + 1)
        now += 400.0
    assert waits == [FIRST, 2 * FIRST, 4 * FIRST, LONGEST, LONGEST]


def test_small_detour_blocks_no_place() -> None:
    memory = BlockedPathMemory()
    blocked = OPEN.data.copy()
    memory.take(plan(OPEN), OPEN, START, 0.0)
    row, column = OPEN.info.to_cells(plan(OPEN).poses[len(plan(OPEN).poses) // 4][:2])
    blocked[row - 2 : row + 3, column - 2 : column + 3] = LETHAL_OBSTACLE
    around = Costmap(blocked, OPEN.info)
    assert memory.take(plan(around), around, START, 1.0) == 0.0
    assert memory.mark(OPEN, 2.0) is OPEN


def test_longer_plan_without_a_blockage_blocks_no_place() -> None:
    memory = BlockedPathMemory()
    memory.take(plan(OPEN), OPEN, START, 0.0)
    assert memory.take(plan(SHUT), OPEN, START, 1.0) == 0.0
    assert memory.mark(OPEN, 2.0) is OPEN


def test_plan_to_a_goal_that_has_moved_away_is_no_detour() -> None:
    memory = BlockedPathMemory()
    before, moved = (Dijkstra().plan(OPEN, PlanRequest(START, Pose2D(x, 7.0))) for x in (4.0, 6.0))
    memory.take(before, OPEN, START, 0.0)
    blocked = OPEN.data.copy()
    row, column = OPEN.info.to_cells(before.poses[-1][:2])
    blocked[row - 4 : row + 5, column - 4 : column + 5] = LETHAL_OBSTACLE
    assert moved.length - before.length > 1.0
    assert memory.take(moved, Costmap(blocked, OPEN.info), START, 1.0) == 0.0


@pytest.mark.parametrize("ends", ["another goal", "no plan"])
def test_another_goal_or_no_plan_clears_the_memory(ends: str) -> None:
    memory = BlockedPathMemory()
    memory.head_for(GOAL)
    see_blocked(memory, 0.0)
    if ends == "no plan":
        memory.take(None, SHUT, START, 2.0)
    else:
        memory.head_for(Pose2D(GOAL.x, GOAL.y - 2.0))
    assert memory.mark(OPEN, 3.0) is OPEN


def test_moving_goal_keeps_the_memory() -> None:
    memory = BlockedPathMemory()
    memory.head_for(GOAL)
    see_blocked(memory, 0.0)
    for step in range(1, 5):
        memory.head_for(Pose2D(GOAL.x, GOAL.y - 0.5 * step))
    assert leads_by(plan(memory.mark(OPEN, 3.0)), FAR_DOOR)


def test_cells_around_the_robot_are_not_blocked() -> None:
    memory = BlockedPathMemory()
    here = Pose2D(NEAR_DOOR[0], NEAR_DOOR[1] - CLEAR + 0.1)
    see_blocked(memory, 1.0, here)
    marked = memory.mark(OPEN, 2.0)
    rows, columns = np.nonzero((marked.data == LETHAL_OBSTACLE) & (OPEN.data != LETHAL_OBSTACLE))
    blocked_places = OPEN.info.to_world(np.stack((rows, columns), axis=1))
    assert not (np.hypot(*(blocked_places - here[:2]).T) < 0.2).any()


# -- another map -------------------------------------------------------------------------------------------------------


def moved(costmap: Costmap, cells: int) -> Costmap:
    """Return a costmap with more free cells around it, so that its corner is elsewhere."""
    info, data = costmap.info, np.pad(costmap.data, cells)
    corner = info.origin @ Pose2D(-cells * info.resolution, -cells * info.resolution)
    return Costmap(data, GridInfo(info.resolution, data.shape[1], data.shape[0], corner))


def test_closed_places_stay_in_place_on_a_map_whose_corner_is_elsewhere() -> None:
    memory = BlockedPathMemory()
    see_blocked(memory, 0.0)
    memory.carry(OPEN.info, moved(OPEN, 11))
    assert leads_by(plan(memory.mark(moved(OPEN, 11), 3.0)), FAR_DOOR)


def test_a_detour_is_deferred_on_a_map_whose_corner_is_elsewhere() -> None:
    memory = BlockedPathMemory()
    memory.take(plan(OPEN), OPEN, START, 0.0)
    memory.carry(OPEN.info, moved(OPEN, 11))
    assert memory.take(plan(moved(SHUT, 11)), moved(SHUT, 11), START, 1.0) > 0.0


@pytest.mark.parametrize("after", [SHUT, moved(SHUT, 11)])
def test_no_detour_is_deferred_around_what_the_new_map_blocks(after: Costmap) -> None:
    memory = BlockedPathMemory()
    memory.take(plan(OPEN), OPEN, START, 0.0)
    memory.carry(OPEN.info, after)
    assert memory.take(plan(after), after, START, 1.0) == 0.0


def test_what_the_new_map_does_not_cover_is_forgotten() -> None:
    memory = BlockedPathMemory()
    see_blocked(memory, 0.0)
    small = Costmap(np.zeros((10, 10), np.uint8), GridInfo(0.05, 10, 10))
    memory.carry(OPEN.info, small)
    assert memory.mark(small, 1.0) is small
