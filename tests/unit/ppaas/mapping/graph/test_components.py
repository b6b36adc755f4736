import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph, components

COUNT = 9
ENDS = st.tuples(st.integers(0, COUNT - 1), st.integers(0, COUNT - 1)).filter(lambda ends: ends[0] != ends[1])


def flooded(edges) -> list[int]:
    """Return the components by flooding, numbered by their first nodes."""
    found = list(range(COUNT))
    for _ in range(COUNT):
        for one, other in edges:
            found[one] = found[other] = min(found[one], found[other])
    numbers = sorted(set(found))
    return [numbers.index(each) for each in found]


@given(st.lists(ENDS, max_size=12))
def test_components_are_those_of_flooding(edges):
    graph = PoseGraph()
    for _ in range(COUNT):
        graph.add_node(np.zeros(3))
    for first, second in edges:
        graph.add_edge(first, second, np.zeros(3), np.eye(3), EdgeKind.ODOMETRY)
    assert components(graph).tolist() == flooded(edges)


def test_a_graph_without_nodes_has_no_component():
    assert len(components(PoseGraph())) == 0
