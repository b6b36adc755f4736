import numpy as np
import pytest

from benchmarks.mapping.parts import graphs
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.mapping.graph.g2o import format_graph
from ppaas.mapping.graph.kernels.edges import edge_errors
from ppaas.mapping.graph.normal_equations import NormalEquations
from ppaas.mapping.graph.solver import Robust
from tests.support.world.pose_graphs import walk


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graphs, "NODES", 300)
    monkeypatch.setattr(graphs, "CLOSURES", 300)


def test_step_of_superlu_is_that_of_the_solver() -> None:
    graph, _, _ = walk(60, 40)
    edges = graph.edges
    equations = NormalEquations(graph.node_count, edges.first, edges.second)
    errors = np.array([np.zeros(3)] * graph.edge_count)
    edge_errors(graph.poses, *edges[:4], errors, np.empty(graph.edge_count))
    gradients = np.einsum("mij,mj->mi", edges.information, errors)
    equations.linearise(graph.poses, edges.information, gradients, np.ones(graph.edge_count))
    assert graphs.superlu_step(graph) == pytest.approx(equations.step(0.0), abs=1e-6)


def test_synthetic_graphs_and_files_are_solved(tmp_path) -> None:
    (tmp_path / "small.g2o").write_text("".join(format_graph(walk(50, 20).graph)))
    found = graphs.measure(SlamOptions(graphs=(tmp_path / "small.g2o",), false=5))
    assert [result["method"] for result in found.results] == ["none", "graduated", "scaling", "graduated", "graduated"]
    assert found.results[1]["mean_m"] < 0.1
    assert found.rows[4]["graph"] == "small" and found.rows[4]["error m"] == ""
    limits = {figure.name: figure.limit for figure in found.figures}
    assert limits["walk, 0 false, none: warm"] == 0.3 and limits["walk, 0 false, graduated: warm"] is None
    assert limits["walk, 5 false, scaling: rejected"] == 5


def test_results_have_the_methods_name() -> None:
    assert graphs.solved(*graphs.walks(0), Robust.SCALING)["method"] == "scaling"
