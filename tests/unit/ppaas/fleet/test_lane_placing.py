"""Cells along lanes: at ends, junctions and corners, as near to each other as robots may stand; chains between them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import DrawnLane, network_of
from ppaas.fleet.lane_placing import SHARPEST, Placed, chains_of, placed_on
from tests.support.fleet.lanes import SITE, line, ring


def placed(*lines: DrawnLane, spacing: float = 0.6) -> Placed:
    return placed_on(network_of(lines), spacing)


def has(cells: Placed, *places: tuple[float, float]) -> bool:
    """Return whether there are cells at places."""
    return all(np.hypot(*(cells.centres - place).T).min() < 1e-6 for place in places)


def lengths(cells: Placed) -> list[float]:
    return [math.dist(cells.centres[one], cells.centres[other]) for one, other in cells.names]


def test_ends_crossings_and_corners_get_cells() -> None:
    cells = placed(*SITE)
    assert has(cells, (1, 6), (19, 6), (6, 6), (3, 6), (3, 10), (6, 10))
    assert has(cells, (14, 10), (14, 11.5), (10, 6), (16, 2), (19, 2))


@given(st.floats(0.3, 1.0))
def test_moves_are_at_least_a_spacing_long_and_less_than_two_beside_junctions_at_right_angles(spacing: float) -> None:
    cells = placed(line((1, 6), (19, 6)), line((7, 1), (7, 11)), line((12, 6), (12, 2), (19, 2)), spacing=spacing)
    assert min(lengths(cells)) >= spacing - 1e-6
    assert max(lengths(cells)) < 2.0 * spacing + 1e-6


def test_a_straight_lane_has_as_many_cells_as_there_is_room_for() -> None:
    assert len(placed(line((0, 0), (6, 0))).centres) == 11
    assert len(placed(line((0, 0), (5.99, 0))).centres) == 10
    assert len(placed(line((0, 0), (0.6, 0))).centres) == 2


def test_cells_on_a_ring_are_all_around_it() -> None:
    cells = placed(ring(5, 5, 2))
    angles = np.sort(np.arctan2(*(cells.centres - 5.0).T))
    assert len(cells.centres) == 20
    assert np.diff(angles).max() < 2.2 * math.pi / 20


@pytest.mark.parametrize("angle", [20.0, 45.0, 60.0, 75.0, 90.0, 135.0])
def test_cells_beside_a_junction_are_as_far_from_the_other_lane_as_from_each_other(angle: float) -> None:
    direction = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    end = 10.0 + 8.0 * direction[0], 8.0 * direction[1]
    cells = placed(line((0, 0), (20, 0)), line((10, 0), end))
    beside = cells.centres[cells.centres[:, 1] > 1e-6]
    assert beside[:, 1].min() >= 0.6 - 1e-6


def test_a_one_way_lane_leads_one_way() -> None:
    cells = placed(line((0, 0), (3, 0), one_way=True))
    assert all(cells.centres[one, 0] < cells.centres[other, 0] for one, other in cells.names)


def test_corners_that_are_near_to_each_other_are_cut() -> None:
    cells = placed(line((0, 0), (3, 0), (3.2, 0.2), (3.2, 3)))
    assert min(lengths(cells)) >= 0.6 - 1e-6
    assert has(cells, (0, 0), (3.2, 3))


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([line((0, 0), (0.5, 0), name="stub")], "lane 'stub' is too short between 0.00, 0.00 and 0.50, 0.00"),
        ([line((0, 0), (9, 0), name="m"), line((4, 0), (4, 3)), line((4.5, 0), (4.5, -3))], "lane 'm' is too short"),
        ([line((0, 0), (0.06, 0.06), name="dot"), line((0, 0), (3, 0))], "lane 'dot' is shorter than 0.1 m"),
        ([line((-9000, 0), (9000, 0), name="far")], "the lanes are 18000 m long: at 0.60 m they would have more than"),
        ([ring(5, 5, 0.2)], "lane 'ring' is a ring at 5.20, 5.00 that is 1.2"),
        ([line((-9, 0), (9, 0)), line((0, 0), (9, 1), name="s")], "meets another one at 0.00, 0.00 at 6°"),
        (
            [line((0, 0), (4, 0)), *(line((2, 0), end) for end in ((1, 3), (3, 3), (2, -3)))],
            "5 lanes meet at 2.00, 0.00, and at most 4 may",
        ),
    ],
)
def test_what_has_no_room_is_told_with_its_place(lines: list[DrawnLane], message: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        placed(*lines)
    assert message in str(caught.value)


def test_the_sharpest_angle_is_allowed() -> None:
    end = 12.0 * math.cos(SHARPEST + 0.01), 12.0 * math.sin(SHARPEST + 0.01)
    assert placed(line((0, 0), (12, 0)), line((0, 0), end)).names


def test_each_part_is_in_one_chain() -> None:
    network = network_of(SITE)
    parts = [frozenset(part) for chain in chains_of(network) for part in pairwise(chain.places)]
    assert len(parts) == len(set(parts))
    assert set(parts) == {frozenset(part) for part in network.names}


def test_chains_end_at_ends_and_junctions_only() -> None:
    network = network_of(SITE)
    near = network.near()
    for chain in chains_of(network):
        assert all(len(near[place]) == 2 for place in chain.places[1:-1])
        assert all(len(near[place]) != 2 for place in (chain.places[0], chain.places[-1]))


def test_a_ring_is_one_chain() -> None:
    (chain,) = chains_of(network_of([ring(5, 5, 2)]))
    assert chain.places[0] == chain.places[-1]
    assert (chain.forth, chain.back) == (True, True)


def test_a_chain_ends_where_a_lane_becomes_one_way() -> None:
    network = network_of([line((0, 0), (3, 0)), line((3, 0), (6, 0), name="on", one_way=True)])
    found = {(chain.name, chain.forth, chain.back) for chain in chains_of(network)}
    assert ("(0, 0)", True, True) in found
    assert found - {("(0, 0)", True, True)} in ({("on", True, False)}, {("on", False, True)})
