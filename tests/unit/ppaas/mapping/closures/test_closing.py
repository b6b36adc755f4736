import itertools

import numpy as np
import pytest

from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import MotionWindow
from ppaas.mapping.closures.candidates import SubmapCandidate
from ppaas.mapping.closures.closing import ClosureComparison, ClosureSearch
from ppaas.mapping.closures.closure import Closure, Links, Reason, RefusedClosure
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap, Submaps, travelled
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.key_frames import KeyFrames
from ppaas.planar_poses import compose, relative
from tests.support.world.room_scans import CORRIDOR, LASER, ROOM, scan_at

PARAMETERS = ClosureParameters()


def drive(true, walls, drift):
    """Return key frames, graph and submaps of a drive whose odometry turns by ``drift`` more in each step [rad]."""
    frames, graph, submaps = KeyFrames(LASER), PoseGraph(), Submaps(1.5)
    turn = np.array([0.0, 0.0, drift])
    for k, pose in enumerate(true):
        step = relative(true[k - 1], pose) + turn if k else np.zeros(3)
        estimate = compose(graph.poses[-1], step) if k else pose
        frames.add(scan_at(pose, walls=walls), k, Pose2D(*estimate.tolist()), np.zeros(6))
        graph.add_node(estimate)
        if k:
            graph.add_edge(k - 1, k, step, np.eye(3), EdgeKind.ODOMETRY)
        submaps.add(step)
    submaps.finish()
    return frames, graph, submaps.finished


def loop():
    """Return poses around the box of the room, and along the start again."""
    corners = [(-3.0, -2.0), (3.0, -2.0), (3.0, 2.3), (-3.0, 2.3), (-3.0, -2.0), (3.0, -2.0)]
    poses = []
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        heading, n = np.arctan2(y1 - y0, x1 - x0), round(np.hypot(x1 - x0, y1 - y0) / 0.25)
        poses += [(x0 + (x1 - x0) * k / n, y0 + (y1 - y0) * k / n, heading) for k in range(n)]
    return np.array(poses)


@pytest.fixture(scope="module")
def closed():
    true = loop()
    frames, graph, submaps = drive(true, ROOM, 0.001)
    return true, graph, ClosureSearch().search(frames, graph, submaps, len(submaps) - 1)


def test_closures_of_a_second_visit_are_exact(closed):
    true, _graph, found = closed
    assert found.closures
    for closure in found.closures:
        edges = closure.edges
        exact = relative(true[edges.first], true[edges.second])
        np.testing.assert_allclose(edges.measurements[:, :2], exact[:, :2], atol=0.03)
        assert (edges.kinds == EdgeKind.CLOSURE).all()
        assert (edges.first < edges.second).all()
        assert (np.linalg.eigvalsh(edges.information) > 0.0).all()


def test_motion_of_a_closure_corrects_the_drift(closed):
    true, graph, found = closed
    closure = max(found.closures, key=lambda closure: closure.score)
    k, drifted = closure.source.middle, graph.poses[closure.source.middle]
    corrected = compose(np.array(closure.motion), drifted)
    assert np.hypot(*(corrected - true[k])[:2]) < np.hypot(*(drifted - true[k])[:2]) + 0.05


def test_bare_corridor_closes_no_loop():
    there = np.stack((np.arange(0.0, 8.0, 0.25), np.zeros(32), np.zeros(32)), axis=1)
    true = np.concatenate((there, there))
    frames, graph, submaps = drive(true, CORRIDOR, 0.0)
    found = ClosureSearch().search(frames, graph, submaps, len(submaps) - 1)
    assert found.closures == []
    assert {refusal.reason for refusal in found.refusals} <= {Reason.CHECK, Reason.SCORE, Reason.AMBIGUOUS}


def test_first_submap_has_nothing_to_search():
    frames, graph, submaps = drive(loop()[:12], ROOM, 0.0)
    assert ClosureSearch().search(frames, graph, submaps, 0).refusals == []


def closure(target, motion, score=0.8):
    edges = Edges(np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros(0, np.uint8))
    return Closure(Submap(50, 60), target, edges, score, Pose2D(*motion), True)


def test_matches_with_one_area_at_two_places_contradict():
    graph = PoseGraph()
    for k in range(60):
        graph.add_node((float(k), 0.0, 0.0))
    for k in range(59):
        graph.add_edge(k, k + 1, (1.0, 0.0, 0.0), np.eye(3), EdgeKind.ODOMETRY)
    compare = ClosureComparison(graph.poses, graph.edges, PARAMETERS)
    best = closure(Submap(0, 5), (0.0, 0.0, 0.0))
    near, shifted = closure(Submap(5, 10), (0.1, 0.1, 0.0)), closure(Submap(5, 10), (12.0, 0.0, 0.0))
    # Drift over 35 m explains 1.2 m across the path.
    drifted = closure(Submap(35, 40), (0.0, 1.2, 0.0))
    missed = RefusedClosure(best.source, Submap(5, 10), Reason.SCORE, 0.0)
    assert list(compare.with_best(best, [best, near, shifted, drifted, missed])) == [shifted]


SUBMAPS = [Submap(4 * number, 4 * number + 4) for number in range(30)]


@pytest.fixture
def links():
    graph = PoseGraph()
    for number in range(121):
        graph.add_node((float(number), 0.0, 0.0))
    graph.add_edge(0, 1, np.zeros(3), np.eye(3), EdgeKind.ODOMETRY)
    graph.add_edge(10, 101, np.zeros(3), np.eye(3), EdgeKind.CLOSURE)  # submaps 2 and 25
    graph.add_edge(10, 120, np.zeros(3), np.eye(3), EdgeKind.CLOSURE)  # the last is not finished
    return Links(SUBMAPS, graph.edges)


def candidate(target: int, far: float) -> SubmapCandidate:
    return SubmapCandidate(target, Pose2D(0.0, 0.0), MotionWindow(1.0, 1.0, 0.1), False, far)


def test_a_closure_joins_submaps_and_their_neighbours(links):
    assert links.join(25, 2)
    assert links.join(26, 4)
    assert links.join(24, 0)
    assert not links.join(27, 2)
    assert not links.join(25, 5)
    assert not links.join(1, 0)


def test_the_nearest_candidate_of_each_pass_that_is_not_joined_is_searched(links):
    passes = [candidate(1, 0.5), candidate(2, 0.1), candidate(10, 0.6), candidate(12, 0.2), candidate(13, 0.4)]
    assert [found.target for found in links.unlinked(25, passes)] == [12]
    assert [found.target for found in links.unlinked(29, passes)] == [2, 12]


def test_defaults_are_valid():
    assert ClosureParameters().drift.heading_walk > 0.0


@pytest.mark.parametrize(
    "given",
    [
        {"least_ratio": 1.5},
        {"submap_travel": 0.0},
        {"loop_search_space_resolution": float("nan")},
        {"loop_match_minimum_chain_size": 6},
    ],
)
def test_parameter_out_of_range_is_refused_by_name(given):
    with pytest.raises(InvalidParameter, match=next(iter(given))):
        ClosureParameters(**given)


def test_turns_count_as_distance():
    np.testing.assert_allclose(travelled(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, -1.0]])), [5.0, 0.5])


def test_key_frame_beyond_the_length_opens_the_next_submap():
    submaps = Submaps(1.0)
    step = np.array([0.4, 0.0, 0.0])
    finished = [submaps.add(step) for _ in range(7)]
    assert finished[3] == Submap(0, 3)
    assert submaps.finished == [Submap(0, 3), Submap(3, 6)]
    assert submaps.finish() == Submap(6, 7)
    assert submaps.finish() is None


def test_run_without_key_frames_has_no_submap():
    assert Submaps().finish() is None


@pytest.mark.parametrize(("submap", "middle"), [(Submap(0, 3), 1), (Submap(4, 5), 4)])
def test_middle_is_a_key_frame_of_the_submap(submap, middle):
    assert submap.middle == middle
