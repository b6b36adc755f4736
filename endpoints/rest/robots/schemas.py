"""The JSON of robots."""

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from endpoints.rest.names import Name, PluginName
from endpoints.rest.schemas import Cores, Description, Labels, Pose, RequestBody, ResponseBody, Triple, plain_json
from engine.specs.machine_settings import MOST_LABELS

Properties = Annotated[
    dict[str, Any], AfterValidator(plain_json), Field(description="Whatever else there is to say, kept as it is")
]
Parameters = Annotated[dict[str, Any], AfterValidator(plain_json), Field(description="Of the clone's nodes, by node")]


class RobotFile(RequestBody):
    """The JSON file of a robot."""

    map: Name = Field(examples=["office"])
    model: Name = "turtlebot2"
    initial_pose: Pose = Field([0.0, 0.0, 0.0])
    cores: Cores = 1.0
    base_global_planner: PluginName = "dijkstra"
    base_local_planner: PluginName = "dwa"
    parameters: Parameters = Field({})
    description: Description = ""
    properties: Properties = Field({})
    labels: Labels = Field({})


class RobotChange(RequestBody):
    """What is to change of a robot (JSON merge patch): what is left out stays, and null stands for the default."""

    map: Name | None = None
    model: Name | None = None
    initial_pose: Pose | None = None
    cores: Cores | None = None
    base_global_planner: PluginName | None = None
    base_local_planner: PluginName | None = None
    parameters: Parameters | None = None
    description: Description | None = None
    properties: Properties | None = None
    labels: Annotated[dict[Name, Name | None], Field(max_length=MOST_LABELS)] | None = None


class RobotAnswer(ResponseBody):
    """A robot."""

    id: str
    user: str
    map: str
    model: str
    initial_pose: Triple
    cores: float
    base_global_planner: str
    base_local_planner: str
    parameters: dict[str, Any]
    description: str
    properties: dict[str, Any]
    labels: dict[str, str]


class SensorAnswer(ResponseBody):
    """A link that is a sensor."""

    link: str
    kind: str = Field(description="laser, camera, depth, or what the URDF calls it")
    pose: list[float] = Field(description="x, y, z [m], roll, pitch, yaw [rad] in the base frame")


class UrdfAnswer(ResponseBody):
    """What a URDF tells of a robot; null where it cannot be told."""

    name: str
    base_frame: str
    links: int
    footprint: list[tuple[float, float]] = Field(description="Corners of the convex outline from above, x, y [m]")
    circumscribed_radius: float | None = Field(description="Of the disc around the base frame that holds it [m]")
    inscribed_radius: float | None = Field(description="Of the largest disc around the base frame within it [m]")
    height: float | None = Field(description="From the ground to its top [m]")
    max_vel_x: float | None = Field(description="What its wheels allow [m/s]")
    max_vel_theta: float | None = Field(description="What its wheels allow on the spot [rad/s]")
    sensors: list[SensorAnswer]
    warnings: list[str] = Field(description="What could not be told, and why")


class RobotDetail(RobotAnswer):
    """A robot, with what its URDF tells."""

    urdf: UrdfAnswer | None
