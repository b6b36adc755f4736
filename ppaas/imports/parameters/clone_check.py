"""Check of a translated robot file by the clone that it describes, on an empty map."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeVar

from ppaas.clone.assembly import build_clone
from ppaas.clone.plugins import DEFAULT_CONTROLLER, DEFAULT_PLANNER
from ppaas.costmap.map_layers import MapLayers, empty_layers
from ppaas.errors import PPaaSError, Unavailable
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.graph import Graph
from ppaas.robot_model.known_models import PLANNING_MODEL

T = TypeVar("T")

_RESOLUTION = 0.05
"""Edge of the cells of the empty map [m]."""


def refusal(file: Mapping[str, Any]) -> str | None:
    """Return why the clone of a robot file refuses it, or None. A library that is missing here is no reason.

    Parameters
    ----------
    file : mapping
        Values of JSON, as in a robot file.
    """
    try:
        build_clone(
            Graph(_no_work),
            None if new_map_id(file.get("map", "")) is not None else _layers(),
            model=file.get("model", PLANNING_MODEL),
            initial_pose=(0.0, 0.0, 0.0),
            base_global_planner=file.get("base_global_planner", DEFAULT_PLANNER),
            base_local_planner=file.get("base_local_planner", DEFAULT_CONTROLLER),
            parameters=file.get("parameters", {}),
        )
    except Unavailable:
        return None
    except PPaaSError as error:
        return str(error)
    return None


@cache
def _layers() -> MapLayers:
    return empty_layers(_RESOLUTION)


def _no_work(work: Callable[[Callable[[], bool]], T], cancelled: object, done: object) -> None:
    """Run no job: a clone that is only built plans nothing."""
