"""MovingAI's maps and scenarios, from small ones by hand to the real ones."""

from pathlib import Path

import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.maps.formats.movingai import parse_map, parse_scenario
from ppaas.maps.grid import FREE, OCCUPIED

MAP = b"type octile\nheight 2\nwidth 5\nmap\n.G@S.\nTWO..\n"
SCENARIO = b"version 1\n0\tm.map\t5\t2\t0\t0\t4\t1\t4.41421356\n1\tm.map\t5\t2\t3\t1\t4\t0\t1.5\n"


def test_ground_and_swamp_are_free_and_all_others_occupied() -> None:
    grid = parse_map(MAP)
    free = [[True, True, False, True, True], [False, False, False, True, True]]
    assert grid.data.tolist() == np.where(free, FREE, OCCUPIED).tolist()
    assert (grid.info.resolution, grid.info.width, grid.info.height) == (1.0, 5, 2)


def test_windows_line_ends_are_accepted() -> None:
    assert parse_map(MAP.replace(b"\n", b"\r\n")).data.tolist() == parse_map(MAP).data.tolist()


def test_queries_are_converted_from_x_y_to_row_column() -> None:
    scenario = parse_scenario(SCENARIO)
    assert scenario.starts.tolist() == [[0, 0], [1, 3]]
    assert scenario.goals.tolist() == [[1, 4], [0, 4]]
    assert scenario.optima.tolist() == [4.41421356, 1.5]
    assert len(scenario.first(1)) == 1
    assert len(scenario.first(None)) == len(scenario) == 2


def test_spread_takes_queries_evenly_from_the_scenario() -> None:
    long = parse_scenario(b"version 1\n" + b"".join(b"0 m 5 2 0 0 4 1 %d\n" % number for number in range(10)))
    assert long.spread(4).optima.tolist() == [0.0, 3.0, 6.0, 9.0]
    assert long.spread(1).optima.tolist() == [0.0]
    assert long.spread(99).optima.tolist() == long.optima.tolist()
    assert len(long.first(0).spread(3)) == 0


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (b"", "must begin with"),
        (MAP.replace(b"octile", b"tile"), "must begin with"),
        (MAP.replace(b"height 2", b"height -2"), "height"),
        (MAP.replace(b"width 5", b"width 5e3"), "width"),
        (MAP.replace(b"height 2", b"height 9"), "9 rows"),
        (MAP.replace(b".G@S.", b".G@S"), "row 0"),
    ],
)
def test_an_invalid_map_is_refused(text: bytes, reason: str) -> None:
    with pytest.raises(InvalidMap, match=reason):
        parse_map(text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (b"", "version"),
        (b"0\tm.map\t5\t2\t0\t0\t4\t1\t4.4\n", "version"),
        (SCENARIO.replace(b"\t4.41421356", b""), "line 2"),
        (SCENARIO.replace(b"1.5", b"far"), "line 3"),
        (SCENARIO.replace(b"3\t1", b"3.5\t1"), "line 3"),
    ],
)
def test_an_invalid_scenario_is_refused(text: bytes, reason: str) -> None:
    with pytest.raises(InvalidMap, match=reason):
        parse_scenario(text)


def test_all_real_queries_begin_and_end_on_free_cells(data: Path) -> None:
    files = sorted((data / "movingai").rglob("*.scen"))
    assert files
    for file in files:
        grid = parse_map(file.with_suffix("").read_bytes())
        scenario = parse_scenario(file.read_bytes())
        for cells in (scenario.starts, scenario.goals):
            assert (grid.data[cells[:, 0], cells[:, 1]] == FREE).all(), file.name
