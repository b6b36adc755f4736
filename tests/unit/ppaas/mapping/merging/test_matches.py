import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter, MapsNotMerged
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, Edges, PoseGraph
from ppaas.mapping.merging.hypothesis import Hypothesis, Overlap
from ppaas.mapping.merging.matches import PlaceMatch, WholeMap, agreeing_sets, pairwise_chi2
from ppaas.mapping.merging.merge import accepted
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


PARAMETERS = MergeParameters()
NO_EDGES = Edges(np.empty(0, int), np.empty(0, int), np.empty((0, 3)), np.empty((0, 3, 3)), np.empty(0, np.uint8))
NODES = 60
"""Key frames, 1 m apart."""


def drive():
    graph = PoseGraph()
    for k in range(NODES):
        graph.add_node((float(k), 0.0, 0.0))
    return graph


def claim(places=(5, 15, 25, 35), fits=0.9, confirmed=0.99, compared=40, x=0.0):
    """Return a hypothesis with matches at some key frames; parts of ``compared`` scans fit and are confirmed."""
    matches = [PlaceMatch(Submap(at, at + 2), Pose2D(x, 0.0), 0.9, NO_EDGES) for at in places]
    mask = np.arange(compared) < round(fits * compared)
    return Hypothesis(matches, PoseGraph(), Overlap(np.arange(compared), mask, confirmed * mask, []))


def test_a_hypothesis_that_fits_is_accepted():
    best = claim()
    assert accepted([best], drive(), PARAMETERS) is best


def test_a_rival_that_contradicts_is_no_obstacle():
    best, rival = claim(places=(5, 15, 25)), claim(confirmed=0.95, x=9.0)
    assert accepted([rival, best], drive(), PARAMETERS) is best


@pytest.mark.parametrize(
    ("claims", "why"),
    [
        ([], "too few places .* 0 agree"),
        ([claim(places=(5, 15))], "too few places"),
        ([claim(places=(5, 7, 9))], "over 12 m of the drive"),
        ([claim(places=(5, 5, 5, 30))], "too few places"),
        ([claim(fits=0.5)], "20 of 40 scans fit"),
        ([claim(compared=8)], "7 of 8 scans fit"),
        ([claim(confirmed=0.9)], "90.0% of what both saw agrees"),
        ([claim(), claim(confirmed=0.985, x=9.0)], r"ambiguous: .*\(0.0 m.*\(9.0 m"),
        ([claim(), claim(places=(40, 50), x=9.0)], "ambiguous"),
    ],
)
def test_others_are_refused_with_the_reason(claims, why):
    with pytest.raises(MapsNotMerged, match=why):
        accepted(claims, drive(), PARAMETERS)


def test_shares_above_one_are_refused():
    with pytest.raises(InvalidParameter, match="least_confirmed must be at most 1"):
        MergeParameters(least_confirmed=1.1)
