"""Factsheet of an AGV: what it is, what it can do, and the limits of its messages."""

from typing import Any, Literal

from msgspec import field

from ppaas.wire.vda5050.fields import BlockingType, Fields, Point


class TypeSpecification(Fields):
    """Class and capabilities of an AGV. Masses are in kg."""

    series_name: str
    mobile_robot_kinematics: str
    mobile_robot_class: str
    maximum_load_mass: float
    localization_types: list[str]
    navigation_types: list[str]
    series_description: str | None = None
    supported_zones: list[str] | None = None


class PhysicalParameters(Fields):
    """Speeds [m/s, rad/s], accelerations [m/s²] and sizes [m]."""

    minimum_speed: float
    maximum_speed: float
    maximum_acceleration: float
    maximum_deceleration: float
    maximum_height: float
    width: float
    length: float
    minimum_height: float | None = None
    minimum_angular_speed: float | None = None
    maximum_angular_speed: float | None = None


class StringLengths(Fields):
    """Largest lengths of texts [characters]; none is a limit where it is left out."""

    maximum_message_length: int | None = None
    maximum_topic_serial_length: int | None = None
    maximum_topic_element_length: int | None = None
    maximum_id_length: int | None = None
    id_numerical_only: bool | None = None
    maximum_load_id_length: int | None = None


class Timing(Fields):
    """Intervals of messages [s]."""

    minimum_order_interval: float
    minimum_state_interval: float
    default_state_interval: float | None = None
    visualization_interval: float | None = None


class ProtocolLimits(Fields):
    """Limits of messages. Keys of arrays are named as in the specification, such as ``order.nodes``."""

    maximum_string_lengths: StringLengths
    maximum_array_lengths: dict[str, int]
    timing: Timing


class OptionalParameter(Fields):
    """Optional parameter that the AGV supports or requires."""

    parameter: str
    support: Literal["SUPPORTED", "REQUIRED"]
    description: str | None = None


class AgvActionParameter(Fields):
    """Parameter of an action that the AGV knows."""

    key: str
    value_data_type: str
    description: str | None = None
    is_optional: bool | None = None


class AgvAction(Fields):
    """Action that the AGV knows."""

    action_type: str
    action_scopes: list[str]
    action_description: str | None = None
    action_parameters: list[AgvActionParameter] | None = None
    action_result: str | None = None
    blocking_types: list[BlockingType] | None = None
    pause_allowed: bool | None = None
    cancel_allowed: bool | None = None


class ProtocolFeatures(Fields):
    """Features of the protocol that the AGV has."""

    optional_parameters: list[OptionalParameter]
    mobile_robot_actions: list[AgvAction]


class WheelPosition(Point):
    """Position of a wheel in the frame of the AGV [m, m, rad]."""

    theta: float | None = None


class WheelDefinition(Fields):
    """Wheel of an AGV [m]."""

    type: str
    is_active_driven: bool
    is_active_steered: bool
    position: WheelPosition
    diameter: float
    width: float
    center_displacement: float | None = None
    constraints: str | None = None


class Envelope2d(Fields):
    """Outline of the AGV in its own frame [m]."""

    envelope2d_id: str = field(name="envelope2dId")
    vertices: list[Point]
    description: str | None = None


class MobileRobotGeometry(Fields):
    """Wheels and outlines of an AGV."""

    wheel_definitions: list[WheelDefinition] | None = None
    envelopes2d: list[Envelope2d] | None = None
    envelopes3d: list[dict[str, Any]] | None = None


class Factsheet(Fields):
    """Factsheet of an AGV.

    The schemas require all parts but the configuration; AGVs leave out others as well, and vda-5050-lib leaves out all.
    """

    type_specification: TypeSpecification | None = None
    physical_parameters: PhysicalParameters | None = None
    protocol_limits: ProtocolLimits | None = None
    protocol_features: ProtocolFeatures | None = None
    mobile_robot_geometry: MobileRobotGeometry | None = None
    load_specification: dict[str, Any] | None = None
    mobile_robot_configuration: dict[str, Any] | None = None
