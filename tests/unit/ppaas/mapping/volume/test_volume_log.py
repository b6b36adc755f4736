"""Logs of 3D maps."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.errors import InvalidMap, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.volume.key_frame_poses import NO_KEY_FRAMES, KeyFramePoses
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.mapping.volume.submap_volume import SubmapVolume
from ppaas.mapping.volume.volume_log import VolumeLogWriter, read_log
from tests.unit.ppaas.mapping.volume.test_submap_volume import DRIFTED, PARAMETERS, STOPS, TRUE, driven, scan


@dataclass
class Stored:
    """Log that is stored, with its writer."""

    writer: VolumeLogWriter = field(default_factory=VolumeLogWriter)
    entries: dict[int, bytes] = field(default_factory=dict)

    def save(self, map_, key_frames=NO_KEY_FRAMES):
        """Store the change, and return the number of entries that were added."""
        change = self.writer.write(map_, key_frames)
        if change is None:
            return 0
        assert not self.entries.keys() & dict(change.entries).keys()
        self.entries |= dict(change.entries)
        for number in change.obsolete:
            del self.entries[number]
        return len(change.entries)

    @property
    def list(self):
        return [LogEntry(*entry) for entry in sorted(self.entries.items())]

    def read(self, parameters=PARAMETERS):
        """Return the map of the log, its key frames, and the log as its next writer continues it."""
        map_ = SubmapVolume(parameters)
        key_frames = read_log(self.list, map_)
        again = Stored(entries=dict(self.entries))
        again.writer.take_over(self.list, map_)
        return map_, key_frames, again


def assert_same(found, map_):
    """Compare two maps. Volumes that are put together from submaps differ by rounding."""
    for one, other in [
        (found.volume.blocks, map_.volume.blocks),
        *((one.blocks, other.blocks) for one, other in zip(found.submaps, map_.submaps, strict=True)),
    ]:
        first, second = np.argsort(one.codes), np.argsort(other.codes)
        np.testing.assert_array_equal(one.codes[first], other.codes[second])
        np.testing.assert_allclose(one.log_odds[first], other.log_odds[second], atol=1e-6)


def insert(map_, x, anchor=None):
    place = np.array([x, 0.0, 0.5])
    map_.insert(scan(place).astype(np.float32), place, anchor)


def test_a_map_is_read_as_it_was_written():
    map_, stored = driven(DRIFTED), Stored()
    map_.correct(DRIFTED, TRUE)
    stored.save(map_, TRUE)
    found, key_frames, again = stored.read()
    assert_same(found, map_)
    assert [(one.number, one.stamp, one.motion) for one in found.submaps] == [
        (one.number, one.stamp, one.motion) for one in map_.submaps
    ]
    assert key_frames.stamps.tolist() == [one.stamp for one in map_.submaps]
    assert key_frames.poses.tolist() == [list(TRUE.anchor(stamp).pose) for stamp in key_frames.stamps]
    assert again.save(found, TRUE) == 0
    assert sum(map(len, stored.entries.values())) < 0.2 * sum(one.blocks.log_odds.nbytes for one in map_.submaps)


def test_both_maps_move_alike_from_then_on():
    map_, stored = driven(DRIFTED), Stored()
    stored.save(map_, DRIFTED)
    found, key_frames, again = stored.read()
    for one, before in ((map_, DRIFTED), (found, key_frames)):
        one.correct(before, TRUE)
        insert(one, 5.0, TRUE.anchor(6.0))
    assert_same(found, map_)
    again.save(found, TRUE)
    assert_same(again.read()[0], map_)


def test_only_pages_that_changed_are_written_again():
    map_, stored = SubmapVolume(PARAMETERS), Stored()
    counts = []
    for index, x in enumerate(STOPS):
        insert(map_, x, TRUE.anchor(float(index)))
        counts.append(stored.save(map_, TRUE))
    pages = sum(submap.blocks.pages for submap in map_.submaps)
    assert len(stored.entries) == pages + 1
    assert counts[-1] < 0.5 * pages
    assert stored.save(map_, TRUE) == 0
    map_.clear_box((0.0, -1.0, 0.0), (0.5, 1.0, 1.0))
    stored.save(map_, TRUE)
    assert_same(stored.read()[0], map_)


def test_submaps_that_are_joined_and_a_map_that_no_longer_moves_are_kept():
    for most in (1000, 700, 500):
        parameters = VolumeParameters(resolution=0.1, max_range=6.0, max_blocks=most)
        map_, stored = SubmapVolume(parameters), Stored()
        try:
            for index, x in enumerate(STOPS):
                insert(map_, x, DRIFTED.anchor(float(index)))
                stored.save(map_, DRIFTED)
        except QuotaExceeded:
            assert map_.fixed
        found, _, again = stored.read(parameters)
        assert (found.joined, found.fixed) == (map_.joined, map_.fixed)
        assert_same(found, map_)
        assert again.save(found, DRIFTED) == 0
    assert map_.fixed


def test_a_map_without_key_frames_is_kept_and_then_hangs_on_the_first_one():
    map_, stored = SubmapVolume(PARAMETERS), Stored()
    insert(map_, 0.0)
    stored.save(map_)
    found, key_frames, again = stored.read()
    assert_same(found, map_)
    assert not len(key_frames)
    insert(found, 2.0, TRUE.anchor(1.0))
    again.save(found, TRUE)
    moved, key_frames, _ = again.read()
    assert len(moved.submaps) == 1
    motion = KeyFramePoses(TRUE.stamps, TRUE.poses + np.array((0.0, 1.0, 0.0)))
    assert moved.correct(key_frames, motion)
    assert moved.submaps[0].motion == Pose2D(0.0, 1.0, 0.0)


def test_a_cleared_map_has_no_log():
    map_, stored = driven(TRUE), Stored()
    assert stored.save(SubmapVolume(PARAMETERS)) == 0
    stored.save(map_, TRUE)
    map_.clear()
    stored.save(map_)
    assert stored.entries == {}
    insert(map_, 2.0)
    stored.save(map_)
    assert_same(stored.read()[0], map_)


def test_entries_that_a_removal_left_behind_do_no_harm():
    map_, stored = SubmapVolume(PARAMETERS), Stored()
    insert(map_, 0.0, TRUE.anchor(0.0))
    stored.save(map_, TRUE)
    left = dict(stored.entries)
    insert(map_, 1.0, TRUE.anchor(0.0))
    stored.save(map_, TRUE)
    stored.entries |= left
    found, _, again = stored.read()
    assert_same(found, map_)
    insert(found, 1.0, TRUE.anchor(0.0))
    again.save(found, TRUE)
    assert not left.keys() & again.entries.keys()


@pytest.mark.parametrize(
    "damage",
    [
        lambda entries: entries.update({min(entries): entries[min(entries)][:-1] + b"?"}),
        lambda entries: entries.update({min(entries): b"\0\0"}),
        lambda entries: entries.pop(min(entries)),
        lambda entries: entries.pop(max(entries)),
        lambda entries: entries.update({max(entries): b"{}"}),
    ],
)
def test_a_damaged_log_is_refused_and_its_entries_are_removed(damage):
    stored = Stored()
    stored.save(driven(TRUE), TRUE)
    damage(stored.entries)
    map_ = SubmapVolume(PARAMETERS)
    with pytest.raises(InvalidMap, match=r"map the place again|damaged"):
        read_log(stored.list, map_)
    again = Stored(entries=dict(stored.entries))
    again.writer.take_over(stored.list, None)
    insert(map_, 0.0)
    again.save(map_)
    assert_same(again.read()[0], map_)


def test_a_map_of_another_resolution_is_refused():
    stored = Stored()
    stored.save(driven(TRUE), TRUE)
    with pytest.raises(InvalidMap, match=r"voxels of 0\.1 m, not 0\.2"):
        read_log(stored.list, SubmapVolume(VolumeParameters(resolution=0.2)))
