"""Sensors among the links of a robot, with their poses."""

import math
import re
from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element

from ppaas.robot_model.description import SensorFrame
from ppaas.transforms.planar import LARGEST_TILT, USEFUL_TILT
from ppaas.transforms.spatial import Rigid

MAX_SENSORS = 100

LASER = "laser"

_TYPES = {
    "ray": LASER, "gpu_ray": LASER, "lidar": LASER, "gpu_lidar": LASER,
    "camera": "camera", "multicamera": "camera", "wideanglecamera": "camera",
    "depth": "depth", "depth_camera": "depth", "rgbd_camera": "depth", "rgbd": "depth",
}  # fmt: skip
"""Kind of sensor by its type in Gazebo's or URDF's tags."""

_WORDS = (
    (LASER, re.compile(r"laser|lidar|hokuyo|velodyne|(?:^|[^a-z])scan(?:[^a-z]|$)")),
    ("depth", re.compile(r"depth|kinect|realsense|rgbd|(?:^|[^a-z])astra(?:[^a-z]|$)")),
    ("camera", re.compile(r"camera|(?:^|[^a-z])(?:cam|rgb)(?:[^a-z]|$)")),
)


def sensor_frames(root: Element, poses: Mapping[str, Rigid]) -> tuple[SensorFrame, ...]:
    """Return the links that are sensors by a ``<sensor>`` tag of URDF or Gazebo, or else by their name.

    Parameters
    ----------
    root : Element
        Root element of the URDF.
    poses : mapping of str to Rigid
        Pose of each link in the base frame.
    """
    kinds = {link: kind for link in poses if (kind := _by_name(link)) is not None}
    kinds |= {link: kind for link, kind in _by_tag(root) if link in poses}
    found = [SensorFrame(link, kinds[link], _numbers(poses[link])) for link in poses if link in kinds]
    return tuple(found[:MAX_SENSORS])


def tilted(sensors: Iterable[SensorFrame], poses: Mapping[str, Rigid]) -> list[str]:
    """Return a warning for each laser that is tilted so far that a robot hardly sees walls by it."""
    lasers = [(sensor.link, poses[sensor.link].tilt) for sensor in sensors if sensor.kind == LASER]
    return [
        f"laser {link!a} is tilted by {math.degrees(tilt):.0f}°: "
        + (
            "its scans are refused"
            if tilt > LARGEST_TILT
            else "its beams are projected to the ground, but most of them end on the floor or above the robot"
        )
        for link, tilt in lasers
        if tilt > USEFUL_TILT
    ]


def _by_name(link: str) -> str | None:
    return next((kind for kind, words in _WORDS if words.search(link.lower())), None)


def _by_tag(root: Element) -> list[tuple[str, str]]:
    """Return links and their kinds by ``<gazebo reference=LINK><sensor type=…>`` and ``<sensor><parent link=LINK>``."""
    found = []
    for gazebo in root.findall("gazebo"):
        for sensor in gazebo.findall("sensor"):
            found.append((gazebo.get("reference", ""), _kind(sensor.get("type", ""))))
    for sensor in root.findall("sensor"):
        parent = sensor.find("parent")
        types = [child.tag for child in sensor if child.tag in _TYPES] + [sensor.get("type", "")]
        found.append(("" if parent is None else parent.get("link", ""), _kind(types[0])))
    return found


def _kind(name: str) -> str:
    return _TYPES.get(name, name[:64] or "other")


def _numbers(pose: Rigid) -> tuple[float, float, float, float, float, float]:
    """Return x, y, z [m], roll, pitch and yaw [rad]."""
    _, _, _, x, y, z, w = pose
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    px, py, pz, roll, pitch, yaw = (round(number, 6) + 0.0 for number in (*pose[:3], roll, pitch, yaw))
    return px, py, pz, roll, pitch, yaw
