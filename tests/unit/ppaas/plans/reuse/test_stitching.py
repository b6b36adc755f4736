"""An offered plan is drivable, connects the requested ends, and costs no more than reported."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas import planners
from ppaas.costmap.costmap import Costmap
from ppaas.errors import PlanningError
from ppaas.geometry import Pose2D, yaw_of
from ppaas.maps.grid import GridInfo
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.path import path_cost
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.weights import passable
from ppaas.plans.reuse.crossed_cells import crossed_by, first_blocked
from ppaas.plans.reuse.stitching import LiveAndBareCostmaps, Offer, offer
from ppaas.plans.stored import PlanQuery, StoredPlan
from tests.reference.planners.dijkstra import cost_field, weight
from tests.reference.plans.plan_bytes import cells_on
from tests.support.world.grids import centre, costmap, of

CHEAPEST = Traits(optimal=Optimal.ALWAYS)
SOME = Traits()
PARAMETERS = {"allow_unknown": False, "smooth": False}
DIJKSTRA = planners.create("dijkstra", **PARAMETERS)


def stored(bare: Costmap, result: PlanResult, first: int = 0, last: int | None = None) -> StoredPlan:
    """Return a plan as stored, or a part of it."""
    ends = [(float(row[0]), float(row[1]), yaw_of(*row[3:])) for row in result.poses[[0, -1]]]
    stop = len(result.poses) if last is None else last + 1
    return StoredPlan(
        "p1", "v1", "dijkstra", ends[0], ends[1], result.length, result.poses[first:stop],
        whole=(first, stop) == (0, len(result.poses)),
        conditions={**PARAMETERS, "bare_map": True, "robot_radius": 0.2},
    )  # fmt: skip


def query(start: Pose2D, goal: Pose2D, tolerance: float = 2.5) -> PlanQuery:
    return PlanQuery(start, goal, "v1", "dijkstra", PARAMETERS, 0.2, tolerance)


def near(costs: NDArray[np.uint8], place: Pose2D, down: float, right: float) -> Pose2D:
    """Return a position some cells away, clipped to the map."""
    height, width = costs.shape
    x, y = min(max(place.x + right, 0.01), width - 0.01), min(max(place.y + down, 0.01), height - 0.01)
    return Pose2D(x, y, place.theta)


@st.composite
def kept_plans(draw: st.DrawFn) -> tuple[Costmap, Costmap, PlanResult, Pose2D, Pose2D]:
    """Draw a map, a copy with more obstacles, a plan made on the first, and ends near its own."""
    height, width = draw(st.integers(1, 14)), draw(st.integers(2, 14))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    costs = random.choice([0, 0, 0, 0, 0, 60, 252, 254], (height, width)).astype(np.uint8)
    free = np.argwhere(costs < 253)
    assume(len(free) > 1)
    bare = of(costs)
    ends = [centre(bare, *free[draw(st.integers(0, len(free) - 1))].tolist(), theta=0.5) for _ in range(2)]
    try:
        result = DIJKSTRA.plan(bare, PlanRequest(*ends))
    except PlanningError:
        assume(False)
    seen = random.random((height, width)) < draw(st.sampled_from([0.0, 0.02, 0.3]))
    live = of(
        np.where(seen, np.maximum(costs, random.choice([253, 254, 200], (height, width))), costs).astype(np.uint8)
    )
    shift = st.floats(-1.5, 1.5)
    start, goal = (near(costs, end, draw(shift), draw(shift)) for end in ends)
    return bare, live, result, draw(st.sampled_from([start, ends[0]])), draw(st.sampled_from([goal, ends[1]]))


def _assert_drivable(live: Costmap, made: Offer, start: Pose2D, goal: Pose2D) -> None:
    assert made.poses[0, :2].tolist() == pytest.approx([start.x, start.y], abs=1e-6)
    assert made.poses[-1, :2].tolist() == pytest.approx([goal.x, goal.y], abs=1e-6)
    assert yaw_of(*made.poses[-1, 3:]) == pytest.approx(goal.theta)
    for cell in cells_on(live.info, made.poses[:, :2].tolist()):
        assert np.isfinite(weight(int(live.data[cell]), False)), f"it crosses {cell}"
    assert made.cost == pytest.approx(path_cost(live, made.cells))


@given(kept_plans())
def test_offer_is_free_and_its_bounds_hold(
    case: tuple[Costmap, Costmap, PlanResult, Pose2D, Pose2D],
) -> None:
    bare, live, result, start, goal = case
    made, verdict = offer(
        stored(bare, result), query(start, goal), LiveAndBareCostmaps(live, bare, False), CHEAPEST, bound=10.0
    )
    assert (made is not None) is verdict.taken
    if made is None:
        return
    _assert_drivable(live, made, start, goal)
    field = cost_field(live.data, [live.info.cell_of(goal.x, goal.y)], allow_unknown=False)
    cheapest = field[live.info.cell_of(start.x, start.y)]
    assert made.lower_bound.at_least <= cheapest * (1 + 1e-9)
    assert made.cost <= cheapest * (1 + made.over_cheapest) + 1e-6


@given(kept_plans(), st.data())
def test_stitched_segment_is_within_the_bound(
    case: tuple[Costmap, Costmap, PlanResult, Pose2D, Pose2D], data: st.DataObject
) -> None:
    bare, live, result, start, goal = case
    last = data.draw(st.integers(0, len(result.poses) - 1))
    part = stored(bare, result, data.draw(st.integers(0, last)), last)
    start, goal = (near(bare.data, Pose2D(*place[:2]), 0.2, 0.2) for place in part.poses[[0, -1]].tolist())
    made, _ = offer(part, query(start, goal), LiveAndBareCostmaps(live, bare, False), CHEAPEST, bound=0.5)
    if made is not None:
        _assert_drivable(live, made, start, goal)
        field = cost_field(live.data, [live.info.cell_of(goal.x, goal.y)], allow_unknown=False)
        assert made.cost <= 1.5 * field[live.info.cell_of(start.x, start.y)] + 1e-6


def _corridor(length: int = 60) -> tuple[Costmap, PlanResult]:
    bare = costmap("\n".join(["." * length] * 5))
    return bare, DIJKSTRA.plan(bare, PlanRequest(centre(bare, 2, 0), centre(bare, 2, length - 1)))


def test_plan_between_the_exact_ends_is_offered_unchanged() -> None:
    bare, result = _corridor()
    ends = centre(bare, 2, 0), centre(bare, 2, 59)
    made, verdict = offer(stored(bare, result), query(*ends), LiveAndBareCostmaps(bare, bare, False), CHEAPEST)
    assert made is not None
    assert verdict.criterion == "bound"
    assert made.poses.tobytes() == result.poses.tobytes()
    assert made.cells.tolist() == result.cells.tolist()
    assert (made.origin, made.cost, made.over_cheapest) == ("reused", result.cost, pytest.approx(0.0, abs=1e-6))


def test_other_heading_at_an_end_changes_only_that_pose() -> None:
    bare, result = _corridor()
    made, _ = offer(
        stored(bare, result),
        query(centre(bare, 2, 0, 1.0), centre(bare, 2, 59, 2.0)),
        LiveAndBareCostmaps(bare, bare, False),
        SOME,
    )
    assert made is not None
    assert yaw_of(*made.poses[0, 3:]) == pytest.approx(1.0)
    assert yaw_of(*made.poses[-1, 3:]) == pytest.approx(2.0)
    assert made.poses[1:-1].tobytes() == result.poses[1:-1].tobytes()


def test_robot_beside_a_plan_is_offered_its_remaining_segment() -> None:
    bare, result = _corridor()
    part = stored(bare, result, 20, 50)
    made, _ = offer(
        part, query(centre(bare, 3, 20), centre(bare, 1, 50)), LiveAndBareCostmaps(bare, bare, False), CHEAPEST, 0.1
    )
    assert made is not None
    assert made.origin == "stitched"
    assert made.over_cheapest <= 0.1


def test_plan_with_a_new_obstacle_is_refused() -> None:
    bare, result = _corridor()
    data = bare.data.copy()
    data[2, 30] = 254
    made, verdict = offer(
        stored(bare, result),
        query(centre(bare, 2, 0), centre(bare, 2, 59)),
        LiveAndBareCostmaps(of(data), bare, False),
        CHEAPEST,
    )
    assert made is None
    assert verdict.criterion == "costmap"
    assert verdict.numbers == {"row": 2, "column": 30}


def test_plan_that_has_become_expensive_is_refused() -> None:
    bare, result = _corridor()
    data = bare.data.copy()
    data[2, 10:50] = 252
    ends = centre(bare, 2, 0), centre(bare, 2, 59)
    for traits in (CHEAPEST, SOME):
        made, verdict = offer(stored(bare, result), query(*ends), LiveAndBareCostmaps(of(data), bare, False), traits)
        assert made is None
        assert verdict.criterion == "bound"


def test_detour_around_an_obstacle_unknown_here_is_refused() -> None:
    bare = costmap("\n".join(["." * 30] * 20))
    walled = bare.data.copy()
    walled[:18, 15] = 254
    detour = DIJKSTRA.plan(of(walled), PlanRequest(centre(bare, 2, 0), centre(bare, 2, 29)))
    seen = replace(stored(bare, detour), conditions={**PARAMETERS, "bare_map": False, "robot_radius": 0.2})
    ends = query(centre(bare, 2, 0), centre(bare, 2, 29))
    for traits in (CHEAPEST, SOME):
        assert offer(seen, ends, LiveAndBareCostmaps(bare, bare, False), traits)[0] is None


def test_given_detour_is_not_taken_as_the_planners_own() -> None:
    bare = costmap("\n".join(["." * 30] * 20))
    walled = bare.data.copy()
    walled[:18, 15] = 254
    ends = centre(bare, 2, 0), centre(bare, 2, 29)
    detour = DIJKSTRA.plan(of(walled), PlanRequest(*ends))
    forged, straight = stored(bare, detour), stored(bare, DIJKSTRA.plan(bare, PlanRequest(*ends)))
    costmaps = LiveAndBareCostmaps(bare, bare, False)
    for traits in (CHEAPEST, SOME):
        assert offer(forged, query(*ends), costmaps, traits)[0] is not None, (
            "a plan marked as the planner's own is accepted"
        )
        assert offer(replace(forged, given=True), query(*ends), costmaps, traits)[0] is None
        made, _ = offer(replace(straight, given=True), query(*ends), costmaps, traits)
        assert made is not None
        assert made.lower_bound.by == "distance"


def test_plan_of_another_robot_radius_is_refused() -> None:
    bare = costmap("\n".join(["o" * 30] * 3))
    result = DIJKSTRA.plan(bare, PlanRequest(centre(bare, 1, 0), centre(bare, 1, 29)))
    ends = query(centre(bare, 1, 0), centre(bare, 1, 29))
    kept = stored(bare, result)
    assert offer(kept, ends, LiveAndBareCostmaps(bare, bare, False), CHEAPEST)[0] is not None
    assert offer(kept, replace(ends, robot_radius=0.3), LiveAndBareCostmaps(bare, bare, False), CHEAPEST)[0] is None


def test_kinematic_query_needs_matching_headings() -> None:
    bare, result = _corridor()
    start, goal = centre(bare, 2, 0), centre(bare, 2, 59)
    turns = Traits(kinematic=True)
    for request, taken in ((query(start, goal), True), (query(start, centre(bare, 2, 59, 1.0)), False)):
        kinematic = replace(request, kinematic=True)
        assert (
            offer(stored(bare, result), kinematic, LiveAndBareCostmaps(bare, bare, False), turns)[0] is not None
        ) is taken
    beside = replace(query(centre(bare, 1, 0), goal), kinematic=True)
    made, verdict = offer(stored(bare, result), beside, LiveAndBareCostmaps(bare, bare, False), turns)
    assert made is None
    assert verdict.criterion == "ends"


INFO = GridInfo(0.5, 20, 20, Pose2D(-1.0, 2.0, 0.3))

coordinates = st.floats(min_value=0.0, max_value=20.0, allow_nan=False)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=4))
def test_all_crossed_cells_are_found(places: list[tuple[float, float]]) -> None:
    points = INFO.to_world(np.array(places) - 0.5)
    crossed = crossed_by(INFO, points)
    found = {(row, column) for row, column in np.concatenate((crossed.cells, crossed.corners)).tolist()}
    assert cells_on(INFO, points.tolist()) <= found


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1, max_size=4))
def test_each_crossed_cell_neighbours_the_previous_one(places: list[tuple[float, float]]) -> None:
    points = INFO.to_world(np.array(places) - 0.5)
    cells = crossed_by(INFO, points).cells
    assert cells[0].tolist() == INFO.to_cells(points[0]).tolist()
    assert cells[-1].tolist() == INFO.to_cells(points[-1]).tolist()
    assert set(np.abs(np.diff(cells, axis=0)).max(axis=1, initial=1).tolist()) <= {1}


def test_path_along_centres_crosses_its_cells_and_corners() -> None:
    info = GridInfo(1.0, 5, 5)
    crossed = crossed_by(info, info.to_world([[0, 0], [0, 1], [1, 2]]))
    assert crossed.cells.tolist() == [[0, 0], [0, 1], [1, 2]]
    assert sorted(crossed.corners.tolist()) == [[0, 2], [1, 1]]


@pytest.mark.parametrize(
    ("picture", "blocked"),
    [("...\n...\n...", None), ("...\n.#.\n...", (1, 1)), ("..?\n...\n...", (2, 2)), ("...\ni..\n...", (1, 0))],
)
def test_path_is_blocked_by_obstacles_on_it_or_at_a_corner(picture: str, blocked: tuple[int, int] | None) -> None:
    live = costmap(picture)
    path = crossed_by(live.info, live.info.to_world([[0, 0], [1, 1], [2, 2]]))
    assert first_blocked(live, path, passable(False)) == blocked


def test_a_path_that_leaves_the_map_is_blocked() -> None:
    live = costmap("...\n...")
    path = crossed_by(live.info, live.info.to_world([[0, 0], [0, 7]]))
    assert first_blocked(live, path, passable(True)) == (0, 3)
