"""Plans between places in metres are valid, begin and end near the places, and keep robots apart."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from benchmarks.fleet.checking import faults_of
from ppaas.errors import InvalidInput, PlanningError
from ppaas.fleet import metric_roadmap
from ppaas.fleet.first_plan import first_plan
from ppaas.fleet.improvement import Improvement
from ppaas.fleet.lattice_roadmap import lattice_roadmap
from ppaas.fleet.metric_roadmap import WITHIN, MetricFloor
from ppaas.fleet.robot_sizes import RobotSizes
from tests.support.fleet.floors import Floor, floor_of, floors


def floor_for(floor: Floor, radius: float, margin: float = 0.02) -> MetricFloor:
    """Return a floor for robots of a radius; floors on which none fits are skipped."""
    try:
        return MetricFloor(*floor, lattice_roadmap(*floor, RobotSizes(radius, margin)), radius)
    except InvalidInput:
        assume(False)
        raise


@given(floors(turned=True), st.sampled_from([0.05, 0.15]), st.data())
def test_plans_between_places_beside_the_cells_are_valid(floor: Floor, radius: float, data: st.DataObject) -> None:
    made = floor_for(floor, radius)
    metric, size = made.metric, len(made.metric.roadmap)
    count = data.draw(st.integers(1, min(4, size)))
    starts, goals = (metric.centres[data.draw(st.permutations(range(size)))[:count]] for _ in range(2))
    aside = data.draw(st.floats(-0.2, 0.2)) * 0.02
    try:
        problem = made.problem(starts + aside, goals - aside)
        plan = first_plan(problem)
    except (InvalidInput, PlanningError):
        assume(False)
        raise
    for cells, places in ((problem.starts, starts), (problem.goals, goals)):
        assert np.hypot(*(metric.centres[cells] - places).T).max() <= WITHIN * metric.spacing
    improvement, left = Improvement(problem, plan), iter(range(20))
    improvement.run(lambda: next(left, None) is not None)
    for each in (plan, improvement.plan()):
        assert faults_of(metric.roadmap, each, problem.starts.tolist(), problem.goals.tolist()) == []
        for places in metric.centres[each.steps]:
            apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + np.eye(count) * 1e9
            assert apart.min() >= 2 * (radius + 0.02) - 1e-9


def test_robots_times_cells_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    made = floor_for(floor_of(np.zeros((20, 30), np.bool_)), 0.2)
    monkeypatch.setattr(metric_roadmap, "MOST_DISTANCES", 2 * len(made.metric.roadmap) - 1)
    places = made.metric.centres[:2]
    with pytest.raises(InvalidInput, match=r"2 robots on \d+ cells are too many: .*; plan for fewer robots"):
        made.problem(places, places)
