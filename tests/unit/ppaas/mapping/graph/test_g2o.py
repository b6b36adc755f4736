import numpy as np
import pytest

from ppaas.errors import InvalidGraph
from ppaas.mapping.graph.g2o import format_graph, parse_g2o
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
    graph = parse_g2o(SMALL).graph
    assert graph.poses.tolist()[0] == [0.0, 0.0, 0.0] and graph.poses.tolist()[2] == [1.0, 2.0, 0.5]
    assert graph.poses[1, 2] == pytest.approx(7.0 - 2 * np.pi)
    edges = graph.edges
    assert edges.first.tolist() == [0, 1] and edges.second.tolist() == [1, 2]
    assert edges.kinds.tolist() == [EdgeKind.ODOMETRY, EdgeKind.ODOMETRY]
    assert edges.measurements[1] == pytest.approx([0.5, 2.0, 0.5])


def test_information_of_a_file_is_in_the_frame_of_the_second_node():
    information = parse_g2o(SMALL).graph.edges.information[0]
    assert information == pytest.approx(np.diag([25.0, 100.0, 400.0]), abs=1e-9)


def test_written_graph_is_read_again():
    graph, _, _ = walk(50, 30)
    skewed = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    graph.add_edge(9, 2, (0.1, 0.2, 3.1), skewed, EdgeKind.CLOSURE)
    lines = list(format_graph(graph))
    assert all(line.endswith("\n") for line in lines)
    again = parse_g2o(lines).graph
    assert again.poses == pytest.approx(graph.poses, abs=1e-12)
    assert (again.edges.first == graph.edges.first).all() and (again.edges.kinds == graph.edges.kinds).all()
    assert again.edges.information == pytest.approx(graph.edges.information, abs=1e-9)
    same = SolverOptions(Robust.NONE)
    assert GraphSolver().solve(again, same).poses == pytest.approx(GraphSolver().solve(graph, same).poses, abs=1e-6)


def test_a_graph_of_toro_is_the_same_again():
    graph, _, _ = walk(50, 30)
    skewed = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]])
    graph.add_edge(9, 2, (0.1, 0.2, 3.1), skewed, EdgeKind.CLOSURE)
    lines = list(format_graph(graph, of_toro=True))
    assert {line.split()[0] for line in lines} == {"VERTEX2", "EDGE2"}
    again = parse_g2o(lines).graph
    assert again.edges.information == pytest.approx(graph.edges.information, abs=1e-9)
    old = [line.replace("VERTEX2", "VERTEX").replace("EDGE2", "EDGE") for line in lines]
    assert parse_g2o(old).graph.edges.information == pytest.approx(graph.edges.information, abs=1e-9)
    assert list(parse_g2o(old).lines(of_toro=True)) == lines


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("VERTEX_SE3:QUAT 9 1 2 3 0 0 0 1", "line 10: VERTEX_SE3:QUAT is an element of a graph in space"),
        ("EDGE3 3 4 1 0 0 0 0 0", "line 10: EDGE3 is an element of a graph in space"),
        ("FIX 3 here", "line 10: FIX takes integer ids$"),
        ("EDGE2 3 4 1 0 0 1 0 0 1 0 1", "line 10: the information matrix is not positive semidefinite"),
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
    assert list(format_graph(PoseGraph())) == []


def test_ids_their_order_and_fixed_vertices_are_written_as_read():
    huge = 0x7800000000000000  # a symbol x0 of gtsam
    lines = [f"VERTEX_SE2 {vertex} 0.0 0.0 0.0\n" for vertex in (huge + 1, -5, huge)]
    lines += [
        f"EDGE_SE2 {first} {second} 1.0 0.0 0.0 4.0 0.0 0.0 4.0 0.0 9.0\n" for first, second in ((huge, -5), (-5, huge))
    ]
    lines += [f"FIX {huge}\n", "FIX -5\n"]
    assert list(parse_g2o(lines).lines()) == lines


def test_lines_come_in_any_order_with_any_ends():
    shuffled = [line.rstrip() + "\r\n" for line in reversed(SMALL)]
    again, once = parse_g2o(shuffled), parse_g2o(SMALL)
    assert (again.graph.poses == once.graph.poses).all() and again.fixed == once.fixed == (0,)
    assert again.graph.edge_count == 2


def test_one_line_fixes_several_vertices_and_unknown_ones_are_named():
    file = parse_g2o([*SMALL, "FIX 7 12", "FIX 12 4"])
    assert (file.fixed, file.unknown_fixed) == ((0, 2, 1), {12: 10})


def test_no_line_fix_stands_before_an_edge():
    graph, _, _ = walk(5, 0)
    tags = [line.split()[0] for line in format_graph(graph)]
    assert tags == ["VERTEX_SE2"] * 5 + ["EDGE_SE2"] * 4 + ["FIX"]


def test_edges_between_successive_ids_are_odometry_in_both_directions():
    vertices = [f"VERTEX_SE2 {vertex} 0 0 0" for vertex in (100, 110, 120)]
    edges = [f"EDGE_SE2 {ends} 1e0 0 0 1e+2 0 0 1E2 0 100" for ends in ("100 110", "120 110", "120 100")]
    kinds = parse_g2o(vertices + edges).graph.edges.kinds
    assert kinds.tolist() == [EdgeKind.ODOMETRY, EdgeKind.ODOMETRY, EdgeKind.CLOSURE]


def test_elements_of_toro_are_those_of_g2o():
    # Source of the order xx, xy, yy, θθ, xθ, yθ: TORO's manual, and gtsam's NoiseFormatTORO.
    toro = ["VERTEX2 0 0 0 0", "VERTEX2 1 1 0 0", "EDGE2 0 1 1 0.5 0.3 40 1 30 90 2 3"]
    g2o = ["VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 1 0 0", "EDGE_SE2 0 1 1 0.5 0.3 40 1 2 30 3 90"]
    for found, expected in zip(parse_g2o(toro).graph.edges, parse_g2o(g2o).graph.edges, strict=True):
        np.testing.assert_array_equal(found, expected)


def test_elements_that_are_not_solved_are_counted_with_their_first_lines():
    others = ["VERTEX_XY 9 1 2", "EDGE_SE2_XY 3 9 1 1 1 0 1", "EDGE_PRIOR_SE2 3 0 0 0 1 0 0 1 0 1", "VERTEX_XY 10 1 2"]
    file = parse_g2o([*SMALL, *others, "PARAMS_SE2OFFSET 0 0 0 0"])
    assert {tag: (lines.line, lines.count) for tag, lines in file.left_out.items()} == {
        "VERTEX_XY": (10, 2),
        "EDGE_SE2_XY": (11, 1),
        "EDGE_PRIOR_SE2": (12, 1),
    }
    assert file.graph.node_count == 3


def test_edges_between_the_same_vertices_all_count():
    edge = "EDGE_SE2 0 1 {} 0 0 1 0 0 1 0 1"
    file = parse_g2o(["VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 0 0 0", edge.format(1), edge.format(2), edge.format(1)])
    assert GraphSolver().solve(file.graph).poses[1] == pytest.approx([4 / 3, 0, 0])


def test_edges_are_written_with_the_numbers_of_the_file():
    # Turning the information into the frame of the other node and back would change the last digits.
    numbers = "0.98765432109876 0.1234567890123 7.1 44.72136 1.2345678901234 0.1 44.72136 -0.3 29.123456789"
    lines = ["VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 1 0 0", f"EDGE_SE2 0 1 {numbers}"]
    assert f"EDGE_SE2 0 1 {numbers}\n" in list(parse_g2o(lines).lines())


def test_edges_between_chains_of_gtsam_are_closures():
    # The last pose of robot a and the first one of robot b follow each other, but nobody drove from one to the other.
    a, b = (ord(letter) << 56 for letter in "ab")
    vertices = [f"VERTEX_SE2 {robot + number} 0 0 0" for robot in (a, b) for number in range(2)]
    edges = [f"EDGE_SE2 {ends} 1 0 0 1 0 0 1 0 1" for ends in (f"{a} {a + 1}", f"{b + 1} {b}", f"{a + 1} {b}")]
    kinds = parse_g2o(vertices + edges).graph.edges.kinds
    assert kinds.tolist() == [EdgeKind.ODOMETRY, EdgeKind.ODOMETRY, EdgeKind.CLOSURE]


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.0])
def test_information_that_is_short_of_semidefinite_by_rounding_is_taken(angle):
    # That of a corridor at 45°, written with six digits, as C++ writes by default.
    line = f"EDGE_SE2 3 4 1 0 {angle} 500000 -500001 0 500000 0 1"
    information = parse_g2o([*SMALL, line]).graph.edges.information[-1]
    assert np.linalg.eigvalsh(information)[0] >= -1e-9
    assert np.trace(information) == pytest.approx(1000002, rel=1e-5)
    with pytest.raises(InvalidGraph, match=r"line 10: .* not positive semidefinite"):
        parse_g2o([*SMALL, line.replace("500001", "501000")])


def test_a_vertex_may_be_repeated_as_it_is():
    # As in files of several programs that were put together.
    assert parse_g2o([*SMALL, "VERTEX_SE2 7 1 2.0 0.50"]).graph.node_count == 3


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        (["EDGE2 0 1 1 0 0 1 0 1 1 0 0"] * 3, "It has 3 edges: give the start poses of its nodes in lines VERTEX_SE2."),
        (["Pose2d_Node 0", "Pose2d_Factor 0 (0, 0, 0)"], "It has Pose2d_Node, Pose2d_Factor: give"),
        (["\x00\x01\ufffd \x07"], "the graph has no VERTEX_SE2.$"),
    ],
)
def test_what_a_file_without_vertices_has_is_named(lines, text):
    with pytest.raises(InvalidGraph, match=text):
        parse_g2o(lines)


def test_information_of_toro_in_the_order_of_g2o_is_refused_with_the_order():
    with pytest.raises(InvalidGraph, match=r"line 10: .* in the order of TORO, xx xy yy θθ xθ yθ"):
        parse_g2o([*SMALL, "EDGE2 3 4 1 0 0 100 0 0 100 0 400"])
