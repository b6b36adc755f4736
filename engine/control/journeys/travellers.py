"""What a robot can do on its way through a building, from its file."""

from collections.abc import Collection, Mapping
from typing import Any

from ppaas.buildings.planning.times import Traveller
from ppaas.clone.robot_body import robot_body
from ppaas.controllers.registry import CONTROLLERS
from ppaas.robot_model.description import RobotDescription
from ppaas.tasks.assignment import labels_of
from storage.records import RobotRecord

STAIRS = "stairs"
"""Property of a robot that climbs stairs: ``true`` or ``"yes"``."""

SLOWEST = 0.05
"""Speed with which a robot counts at least [m/s]."""


def traveller_of(record: RobotRecord, urdf: RobotDescription | None, avoid: Collection[str]) -> Traveller:
    """Return what a robot can do, without the lifts and ways that it is to avoid.

    Its labels are its properties, as they are for tasks. Its speed is the limit of its local planner, or of its body.

    Raises
    ------
    NotFound
        There is no such model or local planner.
    InvalidParameter
        The parameters of its footprint are invalid.
    """
    labels = labels_of(record.properties)
    speed = robot_body(record.model, urdf, record.parameters).limits.max_vel_x
    for parameters in _of_local_planner(record):
        given = parameters.get("max_vel_x")
        speed = given if isinstance(given, int | float) and given > 0.0 else speed
    climbs = labels.get(STAIRS, "").lower() in ("true", "yes")
    return Traveller(max(speed, SLOWEST), labels, climbs, frozenset(avoid))


def _of_local_planner(record: RobotRecord) -> list[Mapping[str, Any]]:
    """Return the parameters of the local planner of a robot, under each name that it has in the file."""
    driving = record.parameters.get("move_base")
    named = driving.get("base_local_planner") if isinstance(driving, Mapping) else None
    name = named if isinstance(named, str) else record.base_local_planner
    found = (record.parameters.get(spelling) for spelling in CONTROLLERS.spellings(name))
    return [each for each in found if isinstance(each, Mapping)]
