import numpy as np
import pytest

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import KeepOutZones, grid_around, grid_of, report_cells
from ppaas.imports.report import ImportOutcome, ImportReport
from ppaas.maps.grid import GridInfo
from ppaas.zones.zone import MOST_ZONES

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]


def test_grids_of_overlapping_files_have_the_same_cells():
    one = grid_around(np.array((0.13, -0.01)), np.array((2.0, 3.0)), 0.05)
    assert one.origin == Pose2D(0.1, -0.05, 0.0)
    assert (one.width, one.height) == (38, 61)
    assert one.shift_to(grid_around(np.array((-7.02, 0.4)), np.array((2.0, 3.0)), 0.05)) is not None
    with pytest.raises(InvalidMap, match="--resolution"):
        grid_around(np.array((0.0, 0.0)), np.array((1e5, 1e5)), 0.05)


def test_zones_have_names_of_their_own():
    report = ImportReport("a")
    zones = KeepOutZones(report)
    for name in ("bed", "bed", " ", "x" * 100):
        zones.add("part", name, SQUARE)
    assert [zone.name for zone in zones.zones().zones] == ["bed", "bed 2", "keep out", "x" * 60]
    zones.add("line", "line", SQUARE[:2])
    assert report.entries[-1].outcome is ImportOutcome.REFUSED


def test_no_more_zones_than_a_map_may_have():
    report = ImportReport("a")
    zones = KeepOutZones(report)
    for _ in range(MOST_ZONES + 1):
        zones.add("part", "bed", SQUARE)
    assert len(zones.zones().zones) == MOST_ZONES
    assert [entry.outcome for entry in report.entries].count(ImportOutcome.REFUSED) == 1


def test_a_map_without_free_cells_is_refused():
    nothing = np.zeros((2, 3), np.bool_)
    with pytest.raises(InvalidMap, match="no cell"):
        report_cells(ImportReport("a"), grid_of(GridInfo(1.0, 3, 2), nothing, ~nothing))
