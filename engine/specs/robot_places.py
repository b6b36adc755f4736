"""Places of robots, as they are asked for at connecting: the configuration of the clone, and versions of maps."""

from typing import NamedTuple

from msgspec.structs import replace

from engine.specs.containers import MapVersion, RobotConfig
from engine.specs.robot_maps import continued_map, joint_map_owner, mask_heads
from ppaas.errors import NotFound, NotPermitted
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.map_server.costmap_filters import check_no_masks
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.robot_model.describe import describe
from ppaas.traffic.taking_part import on_map_with_traffic
from storage.map_port import no_grid
from storage.ports import MapStore, RobotStore
from storage.records import MapRecord, RobotRecord
from storage.versions import OCTOMAP, YAML


class RobotPlace(NamedTuple):
    """Place that a robot needs.

    Parameters
    ----------
    map : MapVersion
        Its map; the name in the robot file, without a version, if the robot makes a new map.
    config : RobotConfig
        Configuration of its clone.
    heads : list of MapRecord
        Current versions of its masks and its map, the map last; none if it makes a new map.
    """

    map: MapVersion
    config: RobotConfig
    heads: list[MapRecord]


def robot_place(maps: MapStore, record: RobotRecord, urdf: bytes | None) -> RobotPlace:
    """Return the place that a robot needs. May block.

    Parameters
    ----------
    maps : MapStore
        Store of its maps.
    record : RobotRecord
        The robot.
    urdf : bytes, optional
        Its URDF.

    Raises
    ------
    NotFound
        Its map was deleted.
    NotPermitted
        Its user may not read the map.
    InvalidMap
        The map has no grid.
    InvalidParameter
        A mask or the map that it continues does not exist, or has not the file for it; or a robot with a new map has a
        mask.
    """
    config, user = robot_config(record, urdf), record.user
    if config.new_map:
        check_no_masks(config.parameters)
        continued = continued_map(maps, user, config.parameters)
        owner = joint_map_owner(maps, user, config.new_map)
        return RobotPlace(MapVersion(record.map, ""), replace(config, continued=continued, map_owner=owner), [])
    head = maps.map_head(record.map)
    check_readable(head, user)
    if YAML not in head.present.files:
        raise no_grid(head)
    heads = mask_heads(maps, user, config.parameters)
    masks = {name: MapVersion(mask.id, mask.version) for name, mask in heads.items()}
    config = replace(config, masks=masks, in_space=OCTOMAP in head.present.files)
    if head.traffic:
        config = replace(config, parameters=on_map_with_traffic(config.parameters))
    return RobotPlace(MapVersion(head.id, head.version), config, [*heads.values(), head])


def urdf_of(store: RobotStore, user: str, robot: str) -> bytes | None:
    """Return the URDF of a robot, or None if it has none. May block."""
    try:
        return store.urdf(user, robot)
    except NotFound:
        return None


def robot_config(record: RobotRecord, urdf: bytes | None = None) -> RobotConfig:
    """Return the configuration of a robot for its clone."""
    return RobotConfig(
        id=record.id,
        model=record.model,
        initial_pose=record.initial_pose,
        base_global_planner=record.base_global_planner,
        base_local_planner=record.base_local_planner,
        parameters=record.parameters,
        urdf=None if urdf is None else describe(urdf),
        urdf_text=b"" if urdf is None else UrdfText.of(urdf).compressed,
        new_map=new_map_id(record.map) or "",
    )


def check_readable(version: MapRecord, user: str) -> None:
    """Raise ``NotPermitted`` if a user may not read a map."""
    if not version.readable_by(user):
        raise NotPermitted(f"map {version.id!r} is not shared with {user!r}")
