"""Builds the clone of a robot on an empty map, as its container would, and reports what that refuses."""

import logging
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from msgspec.structs import replace

from engine.container.current_map import CurrentMap
from engine.container.graph_building import build_graph
from engine.container.shared_plans import PlanningNotes, SharedPlans
from engine.specs.clone_to_check import DEFAULTS, CloneToCheck
from engine.specs.containers import ContainerSpec, Launch, MapVersion, RobotConfig
from engine.specs.layer_files import write_layers
from ppaas.clock import monotonic
from ppaas.clone.file_faults import all_faults
from ppaas.controllers.registry import CONTROLLERS
from ppaas.costmap.map_layers import empty_layers
from ppaas.errors import NotFound, PPaaSError, RobotFault, Unavailable
from ppaas.nodes.graph import Graph
from ppaas.planners.registry import PLANNERS
from ppaas.plans.reuse.time_estimates import Times
from ppaas.plugins import PluginRegistry, permitted
from ppaas.recoveries.registry import RECOVERIES
from ppaas.thread_budget import one_thread

logger = logging.getLogger(__name__)

T = TypeVar("T")

SEARCH = 5.0
"""Time for the search for further faults of a file [s]."""

_MAP = MapVersion("map", "1")


class CloneCheck:
    """Check of clones.

    Parameters
    ----------
    folder : Path
        Folder for the layers of empty maps, which exists; nothing is left in it after a check.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def faults(self, clone: CloneToCheck) -> list[RobotFault]:
        """Return all faults of a robot file that its clone refuses; none if it is built.

        A failure that is no error for users is logged, and does not count: its container reports it.
        """
        given = {name: getattr(clone.robot, name) for name in DEFAULTS}
        bare = replace(clone.robot, continued=None, urdf_text=b"", **DEFAULTS)
        with TemporaryDirectory(prefix="check-", dir=self._folder) as name:
            layers, end = Path(name), monotonic() + SEARCH
            write_empty_map(layers, clone.resolution)
            return all_faults(given, lambda file: _refusal_of(replace(bare, **file), layers), lambda: monotonic() < end)


def write_empty_map(folder: Path, resolution: float) -> None:
    """Write the layers of a map without obstacles, whose cells have an edge of ``resolution`` [m]."""
    write_layers(folder, empty_layers(resolution), 0.0)


def _refusal_of(robot: RobotConfig, layers: Path) -> str | None:
    try:
        _build(robot, layers)
    except NotFound as error:
        return None if _may_be_elsewhere(error) else str(error)
    except Unavailable as error:  # a library is missing here, which the machine of the container may have
        logger.warning("the clone of robot %r cannot be checked: %s", robot.id, error)
    except PPaaSError as error:
        return str(error)
    except Exception:
        logger.exception("the check of the clone of robot %r failed", robot.id)
    return None


def _build(robot: RobotConfig, layers: Path) -> None:
    spec = ContainerSpec("check", "check", _MAP, 1.0, robot)
    launch = Launch(spec, str(layers), "", "", "", (), 1)
    times = Times()
    current = CurrentMap(launch, SharedPlans(times, _nothing), times, PlanningNotes(times))
    build_graph(Graph(_no_work), launch, one_thread, current)


def _nothing() -> None:
    """Do nothing: no job runs."""


def _no_work(work: Callable[[Callable[[], bool]], T], cancelled: object, done: object) -> None:
    """Run no job: a clone that is only built plans nothing and loads no kernels in advance."""


def _may_be_elsewhere(error: NotFound) -> bool:
    """Return whether an unknown plug-in is one that is allowed, and so may be installed where containers run."""
    registries: tuple[PluginRegistry[Any], ...] = PLANNERS, CONTROLLERS, RECOVERIES
    return any(registry.full_name(error.name) in (permitted() or ()) for registry in registries)
