"""Refinement while the robot stands: the map gets better, and stays so."""

import copy

import numpy as np
import pytest

from ppaas.change_log import LogEntry
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.agreement import CLOSING, GRADUATED
from ppaas.mapping.graph.pose_graph import EdgeKind
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.live import refining_mapper
from ppaas.mapping.live.refining_mapper import RefiningMapper
from ppaas.mapping.merging.united import frame_ids, united
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.scan_log import ScanLog
from ppaas.mapping.scan_points import prepare
from ppaas.mapping.serialization.mapping_log import LogWriter, read_log
from ppaas.planar_poses import compose, relative
from tests.support.world.carried_robots import carried
from tests.support.world.ring_drive import ring_drive


def never() -> bool:
    return False


def drive(mapper: RefiningMapper, first: int, end: int, *, closes: bool = True, log: ScanLog | None = None) -> None:
    """Map some scans of a drive; without closures, all searches fail."""
    log = log or ring_drive().log
    for number in range(first, end):
        scan = prepare(log.ranges[number], log.geometry, SlamParameters(), np.zeros(3))
        mapper.add(scan, Pose2D(*log.odometry[number].tolist()))
        while (work := mapper.next_work()) is not None:
            mapper.apply(work(never) if closes else None)


def error(mapper: RefiningMapper, poses=None) -> float:
    """Return the mean distance of key frames from the true poses, seen from the first one [m]."""
    poses = mapper.key_frames.poses if poses is None else poses
    true = compose(ring_drive().true[mapper.key_frames.scans], np.array(ring_drive().log.geometry.mount))
    apart = relative(poses[0], poses) - relative(true[0], true)
    return float(np.hypot(apart[:, 0], apart[:, 1]).mean())


def mapped(*, closes: bool) -> RefiningMapper:
    mapper = RefiningMapper(ring_drive().log.geometry)
    drive(mapper, 0, len(ring_drive().log), closes=closes)
    return mapper


@pytest.fixture(scope="module")
def unrefined() -> RefiningMapper:
    return mapped(closes=True)


@pytest.fixture(scope="module")
def refined(unrefined) -> RefiningMapper:
    mapper = copy.deepcopy(unrefined)
    mapper.apply(mapper.next_idle_work()(never))
    return mapper


def test_the_map_gets_better(unrefined, refined):
    assert error(refined) < 0.7 * error(unrefined)
    np.testing.assert_array_equal(refined.key_frames.poses[0], unrefined.key_frames.poses[0])
    np.testing.assert_array_equal(refined.graph.poses, refined.key_frames.poses)
    assert refined.solves == unrefined.solves + 1
    assert refined.pose.distance_to(unrefined.pose) < 0.02
    assert refined.draw().info == unrefined.draw().info


@pytest.mark.parametrize("options", [CLOSING, GRADUATED])
def test_a_solve_keeps_it(refined, options):
    np.testing.assert_allclose(GraphSolver().solve(refined.graph, options).poses, refined.key_frames.poses, atol=1e-4)


def test_it_is_not_refined_again_until_it_grows(refined, monkeypatch):
    assert refined.next_idle_work() is None
    monkeypatch.setattr(refined, "_refined_to", 0)
    poses, edges = refined.key_frames.poses.copy(), refined.graph.edge_count
    mapper = copy.deepcopy(refined)
    assert mapper.apply(mapper.next_idle_work()(never)).distance_to(Pose2D(0.0, 0.0)) < 0.002
    np.testing.assert_allclose(mapper.key_frames.poses, poses, atol=0.002)
    assert mapper.graph.edge_count == edges
    monkeypatch.setattr(refining_mapper, "MOST_REFINED", len(poses) - 1)
    assert refined.next_idle_work() is None


def test_loops_that_are_missing_are_closed():
    mapper = mapped(closes=False)
    before = error(mapper)
    assert not mapper.closed
    result = mapper.next_idle_work()(never)
    assert not mapper.closed
    mapper.apply(result)
    assert error(mapper) < 0.7 * before
    assert mapper.closed == result.closures > 3
    assert (mapper.graph.edges.kinds == EdgeKind.CLOSURE).sum() >= 3 * mapper.closed


def test_a_cancelled_refinement_changes_nothing_and_stays_due(unrefined):
    mapper, asked = copy.deepcopy(unrefined), []
    poses, edges = mapper.key_frames.poses.copy(), mapper.graph.edges.measurements.copy()
    work = mapper.next_idle_work()
    assert mapper.next_idle_work() is mapper.next_work() is None
    assert work(lambda: True) is None
    assert work(lambda: asked.append(None) or len(asked) > len(work.submaps) + 2) is None, "in the alignment"
    mapper.apply(None)
    np.testing.assert_array_equal(mapper.key_frames.poses, poses)
    np.testing.assert_array_equal(mapper.graph.edges.measurements, edges)
    assert mapper.next_idle_work() is not None


def test_key_frames_that_come_meanwhile_move_along(monkeypatch):
    half, end = len(ring_drive().log) * 3 // 4, len(ring_drive().log)
    mapper = RefiningMapper(ring_drive().log.geometry)
    drive(mapper, 0, half)
    result = mapper.next_idle_work()(never)
    known, edges = len(mapper.key_frames), mapper.graph.edge_count
    drive(mapper, half, half + 40)
    steps = relative(mapper.key_frames.poses[known - 1], mapper.key_frames.poses[known:])
    later = mapper.graph.edges.since(edges)
    mapper.apply(result)
    np.testing.assert_allclose(relative(mapper.key_frames.poses[known - 1], mapper.key_frames.poses[known:]), steps)
    np.testing.assert_array_equal(mapper.graph.edges.first[edges : edges + len(later.first)], later.first)
    drive(mapper, half + 40, end)
    assert error(mapper) < 0.01
    assert mapper.next_idle_work() is not None


def test_the_log_has_the_refined_map(unrefined):
    mapper, writer, entries = copy.deepcopy(unrefined), LogWriter("laser"), {}
    write(writer, mapper, entries)
    for _ in range(2):
        mapper._refined_to = 0
        mapper.apply(mapper.next_idle_work()(never))
        write(writer, mapper, entries)
        log = [LogEntry(*entry) for entry in sorted(entries.items())]
        again = read_log(log)
        np.testing.assert_array_equal(again.frames.poses, mapper.key_frames.poses)
        solved = GraphSolver().solve(again.graph, CLOSING).poses
        np.testing.assert_allclose(solved, mapper.key_frames.poses, atol=1e-4)
        assert again.graph.edge_count == mapper.graph.edge_count
        assert frame_ids(again) == frame_ids(mapper.mapping("laser"))
        assert len(entries) == 4, "laser, key frames, edges and poses"


def write(writer: LogWriter, mapper: RefiningMapper, entries: dict[int, bytes]) -> None:
    while (change := writer.write(mapper.growing())) is not None:
        entries.update(change.entries)
        for number in change.obsolete:
            del entries[number]


def test_key_frames_keep_their_ids_and_edges_are_known_in_joint_maps(unrefined, refined):
    before, after = unrefined.mapping("laser"), refined.mapping("laser")
    assert frame_ids(before) == frame_ids(after)
    for one, other in ((before, after), (after, before)):
        assert united(one, other).mapping.graph.edge_count == after.graph.edge_count


def test_where_no_loops_are_closed_or_the_robot_is_localized_nothing_is_refined(unrefined):
    for mapper, keeps in (
        (RefiningMapper(ring_drive().log.geometry, closures=None), True),
        (RefiningMapper(ring_drive().log.geometry), False),
        (RefiningMapper(ring_drive().log.geometry), True),  # refined when it was published
    ):
        mapper.load(unrefined.mapping("laser"), Pose2D(0.0, 0.0), keeps=keeps)
        assert mapper.next_idle_work() is None


def test_of_a_map_with_parts_the_current_one_is_refined():
    carried_away = carried(ring_drive(), 160, 200)
    mapper = RefiningMapper(carried_away.log.geometry)
    drive(mapper, 0, 300, log=carried_away.log)
    start, before = mapper.parts.last_start, mapper.key_frames.poses.copy()
    assert 0 < start < len(before) - 16
    mapper.apply(mapper.next_idle_work()(never))
    after = mapper.key_frames.poses
    np.testing.assert_array_equal(after[: start + 1], before[: start + 1])
    assert np.abs(after[start + 1 :] - before[start + 1 :]).max() > 1e-4
    held = mapper.parts.held(mapper.graph)
    np.testing.assert_allclose(GraphSolver().solve(held, CLOSING).poses, after, atol=1e-4)
