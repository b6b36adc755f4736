"""Robots that go on with a joint map: nothing that they have mapped is lost, and they stay where they are."""

from typing import NamedTuple

import numpy as np
import pytest

from ppaas.errors import Conflict, InvalidGraph, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.live.joint_mapper import JointMapper, odometry_chains
from ppaas.mapping.merging.joint_map import join_maps
from ppaas.mapping.merging.united import frame_ids
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping_file import pack_mapping, unpack_mapping
from ppaas.mapping.serialization.rows import divided_edges
from tests.support.world.joint_maps import joint_map
from tests.support.world.merge_drives import first_drive, second_drive

BEGIN, MERGED, END = 100, 115, 200
"""Numbers of scans when a merge begins, when it is adopted, and at the end."""


class Story(NamedTuple):
    robots: tuple
    file: bytes
    before: list
    adoptions: list
    after: list
    apart: list


def never():
    return False


class Robot:
    """Robot that maps a simulated drive scan by scan."""

    def __init__(self, drive, parameters=SlamParameters()):  # noqa: B008
        self.drive, self.parameters = drive, parameters
        self.mapper = JointMapper(drive.log.geometry, parameters)
        self.next = 0

    def until(self, number):
        log = self.drive.log
        for scan in range(self.next, number):
            points = prepare(log.ranges[scan], log.geometry, self.parameters, np.zeros(3))
            self.tracked = self.mapper.add(points, Pose2D(*log.odometry[scan].tolist()))
            while (work := self.mapper.next_work()) is not None:
                self.mapper.apply(work(never))
        self.next = max(self.next, number)
        return self

    def mapping(self):
        return unpack_mapping(b"".join(pack_mapping(self.mapper.mapping("laser"))))

    def adopt(self, file, most=10_000):
        work = self.mapper.adoption(file, "laser", most)
        return self.mapper.adopt(work(never))

    def true_pose(self, of=None):
        """Return the true pose of the laser at the last scan, or at that of a key frame."""
        return Pose2D(*self.drive.true[self.next - 1 if of is None else of].tolist()) @ self.drive.log.geometry.mount


def file_of(*groups):
    return b"".join(pack_mapping(join_maps(groups).mapping))


@pytest.fixture(scope="module")
def story():
    """Two robots that merge their maps, go on, and exchange what they mapped since."""
    robots = Robot(first_drive()).until(BEGIN), Robot(second_drive()).until(BEGIN)
    file = b"".join(pack_mapping(joint_map(*((robot.drive, robot.mapping()) for robot in robots))))
    for robot in robots:
        robot.until(MERGED)
    before = [(robot.mapping(), robot.mapper.pose) for robot in robots]
    adoptions = [robot.adopt(file) for robot in robots]
    after = [(robot.mapping(), robot.mapper.pose) for robot in robots]
    for robot in robots:
        robot.until(END)
    apart = [robot.mapping() for robot in robots]
    last = file_of(apart)
    for robot in robots:
        robot.adopt(last)
    return Story(robots, file, before, adoptions, after, apart)


def test_robot_keeps_what_it_mapped_during_the_merge(story):
    joint = set(frame_ids(unpack_mapping(story.file)))
    for (own, _), (mapping, _) in zip(story.before, story.after, strict=True):
        ids = frame_ids(mapping)
        assert len(ids) == len(set(ids))
        assert set(ids) == joint | set(frame_ids(own))
        assert len(set(frame_ids(own)) - joint) >= 3


def test_pose_of_the_robot_moves_with_its_last_key_frame(story):
    for (own, pose), (mapping, moved), adoption in zip(story.before, story.after, story.adoptions, strict=True):
        np.testing.assert_allclose(moved, adoption.motion @ pose, atol=1e-9)
        at = [Pose2D(*each.frames.poses[-1].tolist()) for each in (own, mapping)]
        np.testing.assert_allclose(at[1].inverse() @ moved, at[0].inverse() @ pose, atol=1e-9)


def test_frame_of_the_first_robot_stays_where_it_is(story):
    first = story.before[0][0].frames.poses[0]
    for mapping, _ in story.after:
        np.testing.assert_array_equal(mapping.frames.poses[0], first)
    assert story.adoptions[0].motion.distance_to(Pose2D(0.0, 0.0)) < 0.1


def test_own_key_frames_stay_one_chain_at_the_end(story):
    for (own, _), (mapping, _) in zip(story.before, story.after, strict=True):
        steps = divided_edges(mapping.graph)[0][-(len(own.frames) - 1) :]
        assert (steps[1:] >= 0).all()
        assert frame_ids(mapping)[-1] == frame_ids(own)[-1]


def test_scans_have_other_numbers_and_the_old_ones_are_known(story):
    for (own, _), (mapping, _), adoption in zip(story.before, story.after, story.adoptions, strict=True):
        np.testing.assert_array_equal(adoption.before, own.frames.scans)
        of = dict(zip(mapping.frames.scans.tolist(), frame_ids(mapping), strict=True))
        assert [of[number] for number in adoption.after.tolist()] == frame_ids(own)
        assert (np.diff(adoption.after) > 0).all() or adoption.after[0] == 0


def test_robots_go_on_in_one_frame(story):
    first, second = story.robots
    frame = first.mapper.pose @ first.true_pose().inverse()
    off = (frame @ second.true_pose()).inverse() @ second.mapper.pose
    assert max(abs(off.x), abs(off.y)) < 0.1
    assert abs(off.theta) < 0.03


def test_both_robots_have_all_key_frames_after_the_exchange(story):
    ids = [set(frame_ids(robot.mapper.mapping("laser"))) for robot in story.robots]
    assert ids[0] == ids[1] == {each for mapping in story.apart for each in frame_ids(mapping)}


def test_map_is_drawn_of_all_key_frames(story):
    first, second = (robot.mapper.draw().cells for robot in story.robots)
    known = [(cells >= 0).sum() for cells in (first, second)]
    assert known[0] == pytest.approx(known[1], rel=0.01)


def test_no_other_work_begins_during_an_adoption():
    robot = Robot(first_drive()).until(40)
    assert robot.mapper.adoption(b"", "laser", 10) is not None
    assert robot.mapper.next_work() is None
    assert robot.mapper.adopt(None) is None


def test_adoption_waits_for_the_work_that_is_running():
    robot = Robot(first_drive())
    while robot.mapper.next_work() is None or not robot.next:
        points = prepare(robot.drive.log.ranges[robot.next], robot.drive.log.geometry, robot.parameters, np.zeros(3))
        robot.mapper.add(points, Pose2D(*robot.drive.log.odometry[robot.next].tolist()))
        robot.next += 1
    assert robot.mapper.adoption(b"", "laser", 10) is None
    robot.mapper.apply(None)
    assert robot.mapper.next_work() is None
    assert robot.mapper.adoption(b"", "laser", 10) is not None


def test_map_that_is_not_the_robots_is_refused(story):
    other = Robot(first_drive()).until(20)
    with pytest.raises(InvalidGraph):
        other.adopt(story.file[:-5])
    mapping = story.before[1][0]
    with pytest.raises(Conflict, match="no scan of this robot's map"):
        other.adopt(b"".join(pack_mapping(mapping)))
    with pytest.raises(QuotaExceeded, match="raise max_key_frames"):
        story.robots[0].adopt(story.file, most=100)


def test_chains_begin_where_odometry_does_not_lead_on(story):
    graph = story.after[0][0].graph
    chains = odometry_chains(graph)
    assert len(set(chains.tolist())) == 2
    assert chains[0] == 0
    assert (chains <= np.arange(graph.node_count)).all()
