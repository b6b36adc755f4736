"""Finish of a mapping that a robot made while it drove: its last loops, and the joint refinement."""

from collections.abc import Callable

from ppaas.mapping.closures.agreement import GRADUATED
from ppaas.mapping.closures.parameters import ClosureParameters
from ppaas.mapping.graph.counterweights import measured_odometry
from ppaas.mapping.graph.solver import GraphSolver
from ppaas.mapping.pipeline.graph_mapper import CLOSURES, GraphMapper
from ppaas.mapping.refinement import refine
from ppaas.mapping.serialization.mapping import Mapping


def finish_mapping(
    mapping: Mapping,
    closures: ClosureParameters | None = CLOSURES,
    done: Callable[[str, float], None] | None = None,
) -> Mapping:
    """Finish a mapping as `map_log` does at the end of a log: search for missing loops, solve, and refine.

    Parameters
    ----------
    mapping : Mapping
        Taken over.
    closures : ClosureParameters or None
        Of the search for loop closures; None to close no loops.
    done : callable, optional
        Called with the name of the part that is done, ``loops`` or ``alignment``, and how much of it is, from 0 to 1.

    Raises
    ------
    InvalidGraph
        The normal equations are not positive definite.
    """
    frames, graph, report = mapping.frames, mapping.graph, done or _ignore
    if closures is None:
        mapping.move(GraphSolver().solve(graph, GRADUATED).poses)
    else:
        report("loops", 0.0)
        GraphMapper.of(mapping, closures).finish(lambda searched, of: report("loops", searched / of))
    report("alignment", 0.0)
    mapping.move(refine(frames, graph.poses, measured_odometry(graph.edges)).poses)
    return Mapping(frames, graph, mapping.laser_frame)


def _ignore(_part: str, _done: float) -> None:
    """Report nothing."""
