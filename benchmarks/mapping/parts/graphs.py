"""Part ``graphs``: the solver of pose graphs, on synthetic graphs and on graphs in files."""

from typing import Any

from benchmarks.harness.figures import Figure
from benchmarks.harness.parts import PartResult
from benchmarks.mapping.parts import graph_solve
from benchmarks.mapping.parts.part import SlamOptions
from ppaas.mapping.graph.g2o import parse_g2o
from ppaas.mapping.graph.solver import Robust

SYNTHETIC = ((False, Robust.NONE), (False, Robust.GRADUATED), (True, Robust.SCALING), (True, Robust.GRADUATED))
"""Solves of the synthetic graphs: whether there are false closures, and the method."""

LIMIT, WARM_LIMIT = 5.0, 0.3
"""Largest time of a solve from odometry, and from the solution by least squares or scaling [s]."""


def measure(options: SlamOptions) -> PartResult:
    """Solve each graph by each method."""
    graph_solve.warm_kernels()
    results = [
        graph_solve.measure(*graph_solve.walks(options.false if lies else 0), robust) for lies, robust in SYNTHETIC
    ]
    figures = [figure for result in results for figure in figures_of(result, options.false)]
    for file in options.graphs:
        with file.open(encoding="utf-8") as lines:
            graph = parse_g2o(lines).graph
        results.append(graph_solve.measure(file.stem, graph, None, Robust.GRADUATED))
    return PartResult(figures, list(map(graph_solve.row, results)), results)


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
