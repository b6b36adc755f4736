"""Changes of a map, found by a robot that goes round a room in which a box was moved and people walk."""

from functools import cache

import numpy as np
import pytest

from benchmarks.mapping.simulated_drive import SimulatedDrive
from benchmarks.mapping.small_worlds import AFTER, BEFORE, changing_drive, room
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.lifelong import changes as changes_module
from ppaas.mapping.lifelong.changed_places import KnownChanges
from ppaas.mapping.lifelong.changes import LaterFrames, confirmed_changes, later_frames
from ppaas.mapping.lifelong.parameters import LifelongParameters
from ppaas.mapping.lifelong.thinning import kept_frames
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.map_drawing import draw_map
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import ScanPoints, prepare
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap

PEOPLE = ((0.5, 4.0, 0.8, 4.3), (5.0, 2.2, 5.3, 2.5), (2.8, 4.2, 3.1, 4.5), (2.5, 0.5, 2.8, 0.8))
LAPS = [room(BEFORE)] * 2 + [room(AFTER, person) for person in PEOPLE]
NOTHING = KnownChanges()


@cache
def drive() -> SimulatedDrive:
    return changing_drive(LAPS, beams=60)


@pytest.fixture(scope="module")
def mapped():
    """Return the mapping after each lap, with its grid."""
    mapper, parameters, found = LiveMapper(drive().log.geometry, lifelong=LifelongParameters()), SlamParameters(), []
    for scan, odometry in enumerate(drive().log.odometry.tolist()):
        mapper.add(prepare(drive().log.ranges[scan], drive().log.geometry, parameters), Pose2D(*odometry))
        while (work := mapper.next_work()) is not None:
            mapper.apply(work(lambda: False))
        if scan + 1 == len(drive().log) * (len(found) + 1) // len(LAPS):
            mapping = mapper.mapping("laser")
            found.append((mapping, draw_map(mapping.frames, mapping.frames.poses)))
    return found


def changes(mapped, lap: int, known: KnownChanges = NOTHING):
    (base, before), (mapping, now) = mapped[1], mapped[lap]
    later = later_frames(mapping.frames, base.frames)
    return confirmed_changes(before, now, later, 6.0, known)


def assert_is_box(place, box):
    assert place.x + drive().true[0, 0] == pytest.approx((box[0] + box[2]) / 2.0, abs=0.25)
    assert place.y + drive().true[0, 1] == pytest.approx((box[1] + box[3]) / 2.0, abs=0.25)
    assert 0.3 < max(place.width, place.height) < 0.9


def test_a_box_that_was_moved_is_gone_at_one_place_and_new_at_the_other(mapped):
    found = changes(mapped, 5)
    assert len(found.left) == len(found.new) == 1
    assert_is_box(found.left[0], BEFORE)
    assert_is_box(found.new[0], AFTER)


def test_one_pass_and_people_are_not_changes(mapped):
    found = changes(mapped, 2)
    assert (found.left, found.new) == ([], [])


def test_the_map_with_the_changes_differs_at_no_other_place(mapped):
    before, found = mapped[1][1], changes(mapped, 5)
    shift = before.info.shift_to(found.grid.info)
    part = found.grid.data[shift[0] : shift[0] + before.info.height, shift[1] : shift[1] + before.info.width]
    differs = (part != before.data) & (before.data != UNKNOWN)
    assert differs.sum() == sum(place.cells for place in (*found.left, *found.new))
    assert set(np.unique(part[differs])) == {FREE, OCCUPIED}


def test_known_changes_are_left_out(mapped):
    found = changes(mapped, 5)
    x, y = found.left[0].x, found.left[0].y
    rest = changes(mapped, 5, KnownChanges([(x + 0.4, y - 0.4)], [(x, y)]))
    assert (rest.left, rest.new) == ([], found.new)
    assert (rest.grid.data != found.grid.data).sum() == found.left[0].cells


def test_the_largest_changes_are_found_first(mapped, monkeypatch):
    (base, before), (mapping, now) = mapped[1], mapped[5]
    assert before.info == now.info
    columns = (np.indices(before.data.shape) % 20 < 4).all(axis=0)
    cells = np.where((before.data == FREE) & (now.data == FREE) & columns, np.int8(OCCUPIED), before.data)
    crowded = GridMap(cells, before.info)
    later = later_frames(mapping.frames, base.frames)
    every = confirmed_changes(crowded, now, later, 6.0).left
    monkeypatch.setattr(changes_module, "MOST_PLACES", 3)
    found = confirmed_changes(crowded, now, later, 6.0)
    assert len(every) > 10 and found.left == every[:3]
    assert ((found.grid.data == FREE) & (cells == OCCUPIED)).sum() == sum(place.cells for place in every[:3])


def test_a_robot_that_does_not_continue_the_map_is_refused(mapped):
    base = mapped[1][0].frames
    moved, other = base.snapshot(), base.snapshot()
    moved.poses[:, 0] += 0.5
    with pytest.raises(InvalidInput, match="at other places"):
        later_frames(moved, base)
    other._arrays = other._arrays._replace(points=other.points[::-1])
    with pytest.raises(InvalidInput, match="its first key frame is another one"):
        later_frames(other, base)


def test_a_map_whose_scans_have_other_numbers_is_refused(mapped):
    base, every = mapped[1][0].frames, np.ones(len(mapped[1][0].frames), np.bool_)
    renumbered = kept_frames(base, ScanPoints(base.points, base.normals, base.valid), every)
    renumbered.scans[:] += 100_000
    with pytest.raises(InvalidInput, match="has no key frame in common with it"):
        later_frames(renumbered, base)


def test_scans_of_two_robots_have_equal_numbers(mapped):
    (base, _), (one, _), (other, _) = mapped[1], mapped[2], mapped[5]
    kept = np.isin(other.frames.scans, base.frames.scans) | (other.frames.scans >= one.frames.scans[-1])
    frames = kept_frames(other.frames, ScanPoints(other.frames.points, other.frames.normals, other.frames.valid), kept)
    own = ~np.isin(frames.scans, base.frames.scans)
    frames.scans[own] = base.frames.scans[-1] + 1 + np.arange(own.sum())
    np.testing.assert_array_equal(later_frames(frames, one.frames).indices, np.flatnonzero(own))


def test_grids_whose_cells_do_not_coincide_are_refused(mapped):
    mapping, now = mapped[1]
    info = now.info
    shifted = GridMap(now.data, GridInfo(info.resolution, info.width, info.height, Pose2D(0.013, 0.0)))
    with pytest.raises(InvalidInput, match="do not coincide"):
        confirmed_changes(shifted, now, LaterFrames(mapping.frames, np.arange(0)), 6.0)
