"""The earliest path among others, and the cheapest with turns, agree with their slow twins and are valid."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fleet.checking import faults_of
from ppaas.fleet.kernels.board import seeded
from ppaas.fleet.kernels.neighbourhood import memory_of
from ppaas.fleet.kernels.timed_search import Schedule, mark, search
from ppaas.fleet.kernels.turning_search import Prices, search_turning
from ppaas.fleet.plan import FleetPlan
from ppaas.fleet.problem import distances_from
from tests.reference.fleet import searches as turns
from tests.reference.fleet.searches import cheapest, earliest
from tests.support.fleet.halls import Hall, halls
from tests.support.fleet.walks import walks

STEPS = 9


@given(halls(most_robots=4), st.data())
def test_the_earliest_path_agrees_with_its_twin(hall: Hall, data: st.DataObject) -> None:
    others = data.draw(walks(hall.roadmap, hall.starts[1:], STEPS))
    start, goal = hall.starts[0], hall.goals[0]
    paths = np.concatenate([np.full((1, STEPS), start, np.int32), others])
    nothing = np.zeros(len(paths), np.int32)
    schedule = Schedule(np.zeros((STEPS, len(hall.roadmap)), np.int32), paths, nothing, nothing)
    for robot in range(1, len(paths)):
        mark(schedule, robot, robot + 1)
    distances = distances_from(hall.roadmap, np.array([goal], np.int32))[0]
    memory = memory_of(STEPS, len(hall.roadmap), 1, Prices(1, 0, np.zeros(len(paths), np.int64), hall.roadmap.cells))
    arrival = search(hall.roadmap.neighbours, distances, schedule, memory, 0, start, goal, STEPS - 1, 1, seeded(0))
    twin = earliest(hall.roadmap, others.tolist() or [[-1] * STEPS], start, goal)
    assert arrival == (-1 if twin is None else twin)
    if arrival >= 0:
        ends = [goal, *others[:, -1].tolist()]
        assert faults_of(hall.roadmap, FleetPlan(schedule.paths.T, 0), hall.starts, ends) == []


@given(halls(most_robots=4), st.integers(1, 3), st.integers(1, 9), st.data())
def test_the_cheapest_path_agrees_with_its_twin(hall: Hall, step: int, quarter: int, data: st.DataObject) -> None:
    roadmap, start, goal = hall.roadmap, hall.starts[0], hall.goals[0]
    others = data.draw(walks(roadmap, hall.starts[1:], STEPS))
    paths = np.concatenate([np.full((1, STEPS), start, np.int32), others])
    nothing = np.zeros(len(paths), np.int32)
    schedule = Schedule(np.zeros((STEPS, len(roadmap)), np.int32), paths, nothing, nothing)
    for robot in range(1, len(paths)):
        mark(schedule, robot, robot + 1)
    prices = Prices(step, quarter, np.zeros(len(paths), np.int64), roadmap.cells)
    memory, distances = (
        memory_of(STEPS, len(roadmap), 1, prices),
        distances_from(roadmap, np.array([goal], np.int32))[0],
    )
    limit = len(memory.heads) - 2
    cost = search_turning(roadmap.neighbours, distances, schedule, memory, prices, 0, start, goal, limit, 1, seeded(0))
    twin = cheapest(roadmap, others.tolist() or [[-1] * STEPS], start, goal, step, quarter)
    assert cost == (-1 if twin is None else twin)
    if cost >= 0:
        plan, ends = FleetPlan(schedule.paths.T, 0), [goal, *others[:, -1].tolist()]
        assert faults_of(roadmap, plan, hall.starts, ends) == []
        assert cost == step * plan.arrivals[0] + quarter * turns.count(roadmap, schedule.paths[0].tolist())
