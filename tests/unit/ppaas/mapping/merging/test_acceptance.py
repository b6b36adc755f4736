import numpy as np
import pytest

from ppaas.errors import InvalidParameter, MapsNotMerged
from ppaas.geometry import Pose2D
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import Edges, PoseGraph
from ppaas.mapping.merging.hypothesis import Hypothesis, Overlap
from ppaas.mapping.merging.matches import PlaceMatch
from ppaas.mapping.merging.merge import accepted
from ppaas.mapping.merging.parameters import MergeParameters

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
