"""Requests of programs for costs and for plans of fleets, and their results; `ppaas.plans.path_service` has paths.

REST decodes the body of a request into one of these structures, and encodes the result unchanged. Its pydantic schemas
describe the same fields for OpenAPI: ``CostFile``, ``CostMatrixAnswer``, ``FleetFile`` and ``FleetPlanAnswer``. A
container is called by the ROS services ``ppaas_msgs/ComputeCosts`` and ``ppaas_msgs/ComputeFleetPlan``.
"""

from typing import Annotated, Any

import msgspec
from msgspec import Meta, Raw

from engine.specs.machine_settings import MOST_LABELS
from ppaas.plans.path_service import DEFAULT_TIMEOUT, RequestPose, Timeout
from storage.names import PATTERN

_Name = Annotated[str, Meta(pattern=rf"^{PATTERN}\Z")]
RequestLabels = Annotated[dict[_Name, _Name], Meta(max_length=MOST_LABELS)]


class CostRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Request for the costs of the cheapest paths from each start to each goal.

    Parameters
    ----------
    starts, goals : tuple of poses
        Each x, y [m] and, optionally, yaw [rad] in the frame of the map.
    timeout : float
        Time limit of the whole request [s].
    labels : dict of str to str
        Labels that the machine of the container must have.
    parameters : dict
        ``allow_unknown`` and parameters of the global costmap that differ from the usual ones, by name.
    """

    starts: tuple[RequestPose, ...]
    goals: tuple[RequestPose, ...]
    timeout: Timeout = DEFAULT_TIMEOUT
    labels: RequestLabels = {}
    parameters: dict[str, Any] = {}


class CostAnswer(msgspec.Struct, frozen=True):
    """Costs, and the container that computed them. Encoded as JSON, it is the response of REST.

    Parameters
    ----------
    costs : Raw
        JSON: a row for each start with a number for each goal, null if there is no path, as the container wrote it.
    seconds : float
        Computing time [s].
    container : str
        Id of the container that computed them.
    pid : int
        Process id of this container.
    map, version : str
        Map version that they were computed on.
    """

    costs: Raw
    seconds: float
    container: str
    pid: int
    map: str
    version: str


DEFAULT_MARGIN, DEFAULT_SPEED = 0.05, 0.5
"""Distance by which robots may stray from their paths [m], and their speed [m/s], of a request that names none."""


class FleetRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Request for paths of many robots that keep out of each other's way.

    Parameters
    ----------
    starts, goals : tuple of poses
        One each a robot: x, y [m] and, optionally, yaw [rad] in the frame of the map.
    radius, margin : float
        Radius of the robots, and the distance by which they may stray from their paths [m].
    speed : float
        Speed of the robots [m/s], from which the duration of a step follows.
    speeds : tuple of float, optional
        Speed of each robot [m/s], instead of ``speed``.
    turn_seconds : float
        Time of a quarter turn [s].
    seconds : float
        Time in which the first plan is improved [s].
    seed : int
        Seed of the random numbers.
    timeout : float
        Time limit of the whole request [s].
    labels : dict of str to str
        Labels that the machine of the container must have.
    """

    starts: tuple[RequestPose, ...]
    goals: tuple[RequestPose, ...]
    radius: Annotated[float, Meta(gt=0.0)]
    margin: Annotated[float, Meta(ge=0.0)] = DEFAULT_MARGIN
    speed: Annotated[float, Meta(gt=0.0)] = DEFAULT_SPEED
    speeds: tuple[Annotated[float, Meta(gt=0.0)], ...] | None = None
    turn_seconds: Annotated[float, Meta(ge=0.0)] = 0.0
    seconds: Annotated[float, Meta(ge=0.0)] = 0.0
    seed: Annotated[int, Meta(ge=0)] = 0
    timeout: Timeout = DEFAULT_TIMEOUT
    labels: RequestLabels = {}


class FleetAnswer(msgspec.Struct, frozen=True):
    """Plan of a fleet, and the container that made it. Encoded as JSON, it is the response of REST.

    Parameters
    ----------
    paths : Raw
        JSON: a list for each robot with the x, y [m] of a cell's centre at each step, as the container wrote it.
    times : Raw
        JSON: a list for each robot with the time at which it reaches each of these [s], as the container wrote it.
    spacing : float
        Distance of the centres of neighbouring cells [m].
    step_seconds : float
        Duration of a step of the slowest robot [s].
    cost : int
        Sum of the last arrivals of all robots at their goals [steps].
    bound : int
        Sum of the lengths of shortest paths, below which no cost is [steps].
    makespan : int
        Last arrival of all [steps].
    turns : int
        Number of quarter turns of all robots.
    seconds : float
        Computing time [s].
    container : str
        Id of the container that planned it.
    pid : int
        Process id of this container.
    map, version : str
        Map version that it was planned on.
    """

    paths: Raw
    times: Raw
    spacing: float
    step_seconds: float
    cost: int
    bound: int
    makespan: int
    turns: int
    seconds: float
    container: str
    pid: int
    map: str
    version: str
