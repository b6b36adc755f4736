"""Parameters of ``octomap_server``, by its names in ROS 1 and ROS 2."""

import logging
from collections.abc import Mapping
from typing import Any

import msgspec

from ppaas.errors import InvalidParameter
from ppaas.mapping.volume.ground_plane import GroundFilterParameters
from ppaas.mapping.volume.parameters import VolumeParameters
from ppaas.nodes.frames import BASE_LINK, MAP
from ppaas.parameters import check_numbers

logger = logging.getLogger(__name__)

FAR = 1e6
"""Default limit of the coordinates of points: no limit [m]."""

BLOCKS = 1 << 17
"""Default of ``max_blocks``: 256 MiB."""

MOST_BLOCKS = 1 << 20
"""Largest ``max_blocks``: 2 GiB."""

ROS_1 = {
    "pointcloud_min_x": "point_cloud_min_x",
    "pointcloud_max_x": "point_cloud_max_x",
    "pointcloud_min_y": "point_cloud_min_y",
    "pointcloud_max_y": "point_cloud_max_y",
    "pointcloud_min_z": "point_cloud_min_z",
    "pointcloud_max_z": "point_cloud_max_z",
    "filter_ground": "filter_ground_plane",
}
"""Names of ROS 1, and the names of ROS 2 that are used here. ROS 1 also has a slash where ROS 2 has a dot."""

WITHOUT_EFFECT = {
    "compress_map": "octrees are always compressed",
    "incremental_2D_projection": "the projected map is always complete",
    "publish_free_space": "no markers are published",
    "use_height_map": "no markers are published",
    "color_factor": "no markers are published",
    "color": "no markers are published",
    "color_free": "no markers are published",
}
"""Parameters that are accepted without effect, and the reason."""

REFUSED: dict[str, tuple[Any, str]] = {
    "colored_map": (False, "voxels have no colours: leave it out"),
    "max_depth": (16, "maps are published at their finest resolution: set a coarser 'resolution' instead"),
    "octomap_path": ("", "a container reads no files: leave it out"),
    "octomap_file": ("", "a container reads no files: leave it out"),
}
"""Parameters of which only one value is accepted: that value, and the reason."""


class OctomapServerParameters(VolumeParameters, frozen=True):
    """Parameters of `OctomapServerNode`; the map's are in `VolumeParameters`.

    Parameters
    ----------
    frame_id : str
        Another name of the map frame.
    base_frame_id : str
        Frame of the robot's body.
    odom_frame_id, tf_prefix : str
        As in ``amcl``.
    point_cloud_min_x, point_cloud_max_x, point_cloud_min_y, point_cloud_max_y : float
        Points outside are ignored [m]: in the map frame, or with ``filter_ground_plane`` in the robot's frame.
    filter_ground_plane : bool
        Whether the floor is found in each cloud; its points make voxels free, and none occupied.
    ground_filter.distance, ground_filter.angle, ground_filter.plane_distance : float
        See `GroundFilterParameters` [m, rad, m].
    latch : bool
        Whether maps are sent to later subscribers; else only if they change afterwards.
    registration : bool
        Whether each cloud is aligned with those before, by ``small_gicp`` (extra ``mapping``).
    """

    max_blocks: int = BLOCKS
    frame_id: str = MAP
    base_frame_id: str = BASE_LINK
    odom_frame_id: str = ""
    tf_prefix: str = ""
    point_cloud_min_x: float = -FAR
    point_cloud_max_x: float = FAR
    point_cloud_min_y: float = -FAR
    point_cloud_max_y: float = FAR
    filter_ground_plane: bool = False
    ground_distance: float = msgspec.field(default=0.04, name="ground_filter.distance")
    ground_angle: float = msgspec.field(default=0.15, name="ground_filter.angle")
    ground_plane_distance: float = msgspec.field(default=0.07, name="ground_filter.plane_distance")
    latch: bool = True
    registration: bool = False

    def __post_init__(self) -> None:
        """Check the ranges."""
        self.volume()
        check_numbers(self, positive=(), signed=self.__struct_fields__)
        self.ground_filter()
        if self.max_blocks > MOST_BLOCKS:
            raise InvalidParameter(f"max_blocks must be at most {MOST_BLOCKS}, not {self.max_blocks}")
        if self.filter_ground_plane and not self.point_cloud_min_z <= 0.0 <= self.point_cloud_max_z:
            raise InvalidParameter(
                "filter_ground_plane needs the points of the floor: point_cloud_min_z must be at most 0 and "
                f"point_cloud_max_z at least 0, not {self.point_cloud_min_z} and {self.point_cloud_max_z}"
            )

    def volume(self) -> VolumeParameters:
        """Return the parameters of the map."""
        return VolumeParameters(**{name: getattr(self, name) for name in VolumeParameters.__struct_fields__})

    def ground_filter(self) -> GroundFilterParameters:
        """Return the parameters of the ground filter."""
        return GroundFilterParameters(self.ground_distance, self.ground_angle, self.ground_plane_distance)


def spelled(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters by their names in ROS 2, without those that have no effect here.

    Parameters
    ----------
    given : dict
        Parameters by their names in ROS 1 or ROS 2; groups, such as ``sensor_model``, may be dicts.

    Raises
    ------
    InvalidParameter
        A parameter is not supported; the text gives the reason.
    """
    flat: dict[str, Any] = {}
    for name, value in given.items():
        dotted = name.replace("/", ".")
        parts = value.items() if isinstance(value, dict) else [("", value)]
        flat |= {f"{dotted}.{part}".rstrip("."): one for part, one in parts}
    return {ROS_1.get(name, name): value for name, value in flat.items() if _has_effect(name, value)}


def _has_effect(name: str, value: Any) -> bool:
    reason = WITHOUT_EFFECT.get(name.partition(".")[0])
    if reason is not None:
        logger.info("parameter %r of octomap_server has no effect: %s", name, reason)
        return False
    if name not in REFUSED:
        return True
    only, why = REFUSED[name]
    if value != only:
        raise InvalidParameter(f"parameter {name!r} of octomap_server cannot be {value!r}: {why}")
    return False
