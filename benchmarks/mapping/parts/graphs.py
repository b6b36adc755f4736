"""Part ``graphs``: the solver of pose graphs, on synthetic graphs and on graphs in files, beside SuperLU."""

from time import process_time
from typing import Any

import numpy as np

from benchmarks.harness.figures import Figure, PartResult
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.mapping.graph.g2o import parse_g2o
from ppaas.mapping.graph.pose_graph import PoseGraph
from ppaas.mapping.graph.solver import GraphSolver, Robust, SolverOptions
from ppaas.planar_poses import PoseArray
from tests.support.world.pose_graphs import walk

SYNTHETIC = ((False, Robust.NONE), (False, Robust.GRADUATED), (True, Robust.SCALING), (True, Robust.GRADUATED))
"""Solves of the synthetic graphs: whether there are false closures, and the method."""

LIMIT, WARM_LIMIT = 5.0, 0.3
"""Largest time of a solve from odometry, and from the solution by least squares or scaling [s]."""


def measure(options: SlamOptions) -> PartResult:
    """Solve each graph by each method."""
    warm_kernels()
    results = [solved(*walks(options.false if lies else 0), robust) for lies, robust in SYNTHETIC]
    figures = [figure for result in results for figure in figures_of(result, options.false)]
    for file in options.graphs:
        with file.open(encoding="utf-8") as lines:
            graph = parse_g2o(lines).graph
        results.append(solved(file.stem, graph, None, Robust.GRADUATED))
    return PartResult(figures, list(map(row_of, results)), results)


def figures_of(result: dict[str, Any], false: int) -> list[Figure]:
    """Return the times of a synthetic graph; that from the solution has a bar unless convexity is graduated anew."""
    name = f"{result['graph']}, {result['method']}"
    size = f"{result['nodes']:,} nodes, {result['edges']:,} edges, {result['solves']} solves"
    warm = None if result["method"] == Robust.GRADUATED.value else WARM_LIMIT
    figures = [
        Figure("graphs", f"{name}: from odometry", round(result["from_start_s"], 2), "s", limit=LIMIT, note=size),
        Figure("graphs", f"{name}: warm", round(result["warm_s"], 2), "s", limit=warm),
        Figure(
            "graphs", f"{name}: baseline", round(result["superlu_s"], 2), "s", yardstick=True,
            note="SuperLU of scipy, one of the solves",
        ),
    ]  # fmt: skip
    if not result["graph"].endswith(" 0 false"):
        share = f"of {false} false closures"
        figures.append(
            Figure("graphs", f"{name}: rejected", result["rejected"], "", limit=false, floor=True, note=share)
        )
    return figures


# -- solves of a pose graph --------------------------------------------------------------------------------------------

NODES, CLOSURES = 11_456, 23_845
"""Size of the synthetic graph: that for which gtsam and Cartographer were measured."""


def walks(false: int) -> tuple[str, PoseGraph, PoseArray]:
    """Return the name, the graph and the true poses of a synthetic walk with false closures."""
    graph, truth, _ = walk(NODES, CLOSURES - false, false=false)
    return f"walk, {false} false", graph, truth


def solved(name: str, graph: PoseGraph, truth: PoseArray | None, robust: Robust) -> dict[str, Any]:
    """Return the CPU times and the errors of the solves of a graph [s, m]. Poses of the graph are its solution then."""
    options = SolverOptions(robust)
    cold, seconds = _timed(lambda: GraphSolver().solve(graph, options))
    graph.move_nodes(cold.poses)
    solver = GraphSolver()
    warm, warm_seconds = _timed(lambda: solver.solve(graph, options))
    _, kept_seconds = _timed(lambda: solver.solve(graph, options))
    errors = np.zeros(0) if truth is None else np.hypot(*(cold.poses - truth)[:, :2].T)
    return {
        "graph": name,
        "nodes": graph.node_count,
        "edges": graph.edge_count,
        "method": robust.value,
        "from_start_s": seconds,
        "solves": cold.iterations,
        "converged": cold.converged,
        "warm_s": warm_seconds,
        "warm_solves": warm.iterations,
        "warm_same_edges_s": kept_seconds,
        "superlu_s": _timed(lambda: superlu_step(graph))[1],
        "rejected": int((cold.weights < 0.1).sum()),
        "mean_m": float(errors.mean()) if errors.size else None,
        "max_m": float(errors.max()) if errors.size else None,
    }


def superlu_step(graph: PoseGraph) -> PoseArray:
    """Return the Gauss-Newton step (n, 3) of a graph by scipy's SuperLU, for comparison."""
    from scipy.sparse import block_array, csc_array  # noqa: PLC0415 - of the extra bench
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    edges, poses = graph.edges, graph.poses
    c, s = np.cos(poses[edges.first, 2]), np.sin(poses[edges.first, 2])
    x, y = (poses[edges.second] - poses[edges.first])[:, :2].T
    by_second = np.zeros((len(c), 3, 3))
    by_second[:, 0, 0], by_second[:, 0, 1], by_second[:, 1, 0], by_second[:, 1, 1], by_second[:, 2, 2] = c, s, -s, c, 1
    by_first = -by_second
    by_first[:, 0, 2], by_first[:, 1, 2] = c * y - s * x, -c * x - s * y
    predicted = np.stack((c * x + s * y, c * y - s * x, poses[edges.second, 2] - poses[edges.first, 2]), axis=1)
    errors = predicted - edges.measurements
    errors[:, 2] = np.arctan2(np.sin(errors[:, 2]), np.cos(errors[:, 2]))
    roots = np.swapaxes(np.linalg.cholesky(edges.information), 1, 2)
    rows = np.repeat(np.arange(3 * len(c)), 6)
    ends = np.stack((edges.first, edges.second), axis=1)[:, None, :, None] * 3 + np.arange(3)
    columns = np.broadcast_to(ends, (len(c), 3, 2, 3)).ravel()
    values = np.stack((roots @ by_first, roots @ by_second), axis=2).ravel()
    jacobian = csc_array((values, (rows, columns)), shape=(3 * len(c), poses.size))[:, 3:]
    hessian = csc_array(block_array([[jacobian.T @ jacobian]]))
    factor = splu(hessian, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    step = factor.solve(-jacobian.T @ np.einsum("mij,mj->mi", roots, errors).ravel())
    return np.vstack((np.zeros(3), step.reshape(-1, 3)))


def warm_kernels() -> None:
    """Solve a small graph by each method, so that the kernels are compiled or loaded."""
    for robust in Robust:
        GraphSolver().solve(walk(60, 40).graph, SolverOptions(robust))


def row_of(result: dict[str, Any]) -> dict[str, str]:
    """Return the row of the table for a result."""
    return {
        "graph": result["graph"],
        "nodes": str(result["nodes"]),
        "edges": str(result["edges"]),
        "method": result["method"],
        "from start s": f"{result['from_start_s']:.2f} ({result['solves']} solves)",
        "warm s": f"{result['warm_s']:.2f} ({result['warm_solves']})",
        "warm, same edges s": f"{result['warm_same_edges_s']:.2f}",
        "SuperLU, one solve s": f"{result['superlu_s']:.2f}",
        "rejected": str(result["rejected"]),
        "error m": "" if result["mean_m"] is None else f"{result['mean_m']:.3f} (max {result['max_m']:.2f})",
    }


def _timed(work: Any) -> tuple[Any, float]:
    begin = process_time()
    result = work()
    return result, process_time() - begin
