"""Drawn lanes become one network: they are connected where a person would say that they meet."""

import numpy as np
import pytest

from ppaas.fleet.lane_drawing import JOINS, STRAIGHT, DrawnLane, Network, lines_in, network_of
from ppaas.zones.shapes import LineString, MultiLineString, Polygon
from ppaas.zones.zone import KeepOut, Lane, Zone
from tests.support.fleet.lanes import line, ring


def ends(network: Network) -> list[tuple[float, float]]:
    """Return the places at which one part ends."""
    return sorted(tuple(network.places[place].tolist()) for place, others in network.near().items() if len(others) == 1)


def degrees(network: Network) -> dict[tuple[float, float], int]:
    """Return how many parts meet at each place."""
    found = {place: len(others) for place, others in network.near().items()}
    return {tuple(network.places[place].round(3).tolist()): count for place, count in found.items()}


def test_lanes_that_cross_meet_there() -> None:
    network = network_of([line((0, 0), (4, 0)), line((2, -1), (2, 3))])
    assert degrees(network) == {(0, 0): 1, (4, 0): 1, (2, 0): 4, (2, -1): 1, (2, 3): 1}


@pytest.mark.parametrize("gap", [0.0, 0.9 * JOINS, -0.9 * JOINS])
def test_a_lane_that_ends_on_another_joins_it_though_it_is_drawn_a_little_short_or_long(gap: float) -> None:
    network = network_of([line((0, 0), (4, 0)), line((2, 3), (2, gap))])
    assert len(network.near()) == 4
    assert sorted(degrees(network).values()) == [1, 1, 1, 3]


def test_a_lane_that_ends_farther_from_another_does_not_join_it() -> None:
    network = network_of([line((0, 0), (4, 0)), line((2, 3), (2, 1.1 * JOINS))])
    assert sorted(degrees(network).values()) == [1, 1, 1, 1]


def test_lanes_that_lie_on_each_other_are_one_with_the_ways_of_both() -> None:
    back = line((4, 0.05), (2, 0.05), name="back", one_way=True)
    network = network_of([line((0, 0), (6, 0), name="forth", one_way=True), back])
    xs = network.places[:, 0].round()
    ways = {(xs[one], xs[other]): name for (one, other), name in network.names.items()}
    assert ways == {(0, 2): "forth", (2, 4): "forth", (4, 6): "forth", (4, 2): "back"}


def test_ends_that_are_near_to_each_other_are_one_place() -> None:
    network = network_of([line((0, 0), (2, 0)), line((2.06, 0.06), (2, 3)), line((1.95, -0.05), (2, -3))])
    assert degrees(network)[2, 0] == 3
    assert len(ends(network)) == 3


def test_corners_that_nobody_would_see_are_left_out() -> None:
    wavy = np.stack([np.linspace(0, 5, 51), 0.4 * STRAIGHT * np.sin(np.linspace(0, 40, 51))], axis=1)
    network = network_of([DrawnLane("wavy", wavy, False)])
    assert len(network.places) < 10
    assert np.abs(network.places[:, 1]).max() <= STRAIGHT


def test_a_circle_keeps_its_shape() -> None:
    circle = ring(0.0, 0.0, 2.0, 200)
    network = network_of([circle])
    assert set(degrees(network).values()) == {2}
    middles = np.array([network.places[list(part)].mean(axis=0) for part in network.names])
    assert np.hypot(*middles.T) == pytest.approx(2.0, abs=STRAIGHT + 1e-9)


def test_only_lanes_among_zones_are_lines_and_each_of_several_is_one() -> None:
    square = Polygon([[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.0]]])
    several = MultiLineString([[[0.0, 0.0, 7.0], [1.0, 0.0, 7.0]], [[0.0, 1.0], [1.0, 1.0]]])
    zones = [Zone(square, KeepOut(name="k")), Zone(several, Lane(name="a", one_way=True)),
             Zone(LineString([[5.0, 5.0], [6.0, 5.0]]), Lane(name="b"))]  # fmt: skip
    lines = lines_in(zones)
    assert [(each.name, each.one_way, each.points.tolist()) for each in lines] == [
        ("a", True, [[0, 0], [1, 0]]), ("a", True, [[0, 1], [1, 1]]), ("b", False, [[5, 5], [6, 5]]),
    ]  # fmt: skip
