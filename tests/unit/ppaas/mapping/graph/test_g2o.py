import numpy as np
import pytest

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.g2o import format_g2o, parse_g2o
from ppaas.mapping.graph.pose_graph import EdgeKind, PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from tests.support.world.pose_graphs import walk

SMALL = """# a comment

VERTEX_SE2 7 1.0 2.0 0.5
VERTEX_SE2 3 0 0 0   # vertices in any order
FIX 3
ROBOTLASER1 0 -1.57 3.14 0.0174 30
VERTEX_SE2 4 1 0 7.0
EDGE_SE2 3 4 1 0 1.5707963267948966 100 0 0 25 0 400
EDGE_SE2 4 7 0.5 2 -5.7831853071795866 1 0 0 1 0 1
""".splitlines()


def test_graph_is_read():
    graph = parse_g2o(SMALL)
    assert graph.poses.tolist()[0] == [0.0, 0.0, 0.0] and graph.poses.tolist()[2] == [1.0, 2.0, 0.5]
    assert graph.poses[1, 2] == pytest.approx(7.0 - 2 * np.pi)
    edges = graph.edges
    assert edges.first.tolist() == [0, 1] and edges.second.tolist() == [1, 2]
    assert edges.kinds.tolist() == [EdgeKind.ODOMETRY, EdgeKind.CLOSURE]
    assert edges.measurements[1] == pytest.approx([0.5, 2.0, 0.5])


def test_information_of_a_file_is_in_the_frame_of_the_second_node():
    information = parse_g2o(SMALL).edges.information[0]
    assert information == pytest.approx(np.diag([25.0, 100.0, 400.0]), abs=1e-9)


def test_written_graph_is_read_again():
    graph, _, _ = walk(50, 30)
    skewed = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    graph.add_edge(9, 2, (0.1, 0.2, 3.1), skewed, EdgeKind.CLOSURE)
    lines = list(format_g2o(graph))
    assert all(line.endswith("\n") for line in lines)
    again = parse_g2o(lines)
    assert again.poses == pytest.approx(graph.poses, abs=1e-12)
    assert (again.edges.first == graph.edges.first).all() and (again.edges.kinds == graph.edges.kinds).all()
    assert again.edges.information == pytest.approx(graph.edges.information, abs=1e-9)
    same = SolverOptions(Robust.NONE)
    assert GraphSolver().solve(again, same).poses == pytest.approx(GraphSolver().solve(graph, same).poses, abs=1e-6)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("VERTEX_XY 9 1 2", "line 10: unknown element 'VERTEX_XY'"),
        ("VERTEX_SE2 9 1 2", "line 10: VERTEX_SE2 takes 4 values, got 3"),
        ("VERTEX_SE2 nine 1 2 3", "line 10: VERTEX_SE2 takes integer ids"),
        ("VERTEX_SE2 9 1 2 east", "line 10: VERTEX_SE2 takes integer ids, then numbers"),
        ("VERTEX_SE2 9 1 nan 3", "line 10: VERTEX_SE2 has a number that is not finite"),
        ("VERTEX_SE2 7 1 2 3", "line 10: vertex 7 is defined twice"),
        ("EDGE_SE2 3 4 1 0 0 1 0 0 1 0", "line 10: EDGE_SE2 takes 11 values, got 10"),
        ("EDGE_SE2 3 4 1 0 inf 1 0 0 1 0 1", "line 10: EDGE_SE2 has a number that is not finite"),
        ("EDGE_SE2 3 5 1 0 0 1 0 0 1 0 1", "line 10: no VERTEX_SE2 defines 5"),
        ("EDGE_SE2 3 3 1 0 0 1 0 0 1 0 1", "line 10: edge from vertex 3 to itself"),
        ("EDGE_SE2 3 4 1 0 0 1 2 0 1 0 1", "line 10: the information matrix is not positive semidefinite"),
    ],
)
def test_invalid_line_is_named(line, text):
    with pytest.raises(InvalidGraph, match=text):
        parse_g2o([*SMALL, line])


def test_text_without_vertices_is_refused():
    with pytest.raises(InvalidGraph, match="no VERTEX_SE2"):
        parse_g2o(["# nothing"])


def test_empty_graph_has_no_lines():
    assert list(format_g2o(PoseGraph())) == []
