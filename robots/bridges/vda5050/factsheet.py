"""Factsheet of a robot, from its robot file and its model."""

import math
from collections.abc import Iterable
from typing import Any

from ppaas.robot_model.known_models import RobotModel, robot_model
from ppaas.wire.vda5050.agv.action_book import INSTANT_2, INSTANT_3
from ppaas.wire.vda5050.agv.order_check import MAX_ACTIONS, MAX_NODES
from ppaas.wire.vda5050.agv.zone_book import MAX_ZONES, SUPPORTED
from ppaas.wire.vda5050.codec import MAX_PAYLOAD
from ppaas.wire.vda5050.factsheets import (
    AgvAction,
    AgvActionParameter,
    Envelope2d,
    Factsheet,
    MobileRobotGeometry,
    OptionalParameter,
    PhysicalParameters,
    ProtocolFeatures,
    ProtocolLimits,
    StringLengths,
    Timing,
    TypeSpecification,
)
from ppaas.wire.vda5050.fields import Point
from robots.bridges.vda5050.agv_options import AgvOptions

CORNERS = 16
"""Number of corners of a circular outline."""

UNKNOWN_HEIGHT = 0.0
"""Height of a robot whose model has none [m]."""

MIN_INTERVAL = 0.2
"""Least time between two states [s]."""

PARAMETERS = {
    "initPosition": ("x", "y", "theta", "mapId", "lastNodeId"),
    "initializePosition": ("x", "y", "theta", "mapId", "lastNodeId"),
    "enableZoneSet": ("zoneSetId",),
    "deleteZoneSet": ("zoneSetId",),
    "cancelOrder": ("orderId",),
}
"""Parameters of instant actions."""

OPTIONAL = frozenset({"lastNodeId", "orderId"})
NUMBERS = frozenset({"x", "y", "theta"})


def factsheet_of(robot: dict[str, Any], options: AgvOptions) -> Factsheet:
    """Return the factsheet of a robot as REST describes it.

    Raises
    ------
    NotFound
        Its model is unknown.
    """
    model = robot_model(str(robot["model"]))
    outline = model.footprint or _circle(model.robot_radius)
    return Factsheet(
        type_specification=TypeSpecification(
            series_name=model.name,
            series_description=str(robot.get("description") or "") or None,
            mobile_robot_kinematics="DIFFERENTIAL",
            mobile_robot_class="CARRIER",
            maximum_load_mass=0.0,
            localization_types=["NATURAL"],
            navigation_types=["FREELY_NAVIGATING"],
            supported_zones=list(SUPPORTED) if options.zones else [],
        ),
        physical_parameters=_physical(model, outline),
        protocol_limits=_limits(options),
        protocol_features=ProtocolFeatures(
            optional_parameters=[
                OptionalParameter(parameter="order.nodes.nodePosition", support="REQUIRED"),
                OptionalParameter(parameter="order.nodes.nodePosition.theta", support="SUPPORTED"),
                OptionalParameter(parameter="order.nodes.nodePosition.allowedDeviationXY", support="SUPPORTED"),
                OptionalParameter(parameter=f"order.edges.{_speed_name(options)}", support="SUPPORTED"),
            ],
            mobile_robot_actions=_actions(options),
        ),
        mobile_robot_geometry=MobileRobotGeometry(
            envelopes2d=[Envelope2d(envelope2d_id="footprint", vertices=[Point(x=x, y=y) for x, y in outline])]
        ),
        load_specification={},
    )


def _speed_name(options: AgvOptions) -> str:
    return "maximumSpeed" if options.version.major >= 3 else "maxSpeed"


def _physical(model: RobotModel, outline: Iterable[tuple[float, float]]) -> PhysicalParameters:
    xs, ys = zip(*outline, strict=True)
    height = model.height if model.height is not None else UNKNOWN_HEIGHT
    return PhysicalParameters(
        minimum_speed=max(model.limits.min_vel_x, 0.0),
        maximum_speed=model.limits.max_vel_x,
        maximum_acceleration=model.limits.acc_lim_x,
        maximum_deceleration=model.limits.acc_lim_x,
        minimum_height=height,
        maximum_height=height,
        width=max(ys) - min(ys),
        length=max(xs) - min(xs),
        maximum_angular_speed=model.limits.max_vel_theta,
    )


def _limits(options: AgvOptions) -> ProtocolLimits:
    return ProtocolLimits(
        maximum_string_lengths=StringLengths(maximum_message_length=MAX_PAYLOAD, id_numerical_only=False),
        maximum_array_lengths={
            "order.nodes": MAX_NODES,
            "order.edges": MAX_NODES - 1,
            "node.actions": MAX_ACTIONS,
            "edge.actions": MAX_ACTIONS,
            **({"zoneSet.zones": MAX_ZONES} if options.version.major >= 3 else {}),
        },
        timing=Timing(
            minimum_order_interval=0.0,
            minimum_state_interval=MIN_INTERVAL,
            default_state_interval=options.state_interval,
            visualization_interval=options.visualization_interval or None,
        ),
    )


def _actions(options: AgvOptions) -> list[AgvAction]:
    instant = [
        AgvAction(
            action_type=name,
            action_scopes=["INSTANT"],
            action_parameters=[_parameter(key) for key in PARAMETERS.get(name, ())] or None,
            blocking_types=["NONE"],
            pause_allowed=False,
            cancel_allowed=False,
        )
        for name in (INSTANT_3 if options.version.major >= 3 else INSTANT_2)
    ]
    offered = [
        AgvAction(
            action_type=name,
            action_scopes=["INSTANT", "NODE", "EDGE"],
            action_description=f"service {service} of the robot",
            blocking_types=["NONE", "SOFT", "HARD"],
            pause_allowed=False,
            cancel_allowed=False,
        )
        for name, service in options.services.items()
    ]
    return instant + offered


def _parameter(key: str) -> AgvActionParameter:
    return AgvActionParameter(
        key=key, value_data_type="NUMBER" if key in NUMBERS else "STRING", is_optional=key in OPTIONAL
    )


def _circle(radius: float) -> tuple[tuple[float, float], ...]:
    angles = [2 * math.pi * index / CORNERS for index in range(CORNERS)]
    return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)
