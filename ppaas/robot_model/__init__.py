"""What a robot's URDF tells of its body: footprint, height, speeds and sensors."""

from ppaas.robot_model.description import RobotDescription, SensorFrame
from ppaas.robot_model.reading import MAX_BYTES, describe

__all__ = ["MAX_BYTES", "RobotDescription", "SensorFrame", "describe"]
