"""Variants of a planning container: planners and costmaps of requests with parameters.

The kind, and its members: every parameter of planners and of the global costmap, in a robot's file, a request over REST
and on the command line; unknown ones and wrong types are refused with a list of those that exist.
"""

import numpy as np
import pytest

from ppaas.clone.planning_variants import MOST_COSTMAPS, PlanningVariants, allows_unknown, planner_with, split
from ppaas.costmap.build_layers import build_layers
from ppaas.distribution import BrokenPlugin
from ppaas.errors import InvalidParameter, NotFound, NoValidPath
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.planners.base import PlanRequest
from ppaas.planners.registry import PLANNERS
from ppaas.planners.watch import proceed
from ppaas.plans.reuse.setup import ReuseSetup
from ppaas.robot_model.description import circumscribed_radius
from ppaas.robot_model.known_models import robot_model
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Door, Zone, ZoneSet
from tests.support.world.planar_world import walled_map

MAP = walled_map(6, 4, [(2.9, 0.0, 3.1, 2.5)])
LAYERS = build_layers(MAP)
SQUARE = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]


@pytest.fixture
def variants() -> PlanningVariants:
    return PlanningVariants(LAYERS, ReuseSetup("house", "v1"))


def test_parameters_are_those_of_the_costmap_and_of_the_planner():
    given = {"robot_radius": 0.3, "allow_unknown": False, "footprint": SQUARE, "lethal_cost_threshold": 99}
    assert split(given) == (
        {"robot_radius": 0.3, "footprint": SQUARE, "lethal_cost_threshold": 99},
        {"allow_unknown": False},
    )


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"inflation_radius": 0.3}, {"inflation_radius": 0.3}),
        ({"cost_scaling_factor": 1.0}, {"cost_scaling_factor": 1.0}),
        ({"robot_radius": 0.4}, {"robot_radius": 0.4}),
        ({"footprint": SQUARE}, {"robot_radius": circumscribed_radius(SQUARE)}),
        ({"footprint": SQUARE, "robot_radius": 0.2}, {"robot_radius": 0.2}),
        ({"lethal_cost_threshold": 100, "allow_unknown": False}, {"lethal_cost_threshold": 100}),
    ],
)
def test_a_costmap_is_that_of_a_map_built_with_the_parameters(variants, given, expected):
    graded = GridMap(np.where(MAP.data == 100, np.int8(80), MAP.data), MAP.info)
    variants = PlanningVariants(build_layers(graded), ReuseSetup())
    built = build_layers(graded, **({"robot_radius": 0.18} | expected))
    assert np.array_equal(variants.variant(given).costmap.data, built.costmap.data)


@pytest.mark.parametrize("given", [{}, {"inflation_radius": 0.55}, {"robot_radius": 0.18}, {"allow_unknown": False}])
def test_parameters_that_change_no_cost_share_the_usual_costmap(variants, given):
    assert variants.variant(given) is variants.usual
    assert variants.usual.costmap is LAYERS.costmap


def test_a_few_costmaps_and_planners_are_kept(variants):
    first = variants.variant({"inflation_radius": 0.1})
    assert variants.variant({"inflation_radius": 0.1}) is first
    for number in range(MOST_COSTMAPS):
        variants.variant({"inflation_radius": 0.2 + number})
    assert variants.variant({"inflation_radius": 0.1}) is not first
    planner = variants.planner("dijkstra", {"allow_unknown": False})
    assert variants.planner("global_planner/GlobalPlanner", {"allow_unknown": False}) is planner
    assert variants.planner("dijkstra", {"smooth": True}) is not planner


def test_plans_of_other_parameters_have_other_ids_and_conditions(variants):
    request = PlanRequest(Pose2D(1.0, 1.0), Pose2D(1.5, 1.0))
    found = {}
    for given in ({}, {"allow_unknown": False}, {"robot_radius": 0.1}, {"inflation_radius": 0.2}, {"smooth": True}):
        costmap, processor = variants.variant(given)
        result = processor.plan(variants.planner("dijkstra", given), costmap, request)
        found[result.id] = result.conditions
    assert len(found) == 5
    assert [conditions.get("global_costmap") for conditions in found.values()] == [
        None, None, None, {"inflation_radius": 0.2}, None,
    ]  # fmt: skip
    assert [conditions["robot_radius"] for conditions in found.values()] == [0.18, 0.18, 0.1, 0.18, 0.18]


WAY_ROUND = ZoneSet([Zone(LineString([[2.9, 2.6], [2.9, 3.9]]), Door(name="hall"))])
"""Door in the opening of the wall of `MAP`."""


def test_doors_of_the_map_are_walls_where_that_is_asked_for() -> None:
    variants = PlanningVariants(build_layers(MAP, zones=WAY_ROUND), ReuseSetup("house", "v1"))
    request, conditions = PlanRequest(Pose2D(1.0, 1.0), Pose2D(5.0, 1.0)), []
    for given in ({}, {"shut_doors": False}, {"shut_doors": True, "inflation_radius": 0.3}, {"shut_doors": True}):
        costmap, processor = variants.variant(given)
        planner = variants.planner("hub_labels", given)
        if given.get("shut_doors"):
            with pytest.raises(NoValidPath):
                processor.plan(planner, costmap, request)
            found = processor.plan(planner, costmap, PlanRequest(Pose2D(1.0, 1.0), Pose2D(1.5, 1.0)))
        else:
            found = processor.plan(planner, costmap, request)
        conditions.append(found.conditions.get("shut_doors"))
    assert conditions == [None, None, True, True]
    assert variants.variant({"shut_doors": True}) is variants.variant({"shut_doors": True})


def test_lengths_are_measured_where_costs_are_to_be_lengths() -> None:
    variants = PlanningVariants(build_layers(MAP, zones=WAY_ROUND), ReuseSetup())
    assert variants.lengths({}, 1, proceed) is None
    found = {}
    for shut in (False, True):
        lengths = variants.lengths({"lengths": True, "shut_doors": shut, "robot_radius": 0.2}, 1, proceed)
        assert lengths is not None
        cells = [lengths.cell(1.0, 1.0), lengths.cell(5.0, 1.0)]
        found[shut] = lengths.between(cells[:1], cells[1:])[0, 0]
    assert 5.0 < found[False] < 7.0
    assert found[True] == np.inf


@pytest.mark.parametrize("name", ["shut_doors", "lengths"])
def test_switches_are_true_or_false(variants, name: str) -> None:
    assert variants.allows_unknown({name: True})
    with pytest.raises(InvalidParameter, match=f"{name} must be true or false"):
        variants.allows_unknown({name: "yes"})


def test_a_planner_that_uses_the_outline_gets_it(variants):
    assert variants.planner("lattice", {"footprint": SQUARE}).parameters.footprint == tuple(map(tuple, SQUARE))


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        (
            {"alow_unknown": False},
            r"no parameter 'alow_unknown'; known: allow_unknown, smooth.*; of the costmap: cost_sc",
        ),
        ({"allow_unknown": "no"}, r"'allow_unknown' of planner 'dijkstra': Expected `bool`"),
        ({"inflation_radius": -1}, "inflation_radius must be from 0 to 100"),
        ({"robot_radius": 100}, "robot_radius must be from 0 to 100"),
        ({"footprint": [[0, 0]]}, "at least three corners"),
    ],
)
def test_unknown_and_invalid_parameters_are_refused(variants, given, reason):
    with pytest.raises(InvalidParameter, match=reason):
        variants.planner("dijkstra", given)


def test_an_unknown_planner_is_reported(variants):
    with pytest.raises(NotFound, match="dijkstra"):
        variants.planner("teleport", {"allow_unknown": False})


def test_a_cost_matrix_has_the_parameter_allow_unknown_and_those_of_the_costmap(variants):
    assert allows_unknown({})
    assert not variants.allows_unknown({"allow_unknown": False, "robot_radius": 0.1})
    with pytest.raises(InvalidParameter, match="no parameter 'smooth'; known: allow_unknown, cost_scaling_factor"):
        allows_unknown({"smooth": True})
    with pytest.raises(InvalidParameter, match="allow_unknown must be true or false"):
        allows_unknown({"allow_unknown": 0})
    with pytest.raises(InvalidParameter, match="inflation_radius"):
        variants.allows_unknown({"inflation_radius": "wide"})


def test_a_planner_that_cannot_be_loaded_is_no_question_of_parameters(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_name: str) -> None:
        raise BrokenPlugin("planner 'theirs' cannot be loaded")

    monkeypatch.setattr(PLANNERS, "load", fail)
    with pytest.raises(BrokenPlugin, match=r"^planner 'theirs' cannot be loaded$"):
        planner_with(robot_model("turtlebot2"), "theirs", {})
