"""Doors that count as walls."""

import numpy as np
import pytest

from ppaas.buildings.planning.doors import door_lines, with_doors_shut
from ppaas.planners.batch.path_lengths import PathLengths
from ppaas.zones.zone import ZoneSet
from tests.unit.ppaas.buildings.planning.random_buildings import costmap, door, lift


@pytest.mark.parametrize("angle", np.linspace(0.0, np.pi, 13))
def test_no_path_slips_through_a_shut_door(angle: float) -> None:
    across = 20.0 * np.array((np.cos(angle), np.sin(angle)))
    middle, side = np.array((3.0, 3.0)), 1.5 * np.array((-np.sin(angle), np.cos(angle)))
    line = tuple((middle - across).tolist()), tuple((middle + across).tolist())
    found = PathLengths(with_doors_shut(costmap(np.ones((24, 24), np.bool_)), [line]))  # type: ignore[list-item]
    cells = [found.cell(*(middle + way).tolist()) for way in (side, -side)]
    assert found.between(cells[:1], cells[1:])[0, 0] == np.inf


def test_a_map_without_doors_is_unchanged() -> None:
    plain = costmap(np.ones((24, 24), np.bool_))
    assert with_doors_shut(plain, []) is plain


def test_the_doors_of_lifts_and_rooms_are_found() -> None:
    zones = ZoneSet([*lift("north", 1.0, 1.0), door("hall", 3.0, 4.0)])
    assert door_lines(zones) == [((1.0, 2.1), (2.0, 2.1)), ((3.0, 4.0), (4.0, 4.0))]
