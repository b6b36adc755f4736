import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import Window
from ppaas.mapping.closures.candidates import Candidate
from ppaas.mapping.closures.closure import Links
from ppaas.mapping.closures.submaps import Submap
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph

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


def candidate(target: int, far: float) -> Candidate:
    return Candidate(target, Pose2D(0.0, 0.0), Window(1.0, 1.0, 0.1), False, far)


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
