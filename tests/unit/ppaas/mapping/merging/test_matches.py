import math

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.merging.matches import PlaceMatch, WholeMap, agreeing_sets, pairwise_chi2
from ppaas.mapping.merging.parameters import MergeParameters
from ppaas.planar_poses import compose, relative
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, ROOM, ranges_at

ANGLES = ALL_ROUND.angle_min + ALL_ROUND.angle_increment * np.arange(ALL_ROUND.beams)


def points_at(pose):
    """Return the points (n, 2) that a laser sees at a pose in the room, in its own frame."""
    ranges = ranges_at(pose, ALL_ROUND, ROOM).astype(np.float64)
    return np.column_stack((np.cos(ANGLES), np.sin(ANGLES))) * ranges[:, None]


def map_of_the_room():
    centre = points_at((2.0, -1.0, 0.0)) + np.array((2.0, -1.0))
    corner = points_at((-3.0, 2.5, 0.0)) + np.array((-3.0, 2.5))
    return WholeMap(np.concatenate((centre, corner)), np.array([(2.0, -1.0, 0.0), (-3.0, 2.5, 0.0)]), MergeParameters())


MAP = map_of_the_room()


@settings(max_examples=examples(20))
@example(2.0, -1.59375, 1.5)
@given(x=st.floats(0.5, 3.0), y=st.floats(-2.0, 0.5), theta=st.floats(-math.pi, math.pi))
def test_a_place_is_found_at_any_heading(x, y, theta):
    (best, score), *_ = MAP.places(points_at((x, y, theta)))
    assert best.distance_to(Pose2D(x, y)) < 0.15
    assert abs((best.theta - theta + math.pi) % (2.0 * math.pi) - math.pi) < 0.04
    assert score > 0.6


def test_points_of_another_room_have_no_place():
    scattered = np.random.default_rng(0).uniform(-8.0, 8.0, (300, 2))
    assert MAP.places(scattered) == []
    assert MAP.places(np.empty((0, 2))) == []


def test_two_places_that_look_alike_are_both_found():
    box = np.concatenate([np.column_stack((np.linspace(-1.0, 1.0, 40), np.full(40, y))) for y in (-1.0, 1.0)])
    there = np.concatenate((box, box + np.array((12.0, 0.0))))
    places = WholeMap(there, np.array([(0.0, 0.0, 0.0), (12.0, 0.0, 0.0)]), MergeParameters()).places(box)
    assert sorted(round(place.x) for place, _ in places) == [0, 12]


DRIFT = ClosureParameters().drift
LENGTH = 60
"""Key frames of each mapping, 1 m apart."""


def two_corridors():
    """Return the graph of two mappings along one corridor, each in its own frame."""
    graph = PoseGraph()
    for _ in range(2):
        for k in range(LENGTH):
            node = graph.add_node((float(k), 0.0, 0.0))
            if k:
                graph.add_edge(node - 1, node, (1.0, 0.0, 0.0), 1e4 * np.eye(3), EdgeKind.ODOMETRY)
    return graph


def match_at(graph, at, motion):
    """Return the match of the second mapping's key frame ``at`` at the place that a motion of its frame leads to."""
    node, moved = LENGTH + at, compose(np.array(motion), graph.poses[LENGTH + at])
    target = int(np.clip(round(moved[0]), 0, LENGTH - 1))
    measured = relative(graph.poses[target], moved)[None]
    edges = Edges(
        np.array([target]), np.array([node]), measured, np.eye(3)[None], np.array([EdgeKind.CLOSURE], np.uint8)
    )
    return PlaceMatch(Submap(node, node + 1), Pose2D(*motion), 0.9, edges)


def test_matches_of_one_motion_agree_and_others_do_not():
    graph = two_corridors()
    true = [match_at(graph, at, (5.0 + 0.1 * (at % 3), 0.05, 0.01)) for at in (2, 12, 25, 40)]
    shifted = [match_at(graph, at, (10.0, 0.0, 0.0)) for at in (10, 20)]
    sets = list(agreeing_sets(graph, [shifted[0], *true, shifted[1]], DRIFT))
    assert sets == [true, shifted]


def test_one_part_at_two_places_never_agrees():
    graph = two_corridors()
    here, there = match_at(graph, 20, (0.0, 0.0, 0.0)), match_at(graph, 20, (3.0, 0.0, 0.0))
    assert len(next(agreeing_sets(graph, [here, there], DRIFT))) == 1


def test_far_matches_may_differ_by_the_drift_between_them():
    graph = two_corridors()
    near = pairwise_chi2(graph, [match_at(graph, 4, (0.0, 0.0, 0.0)), match_at(graph, 6, (0.0, 0.8, 0.0))], DRIFT)
    far = pairwise_chi2(graph, [match_at(graph, 4, (0.0, 0.0, 0.0)), match_at(graph, 50, (0.0, 0.8, 0.0))], DRIFT)
    assert near[0, 1] > 11.34 > far[0, 1]
    np.testing.assert_array_equal(near, near.T)


def test_no_match_makes_no_set():
    assert list(agreeing_sets(two_corridors(), [], DRIFT)) == []
