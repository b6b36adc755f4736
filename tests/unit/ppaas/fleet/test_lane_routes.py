"""Shortest ways along lanes, from place to place and between poses."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, NotFound, NoValidPath
from ppaas.fleet.lane_routes import SPACING, LaneGraph
from ppaas.geometry import Pose2D
from ppaas.zones.shapes import LineString
from ppaas.zones.zone import Lane, Zone


def lane(name: str, *points: tuple[float, float], one_way: bool = False) -> Zone:
    return Zone(LineString([list(point) for point in points]), Lane(name=name, one_way=one_way))


SQUARE = [lane("north", (0, 0), (0, 4)), lane("east", (0, 4), (6, 4), one_way=True), lane("short", (0, 0), (6, 4))]


def numbers(graph: LaneGraph, start: int, goal: int) -> list[int]:
    return [place.number for place in graph.route(start, goal).places]


def test_a_route_is_the_shortest_in_the_direction_of_the_lanes() -> None:
    graph = LaneGraph(SQUARE)
    assert numbers(graph, 1, 3) == [1, 3]
    assert graph.route(1, 3).length == pytest.approx(math.hypot(6, 4))
    assert numbers(graph, 2, 3) == [2, 3]
    assert numbers(graph, 3, 2) == [3, 1, 2], "east is one way"
    assert numbers(graph, 2, 2) == [2]
    assert len(set(graph.route(3, 2).parts)) == 2


def test_places_that_are_not_connected_or_not_there_are_named() -> None:
    graph = LaneGraph([lane("one", (0, 0), (1, 0)), lane("two", (5, 5), (6, 5))])
    with pytest.raises(NoValidPath, match="no lanes lead from node 1 to node 3"):
        graph.route(1, 3)
    for wrong in (0, 5):
        with pytest.raises(NotFound, match=f"unknown node '{wrong}'; nodes are numbered from 1 to 4"):
            graph.route(1, wrong)
    with pytest.raises(InvalidInput, match="the map has no lanes"):
        LaneGraph([])


def test_a_robot_does_not_drive_back_to_the_place_that_is_nearest() -> None:
    graph = LaneGraph([lane("line", (0, 0), (4, 0), (4, 4))])
    between = graph.between(Pose2D(0.5, 0.2), Pose2D(4.1, 3.5))
    assert [place.number for place in between.places] == [2]
    before = graph.between(Pose2D(-0.5, 0.0), Pose2D(4.0, 5.0))
    assert [place.number for place in before.places] == [1, 2, 3]


def test_a_path_leads_along_the_route_in_short_steps() -> None:
    route = LaneGraph([lane("line", (0, 0), (4, 0), (4, 4))]).route(1, 3)
    poses = route.poses(Pose2D(-1.0, 0.0), Pose2D(4.0, 5.0, 1.0))
    assert np.hypot(*np.diff(poses[:, :2], axis=0).T).max() <= SPACING + 1e-9
    assert poses[0, :2].tolist() == [-1.0, 0.0]
    assert poses[-1, :2].tolist() == [4.0, 5.0]
    assert 2.0 * math.atan2(poses[-1, 5], poses[-1, 6]) == pytest.approx(1.0)
    assert len(route.poses()) == 81


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=12))
def test_no_other_way_is_shorter(pairs: list[tuple[int, int]]) -> None:
    places = [(3.0 * math.cos(k), 3.0 * math.sin(k)) for k in range(6)]
    drawn = [lane(f"{i}", places[a], places[b], one_way=True) for i, (a, b) in enumerate(pairs) if a != b]
    if not drawn:
        return
    graph = LaneGraph(drawn)
    here = {graph.nearest(Pose2D(*place)) for place in places}
    for start, goal in itertools.product(here, here):
        try:
            length = graph.route(start, goal).length
        except NoValidPath:
            continue
        for middle in here:
            try:
                around = graph.route(start, middle).length + graph.route(middle, goal).length
            except NoValidPath:
                continue
            assert length <= around + 1e-9
