"""Requests of programs for plans of fleets, and their results.

As in `path_requests`, REST decodes the body of a request into one of these structures, and encodes the result
unchanged; ``FleetFile`` and ``FleetPlanAnswer`` describe them for OpenAPI. A container is called by the ROS service
``ppaas_msgs/ComputeFleetPlan``.
"""

from typing import Annotated

import msgspec
from msgspec import Meta, Raw

from engine.service.planning.path_requests import DEFAULT_TIMEOUT, RequestLabels, RequestPose, Timeout

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
