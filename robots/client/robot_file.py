"""Robot file: the JSON description of a robot that its owner uploads to the cloud."""

import json
import math
from pathlib import Path
from typing import Any

import msgspec

from ppaas.decoding import from_json
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.new_map import new_map_id
from ppaas.traffic.taking_part import with_traffic

_encoder = msgspec.json.Encoder()


class RobotFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Description of a robot.

    Parameters
    ----------
    map : str
        Id of the map that the robot is in; or ``new:`` and the id under which the map that it makes is to be published.
    model : str
        Robot model, as ``turtlebot2``.
    initial_pose : tuple of float
        Pose at the start in the frame ``map``: x, y [m], yaw [rad].
    cores : float
        Size of the robot's container [CPU cores]; fractions are allowed.
    base_global_planner, base_local_planner : str
        Move Base's global and local planner, by their PPaaS or ROS names.
    parameters : dict
        Parameters of the clone's nodes, by node: ``{"move_base": {"controller_frequency": 10.0}}``.
    description : str
        Free text for people.
    properties : dict
        Further data of any kind; the cloud stores it and does not interpret it.
    labels : dict of str to str
        Labels that the machine of the container must have.
    traffic : bool or dict, optional
        Whether the robot takes part in the traffic of its map, or the parameters for that. It is read into the section
        ``traffic`` of the parameters, and is unset from then on.
    """

    map: str
    model: str = "turtlebot2"
    initial_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cores: float = 1.0
    base_global_planner: str = "dijkstra"
    base_local_planner: str = "dwa"
    parameters: dict[str, Any] = {}
    description: str = ""
    properties: dict[str, Any] = {}
    labels: dict[str, str] = {}
    traffic: bool | dict[str, Any] | msgspec.UnsetType = msgspec.UNSET

    def __post_init__(self) -> None:
        if self.traffic is not msgspec.UNSET:
            msgspec.structs.force_setattr(self, "parameters", with_traffic(self.parameters, self.traffic))
            msgspec.structs.force_setattr(self, "traffic", msgspec.UNSET)
        if not self.map:
            raise ValueError("map must be the id of a map")
        if not all(map(math.isfinite, self.initial_pose)):
            raise ValueError("initial_pose must be three finite numbers: x [m], y [m], yaw [rad]")
        if not (math.isfinite(self.cores) and self.cores > 0.0):
            raise ValueError(f"cores must be a positive number, not {self.cores}")

    @property
    def unused(self) -> str | None:
        """Localization whose parameters are given, but not used, since the other one localizes the robot."""
        other = "grid_slam" if new_map_id(self.map) is None else "amcl"
        return other if self.parameters.get(other) else None

    def with_radius(self, radius: float | None) -> "RobotFile":
        """Return the file with a radius of the robot [m], the same file if that is None.

        Raises
        ------
        InvalidParameter
            The parameters of ``global_costmap`` are not an object.
        """
        if radius is None:
            return self
        costmap = self.parameters.get("global_costmap", {})
        if not isinstance(costmap, dict):
            raise InvalidParameter("parameters.global_costmap of the robot file must be an object")
        parameters = self.parameters | {"global_costmap": costmap | {"robot_radius": radius}}
        return msgspec.structs.replace(self, parameters=parameters)

    @property
    def pose(self) -> Pose2D:
        """The initial pose."""
        return Pose2D(*self.initial_pose)

    def encode(self) -> bytes:
        """Return the robot file as JSON."""
        return _encoder.encode(self)


def parse_robot_file(text: bytes | str) -> RobotFile:
    """Parse a robot file, bytes in any encoding of Unicode, with or without a byte-order mark.

    Raises
    ------
    InvalidInput
        The text is not JSON.
    InvalidParameter
        A key is unknown or missing, or has an invalid value; the text names it and lists the valid keys.
    """
    try:
        decoded = text.decode(json.detect_encoding(text)) if isinstance(text, bytes) else text
        return from_json(decoded, RobotFile)
    except msgspec.ValidationError as error:
        keys = ", ".join(RobotFile.__struct_fields__)
        raise InvalidParameter(f"invalid robot file: {error}; the keys are {keys}") from error
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InvalidInput(f"the robot file is not JSON: {error}") from error


def load_robot_file(path: Path) -> RobotFile:
    """Load a robot file from the disk.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    InvalidParameter
        See ``parse_robot_file``.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the robot file: {error}") from error
    return parse_robot_file(text)
