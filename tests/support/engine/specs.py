"""Specifications of test containers."""

from typing import Any

from engine.master.places import PlaceRequest
from engine.specs.containers import ContainerSpec, MapVersion, RobotConfig
from ppaas.people.settings import PeopleSettings

HOUSE = MapVersion("house", "v1")


def robot_config(robot: str = "tb1", **fields: Any) -> RobotConfig:
    """Return the configuration of a robot."""
    given = {"model": "turtlebot2", "initial_pose": (0.0, 0.0, 0.0)}
    planners = {"base_global_planner": "dijkstra", "base_local_planner": "dwa"}
    return RobotConfig(robot, **(given | planners | fields))


def robot_spec(
    container: str = "c1", user: str = "ann", robot: str = "tb1", version: MapVersion = HOUSE, cores: float = 1.0
) -> ContainerSpec:
    """Return a container for the clone of a robot."""
    return ContainerSpec(container, user, version, cores, robot_config(robot))


def mapping_spec(container: str = "m1", user: str = "ann", robot: str = "tb1") -> ContainerSpec:
    """Return a container for the clone of a robot that makes a new map."""
    return ContainerSpec(container, user, MapVersion("new:office-2", ""), 1.0, robot_config(robot, new_map="office-2"))


def planning_spec(container: str = "p1", user: str = "ann", version: MapVersion = HOUSE) -> ContainerSpec:
    """Return a container that only plans."""
    return ContainerSpec(container, user, version, 1.0)


def coordinator_spec(container: str = "k1", user: str = "ann", version: MapVersion = HOUSE) -> ContainerSpec:
    """Return a container with the people coordinator of a user's robots on a map."""
    return ContainerSpec(container, user, version, 0.25, people=PeopleSettings())


def coordinator_request(user: str = "ann", version: MapVersion = HOUSE, cores: float = 0.25) -> PlaceRequest:
    """Return a request for a place with the people coordinator of a user's robots on a map."""
    return PlaceRequest(user, version, cores, group_node="people")


def traffic_spec(container: str = "t1", user: str = "ann", version: MapVersion = HOUSE) -> ContainerSpec:
    """Return a container with the traffic node of a user's robots on a map."""
    return ContainerSpec(container, user, version, 0.25, traffic=True)


def traffic_request(user: str = "ann", version: MapVersion = HOUSE, cores: float = 0.25) -> PlaceRequest:
    """Return a request for a place with the traffic node of a user's robots on a map."""
    return PlaceRequest(user, version, cores, group_node="traffic")


def robot_request(
    robot: str = "tb1",
    user: str = "ann",
    version: MapVersion = HOUSE,
    cores: float = 1.0,
    *,
    labels: dict[str, str] | None = None,
    **fields: Any,
) -> PlaceRequest:
    """Return a request for a place with the clone of a robot."""
    return PlaceRequest(user, version, cores, robot_config(robot, **fields), labels=labels or {})
