"""Base of the structs of messages, and structs that several messages share."""

from typing import Annotated, Literal

import msgspec

Number = Annotated[int, msgspec.Meta(ge=0)]
"""Sequence ids and the like: whole numbers from 0."""


class Fields(msgspec.Struct, rename="camel", omit_defaults=True):
    """Base of messages and their parts: names are camel case in JSON, and fields that are None are left out."""


class Point(Fields):
    """Point in the plane [m]."""

    x: float
    y: float


class ControlPoint(Point):
    """Control point of a NURBS; the weight is 1 if it is left out."""

    weight: float | None = None


class Trajectory(Fields):
    """Trajectory as a NURBS; the degree is 1 if it is left out."""

    control_points: list[ControlPoint]
    degree: int | None = None
    knot_vector: list[float] | None = None


class Reference(Fields):
    """Reference of an error or an information, such as ``nodeId``."""

    reference_key: str
    reference_value: str


class Velocity(Fields):
    """Velocity in the frame of the AGV [m/s, m/s, rad/s]."""

    vx: float | None = None
    vy: float | None = None
    omega: float | None = None


class Position(Fields):
    """Pose of an AGV in a map [m, m, rad]; ``agvPosition`` in 2.x."""

    x: float
    y: float
    theta: float
    map_id: str
    localized: bool
    localization_score: float | None = None
    deviation_range: float | None = None


class PlannedPath(Fields):
    """Path that the AGV has planned to the end of its base, in 3.0."""

    trajectory: Trajectory
    traversed_nodes: list[str] | None = None


class PathPoint(Point):
    """Point of a path with the heading [rad] and the estimated time of arrival (ISO 8601)."""

    eta: str
    theta: float | None = None


class IntermediatePath(Fields):
    """Path within the range of the AGV's sensors, in 3.0."""

    polyline: list[PathPoint]


BlockingType = Literal["NONE", "SOFT", "SINGLE", "HARD"]
