"""What goes wrong on a drive: the map stays right, or at least no place is taken for another; offline and live."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.mapping.map_errors import absolute_errors
from benchmarks.mapping.simulated_drive import SimulatedDrive, simulate
from benchmarks.mapping.small_worlds import ring_drive
from ppaas.geometry import Pose2D
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.key_frame_graph import CLOSURE_FLOOR
from ppaas.mapping.live.live_mapper import LiveMapper
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.parts.map_parts import MapParts
from ppaas.mapping.pipeline.offline import map_log
from ppaas.mapping.scan_points import prepare
from ppaas.planar_poses import compose, relative
from tests.support.world.carried_robots import carried, followed

FALSE = 0.5
"""Distance from the true place above which a closure is false [m]."""

BESIDE = np.array((12.0, 0.0, 12.0, 0.0))
ROOM = ((0.0, 0.0, 5.0, 0.0), (0.0, 0.0, 0.0, 4.0), (0.0, 4.0, 5.0, 4.0), (3.5, 3.0, 4.2, 3.6), (0.8, 0.6, 1.4, 0.9))


@pytest.fixture(scope="module")
def ring() -> SimulatedDrive:
    return ring_drive()


def offline(log):
    made = map_log(log)
    return made.poses, made.mapper.graph, made.mapper.key_frames.scans


def live(log):
    """Map a log scan by scan; return the poses of the robot at each scan by the last map."""
    mapper, parameters, seen = LiveMapper(log.geometry), SlamParameters(), []
    for scan, odometry in enumerate(log.odometry.tolist()):
        tracked = mapper.add(prepare(log.ranges[scan], log.geometry_of(scan), parameters), Pose2D(*odometry))
        frame = Pose2D(*mapper.key_frames.poses[tracked.key_frame].tolist())
        seen.append((tracked.key_frame, frame.inverse() @ tracked.pose))
        work = mapper.next_work()
        if work is not None:
            mapper.apply(work(lambda: False))
    frames = mapper.key_frames.poses[[frame for frame, _ in seen]]
    laser = compose(frames, np.array([pose for _, pose in seen]))
    return compose(laser, np.array(log.geometry.mount.inverse())), mapper.graph, mapper.key_frames.scans


def false_closures(drive, graph, scans) -> int:
    """Return the number of closures that join key frames at another place than they have.

    A closure along a bare corridor says nothing of the place along it.
    """
    laser = compose(drive.true[scans], np.array(drive.log.geometry.mount))
    edges = graph.edges.take(graph.edges.kinds == EdgeKind.CLOSURE)
    off = relative(edges.measurements, relative(laser[edges.first], laser[edges.second]))[:, :2]
    chi2 = np.einsum("mi,mij,mj->m", off, edges.information[:, :2, :2], off)
    return int((np.sqrt(chi2) * CLOSURE_FLOOR[0] > FALSE).sum())


def with_log(drive, **changed) -> SimulatedDrive:
    return SimulatedDrive(replace(drive.log, **changed), drive.true)


def slipped(drive) -> SimulatedDrive:
    """Let the wheels slip for 0.8 m while the robot stands."""
    odometry = drive.log.odometry.copy()
    middle = len(odometry) // 3
    step = relative(odometry[middle - 1], odometry[middle:])
    odometry[middle:] = compose(compose(odometry[middle - 1], np.array((0.8, 0.0, 0.0))), step)
    return with_log(drive, odometry=odometry)


def behind_glass(drive) -> SimulatedDrive:
    """Let the laser look through a third of the surfaces: fans of beams have the maximum range."""
    random, ranges = np.random.default_rng(0), drive.log.ranges.copy()
    for row in ranges:
        for begin in random.integers(0, len(row) - 10, 3):
            row[begin : begin + 10] = 81.9
    return with_log(drive, ranges=ranges)


def among_people(drive) -> SimulatedDrive:
    """Let people walk by at 0.7 to 2 m in every scan."""
    random, ranges = np.random.default_rng(1), drive.log.ranges.copy()
    for row in ranges:
        for begin in random.integers(0, len(row) - 5, 4):
            row[begin : begin + 5] = np.fmin(row[begin : begin + 5], random.uniform(0.7, 2.0))
    return with_log(drive, ranges=ranges)


def without_odometry(drive) -> SimulatedDrive:
    """Let the robot publish one pose all the time."""
    return with_log(drive, odometry=np.tile((3.0, 1.0, 0.5), (len(drive.true), 1)))


def with_reset_odometry(drive) -> SimulatedDrive:
    """Let the odometry and the clock begin again in the middle."""
    odometry, stamps, middle = drive.log.odometry.copy(), drive.log.stamps.copy(), len(drive.true) // 2
    odometry[middle:] = relative(np.array((-80.0, 60.0, 2.0)), odometry[middle:])
    stamps[middle:] -= 1000.0
    return with_log(drive, odometry=odometry, stamps=stamps)


@pytest.mark.parametrize("mapped", [offline, live])
@pytest.mark.parametrize("fault", [slipped, behind_glass, among_people])
def test_the_map_of_a_disturbed_drive_is_right(ring, mapped, fault):
    drive = fault(ring)
    poses, graph, scans = mapped(drive.log)
    assert absolute_errors(drive.true, poses).max() < 0.2
    assert false_closures(drive, graph, scans) == 0


@pytest.mark.parametrize("mapped", [offline, live])
def test_the_map_of_a_robot_that_was_carried_away_becomes_whole_where_it_was_before(ring, mapped):
    drive = carried(ring, len(ring.true) // 4, len(ring.true) // 4 + 40)
    poses, graph, scans = mapped(drive.log)
    assert MapParts.of(graph).is_whole
    assert false_closures(drive, graph, scans) == 0
    assert absolute_errors(drive.true, poses)[scans].max() < 0.1


@pytest.mark.parametrize("mapped", [offline, live])
def test_maps_of_a_robot_that_was_carried_to_another_building_stay_apart(ring, mapped):
    first = ring.first(len(ring.true) // 4)
    drive = followed(
        first, simulate(elsewhere(), np.array([(1.0, 1.0), (9.0, 1.0), (9.0, 6.0), (1.0, 6.0)]), 3, beams=90)
    )
    poses, graph, _ = mapped(drive.log)
    count = len(first.true)
    assert MapParts.of(graph).numbers == (0, 1)
    assert absolute_errors(first.true, poses[:count]).max() < 0.2
    assert absolute_errors(drive.true[count + 10 :], poses[count + 10 :]).max() < 0.2


def elsewhere():
    """Return walls of a hall with five columns, which is no part of the ring."""
    columns = [(x, y, x + 0.7, y + 0.5) for x, y in ((2.0, 3.0), (4.5, 2.2), (5.0, 4.1), (7.2, 3.3), (6.4, 2.4))]
    boxes = [(0.0, 0.0, 10.0, 7.0), *columns]
    return np.array([
        side for x, y, u, v in boxes for side in ((x, y, u, y), (u, y, u, v), (u, v, x, v), (x, v, x, y))
    ])  # fmt: skip


@pytest.mark.parametrize("mapped", [offline, live])
def test_in_an_empty_hall_the_odometry_counts(mapped):
    hall = np.array([(-200.0, -200.0, 200.0, -200.0), (-200.0, 200.0, 200.0, 200.0)])
    drive = simulate(hall, np.array([(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (0.0, 0.0)]), 0, beams=90)
    poses, graph, _ = mapped(drive.log)
    np.testing.assert_allclose(poses, drive.log.odometry, atol=1e-3)
    assert not (graph.edges.kinds == EdgeKind.CLOSURE).any()


@pytest.mark.parametrize("mapped", [offline, live])
def test_two_rooms_that_look_alike_stay_two(mapped):
    """The rooms are beside each other, open to one corridor; the robot visits one, then the other."""
    first = np.array(ROOM)
    rooms = np.concatenate((first, first + BESIDE))
    corridor = np.array([(0.0, -2.5, 17.0, -2.5), (5.0, 0.0, 5.0, 4.0), (17.0, 0.0, 17.0, 4.0), (5.0, 0.0, 12.0, 0.0)])
    doors = np.array([(0.0, 0.0, 2.0, 0.0), (3.2, 0.0, 5.0, 0.0), (0.0, -2.5, 0.0, 0.0), (17.0, -2.5, 17.0, 0.0)])
    own = rooms[~np.isclose(rooms[:, [1, 3]], 0.0).all(axis=1)]
    both = np.concatenate((own, corridor, doors, doors[:2] + BESIDE))
    visit = [(2.6, -1.3), (2.6, 1.8), (1.2, 2.6), (2.6, 1.8), (2.6, -1.3)]
    way = [(0.8, -1.3), *visit, *((x + 12.0, y) for x, y in visit), *visit, (16.2, -1.3)]
    drive = simulate(both, np.array(way), 2, beams=90)
    poses, graph, scans = mapped(drive.log)
    assert false_closures(drive, graph, scans) == 0
    assert absolute_errors(drive.true, poses).max() < 0.3


@pytest.mark.parametrize("fault", [without_odometry, with_reset_odometry])
def test_the_map_is_right_although_the_odometry_fails(ring, fault):
    drive = fault(ring)
    poses, _, _ = offline(drive.log)
    assert absolute_errors(drive.true, poses).max() < 0.05


def test_a_log_that_is_cut_off_has_the_map_of_its_part(ring):
    part = ring.first(len(ring.true) // 2)
    poses, _, _ = offline(part.log)
    assert absolute_errors(part.true, poses).max() < 0.1
