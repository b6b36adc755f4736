"""The robot file: the JSON that a robot's maker writes, and the cloud keeps."""

import math
from pathlib import Path
from typing import Any

import msgspec

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D

_encoder = msgspec.json.Encoder()


class RobotFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the cloud must know of a robot.

    Parameters
    ----------
    map : str
        Id of the map it stands in.
    model : str
        What it is; ``turtlebot2``.
    initial_pose : tuple of float
        Where it starts: x, y [m], yaw [rad] in the map.
    cores : float
        Size of its container in CPU cores; decimals are parts of a core.
    base_global_planner, base_local_planner : str
        Move Base's planners, by our names or those of ROS.
    parameters : dict
        Of the clone's nodes, by node: ``{"move_base": {"controller_frequency": 10.0}}``.
    description : str
        For people.
    properties : dict
        Whatever else there is to say; the cloud keeps it and does not read it.
    labels : dict of str to str
        Those that the machine of its container must have.
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

    def __post_init__(self) -> None:
        if not self.map:
            raise ValueError("map must name a map")
        if not all(map(math.isfinite, self.initial_pose)):
            raise ValueError("initial_pose must be three finite numbers: x [m], y [m], yaw [rad]")
        if not (math.isfinite(self.cores) and self.cores > 0.0):
            raise ValueError(f"cores must be a positive number, not {self.cores}")

    @property
    def pose(self) -> Pose2D:
        """The initial pose."""
        return Pose2D(*self.initial_pose)

    def encode(self) -> bytes:
        """Return the file's JSON."""
        return _encoder.encode(self)


def parse_robot_file(text: bytes | str) -> RobotFile:
    """Read a robot file.

    Raises
    ------
    InvalidInput
        Not JSON.
    InvalidParameter
        A key is unknown, missing, or cannot be what it says; the text names it and lists the valid keys.
    """
    try:
        return msgspec.json.decode(text, type=RobotFile)
    except msgspec.ValidationError as error:
        keys = ", ".join(RobotFile.__struct_fields__)
        raise InvalidParameter(f"not a robot file: {error}; the keys are {keys}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InvalidInput(f"the robot file is not JSON: {error}") from error


def load_robot_file(path: Path) -> RobotFile:
    """Read a robot file from the disk.

    Raises
    ------
    InvalidInput
        It cannot be read.
    InvalidParameter
        See ``parse_robot_file``.
    """
    try:
        text = path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the robot file: {error}") from error
    return parse_robot_file(text)
