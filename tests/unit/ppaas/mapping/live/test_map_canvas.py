"""Map canvas: drawing key frames one by one gives the map of all key frames."""

import numpy as np
import pytest

from ppaas.errors import QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.key_frames import KeyFrames
from ppaas.mapping.live import map_canvas
from ppaas.mapping.live.map_canvas import BLOCK, MapCanvas
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import prepare
from ppaas.maps.cell_rectangle import Rectangle
from ppaas.maps.grid import UNKNOWN
from tests.support.world.ring_drive import ring_drive


@pytest.fixture(scope="module")
def frames() -> KeyFrames:
    """Return key frames of a ring of corridors, at the poses of the odometry."""
    log = ring_drive().log
    made = KeyFrames(log.geometry)
    for scan in range(0, 300, 10):
        points = prepare(log.ranges[scan], log.geometry, SlamParameters())
        made.add(points, scan, Pose2D(*log.odometry[scan].tolist()), np.zeros(6))
    return made


def first(frames: KeyFrames, count: int) -> KeyFrames:
    taken = frames.snapshot()
    taken._count = count
    return taken


def known(canvas: MapCanvas, frames: KeyFrames) -> np.ndarray:
    """Return the part of a canvas that the whole map covers."""
    info, own = draw_map(frames, frames.poses).info, canvas.info
    row = round((info.origin.y - own.origin.y) / own.resolution)
    column = round((info.origin.x - own.origin.x) / own.resolution)
    part = canvas.cells[row : row + info.height, column : column + info.width]
    assert (canvas.cells != UNKNOWN).sum() == (part != UNKNOWN).sum()
    return part


def test_frames_drawn_one_by_one_give_the_whole_map(frames):
    canvas = MapCanvas()
    for count in range(1, len(frames) + 1):
        canvas.draw(first(frames, count), count - 1)
        assert not any(size % BLOCK for size in canvas.cells.shape)
    np.testing.assert_array_equal(known(canvas, frames), draw_map(frames, frames.poses).data)


def test_only_touched_cells_change(frames):
    canvas = MapCanvas()
    canvas.draw(first(frames, 20), 0)
    canvas.take_touched()
    assert canvas.take_touched() is None
    before = canvas.cells.copy()
    canvas.draw(first(frames, 21), 20)
    touched = canvas.take_touched()
    assert np.prod(touched.shape) < before.size
    outside = canvas.cells.copy()
    outside[touched.slices] = before[touched.slices]
    assert (outside == before).all()
    assert (canvas.cells != before).any()


def test_an_extent_is_kept(frames):
    canvas = MapCanvas()
    canvas.draw(frames, 0)
    again = MapCanvas(extent=canvas.extent)
    assert (again.cells == UNKNOWN).all()
    again.draw(first(frames, 3), 0)
    assert again.info == canvas.info


def test_drawing_nothing_changes_nothing(frames):
    canvas = MapCanvas()
    canvas.draw(frames, len(frames))
    assert (canvas.extent, canvas.take_touched()) == (None, None)


def test_a_map_that_is_too_large_is_left_as_it_is(frames, monkeypatch):
    canvas = MapCanvas()
    canvas.draw(first(frames, 1), 0)
    extent, cells = canvas.extent, canvas.cells.copy()
    monkeypatch.setattr(map_canvas, "MOST_CELLS", cells.size)
    far = first(frames, 2)
    far.poses[1] += (100.0, 0.0, 0.0)
    with pytest.raises(QuotaExceeded, match="max_laser_range"):
        canvas.draw(far, 1)
    assert canvas.extent == extent
    np.testing.assert_array_equal(canvas.cells, cells)


def test_rectangles_are_joined_and_moved():
    both = Rectangle(1, 2, 3, 4).around(Rectangle(-2, 3, 2, 9))
    assert both == (-2, 2, 3, 9)
    assert both.moved(2, -2) == (0, 0, 5, 7)
    assert both.shape == (5, 7)
