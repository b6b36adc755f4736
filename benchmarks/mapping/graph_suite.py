"""Solver of pose graphs, measured on synthetic graphs and on graphs in files."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.mapping import graph_solve
from ppaas.errors import InvalidInput
from ppaas.mapping.graph.g2o import parse_g2o
from ppaas.mapping.graph.solver import Robust

SYNTHETIC = ((False, Robust.NONE), (False, Robust.GRADUATED), (True, Robust.SCALING), (True, Robust.GRADUATED))
"""Solves of the synthetic graphs: whether there are false closures, and the method."""


def measure(files: Sequence[Path], false: int, done: Callable[[], None]) -> list[dict[str, Any]]:
    """Return the results of each graph and method.

    Parameters
    ----------
    files : sequence of Path
        Graphs in the format of g2o.
    false : int
        Number of false closures of the second synthetic graph.
    done : callable
        Called after each solve.

    Raises
    ------
    InvalidInput
        There is no such file.
    """
    missing = [str(file) for file in files if not file.is_file()]
    if missing:
        raise InvalidInput(f"there is no file {missing[0]}")
    graph_solve.warm_kernels()
    results = []
    for lies, robust in SYNTHETIC:
        results.append(graph_solve.measure(*graph_solve.walks(false if lies else 0), robust))
        done()
    for file in files:
        with file.open(encoding="utf-8") as lines:
            graph = parse_g2o(lines)
        results.append(graph_solve.measure(file.stem, graph, None, Robust.GRADUATED))
        done()
    return results
