from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.zones.reading import geojson_of
from ppaas.zones.zone import ZoneSet
from robots.pictures.building_run import RobotRun, RunFloor, draw_run, write_run
from tests.support.world.rooms import room

FLOORS = [
    RunFloor(name, height, room(6.0, 4.0), geojson_of(ZoneSet([]))) for name, height in (("L1", 0.0), ("L2", 3.0))
]
ROBOTS = [
    RobotRun("tb1", [(0.0, 0.0), (5.0, 0.0), (9.0, 3.0)], {"L1": [[(1.0, 1.0), (3.0, 1.0)]], "L2": [[(3.0, 3.0)]]}),
    RobotRun("tb2", [(0.0, 3.0), (9.0, 3.0)], {"L2": [[(1.0, 3.0), (5.0, 3.0)]]}),
]
CARS = {"A": [(0.0, 0.0), (9.0, 3.0)]}


def test_each_floor_has_the_ways_that_were_driven_on_it_and_the_timeline_all_robots_and_lifts() -> None:
    first, second, times = draw_run(FLOORS, ROBOTS, CARS).axes
    assert [axes.get_title(loc="left") for axes in (first, second)] == ["L1", "L2"]
    assert [len(axes.lines) for axes in (first, second)] == [2, 4], "a way and its end each"
    assert [line.get_label() for line in times.lines] == ["lift A", "tb1", "tb2"]
    assert [label.get_text() for label in times.get_yticklabels()] == ["L1", "L2"]
    x, y = first.lines[0].get_xdata(), first.lines[0].get_ydata()
    assert np.ptp(x) > 0 and np.ptp(y) == 0, "it has driven along x"


def test_the_picture_is_a_png_file(tmp_path: Path) -> None:
    write_run(tmp_path / "run.png", FLOORS, ROBOTS, CARS)
    assert Image.open(tmp_path / "run.png").size[0] == pytest.approx(840, abs=2)
    with pytest.raises(InvalidInput, match="PNG"):
        write_run(tmp_path / "run.svg", FLOORS, ROBOTS, CARS)
