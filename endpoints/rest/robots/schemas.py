"""JSON schemas of robots."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, StrictBool, model_validator

from endpoints.rest.names import Name, PluginName, RobotMap
from endpoints.rest.robots.robot_status import RobotStatus
from endpoints.rest.schemas import (
    Cores,
    Description,
    FreeForm,
    Labels,
    Pose,
    RequestBody,
    ResponseBody,
    Triple,
    plain_json,
)
from endpoints.rest.strict_json import showable
from endpoints.sharing.access import DESCRIPTION, PARAMETERS, in_words
from engine.specs.machine_settings import MOST_LABELS
from ppaas.traffic.taking_part import with_traffic
from storage.sharing_records import ShareRole

Properties = Annotated[FreeForm, Field(description="Any other properties, stored unchanged")]
Parameters = Annotated[FreeForm, Field(description="Parameters of the clone's nodes, by node")]

Traffic = Annotated[
    StrictBool | FreeForm,
    Field(
        union_mode="left_to_right",
        description="Whether the robot takes part in the traffic of its map, or the parameters for that; in place of "
        "`parameters.traffic`, which a robot that takes part has",
    ),
]

Stored = Annotated[dict[str, Any], BeforeValidator(showable)]


class RobotFile(RequestBody):
    """Robot file."""

    map: RobotMap = Field(
        examples=["office"],
        description="Id of a published map; or `new:` and the id under which the map that the robot makes is to be "
        "published",
    )
    model: Name = "turtlebot2"
    initial_pose: Pose = Field([0.0, 0.0, 0.0])
    cores: Cores = 1.0
    base_global_planner: PluginName = "dijkstra"
    base_local_planner: PluginName = "dwa"
    parameters: Parameters = Field({})
    description: Description = ""
    properties: Properties = Field({})
    labels: Labels = Field({})
    traffic: Traffic | None = Field(None, exclude=True)

    @model_validator(mode="after")
    def _with_traffic(self) -> "RobotFile":
        """Read ``traffic`` into the parameters, which alone are stored."""
        if self.traffic is not None:
            self.parameters, self.traffic = plain_json(with_traffic(self.parameters, self.traffic)), None
        return self


STORED_FIELDS = tuple(name for name, field in RobotFile.model_fields.items() if not field.exclude)
"""Fields of a robot file that are in its record."""


class RobotChange(RequestBody):
    """Changes of a robot (JSON merge patch): omitted fields stay unchanged, null restores the default."""

    map: RobotMap | None = None
    model: Name | None = None
    initial_pose: Pose | None = None
    cores: Cores | None = None
    base_global_planner: PluginName | None = None
    base_local_planner: PluginName | None = None
    parameters: Parameters | None = None
    description: Description | None = None
    properties: Properties | None = None
    labels: Annotated[dict[Name, Name | None], Field(max_length=MOST_LABELS)] | None = None
    traffic: Traffic | None = None


Stopped = Annotated[
    str | None, Field(description="Who has stopped the robot, when and why, in words; null if nobody has")
]


class RobotAnswer(ResponseBody):
    """Robot of the caller, or one that is shared with the caller."""

    id: str
    user: str = Field(description="Owner. For other users, the address of the robot is `OWNER:ID`")
    role: ShareRole = Field("administer", description="Role of the caller on the robot")
    map: str
    model: str
    initial_pose: Triple
    cores: float
    base_global_planner: str
    base_local_planner: str
    parameters: Stored | None = Field(
        description=f"Null if the caller may not call {in_words(PARAMETERS)} on the robot"
    )
    description: str
    properties: Stored
    labels: dict[str, str]


class RobotListed(RobotAnswer, RobotStatus):
    """Robot in a list, with its state."""

    stopped: Stopped


class SensorAnswer(ResponseBody):
    """Sensor of a robot: a link of its URDF."""

    link: str
    kind: str = Field(description="laser, camera, depth, or the type in the URDF")
    pose: list[float] = Field(description="x, y, z [m], roll, pitch, yaw [rad] in the base frame")


class UrdfAnswer(ResponseBody):
    """Properties of a robot from its URDF; null if unknown."""

    name: str
    base_frame: str
    links: int
    footprint: list[tuple[float, float]] = Field(description="Corners of the convex outline seen from above, x, y [m]")
    circumscribed_radius: float | None = Field(
        description="Radius of the smallest disc around the base frame that contains it [m]"
    )
    inscribed_radius: float | None = Field(description="Radius of the largest disc around the base frame inside it [m]")
    height: float | None = Field(description="Height above the ground [m]")
    max_vel_x: float | None = Field(description="Maximum linear velocity of its wheels [m/s]")
    max_vel_theta: float | None = Field(
        description="Maximum angular velocity of its wheels when turning in place [rad/s]"
    )
    sensors: list[SensorAnswer]
    warnings: list[str] = Field(description="Properties that could not be determined, and why")


class RobotDetail(RobotAnswer):
    """Robot, with the properties from its URDF."""

    urdf: UrdfAnswer | None = Field(
        description=f"Null without a URDF, or if the caller may not subscribe to {in_words(DESCRIPTION)}"
    )
    stopped: Stopped
