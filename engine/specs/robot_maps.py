"""Maps beside the one that a robot drives on: the map that it continues, masks of costmap filters, and joint maps."""

from collections.abc import Mapping
from typing import Any

from engine.specs.containers import MapVersion
from ppaas.errors import InvalidParameter, NotFound
from ppaas.nodes.map_server.costmap_filters import filter_masks
from storage.ports import MapStore
from storage.records import MapRecord
from storage.versions import POSEGRAPH, YAML

NAME = "map_file_name"
"""Parameter of ``grid_slam``."""


def continued_map(maps: MapStore, user: str, parameters: Mapping[str, Any]) -> MapVersion | None:
    """Return the head version of the map that a robot continues or is localized in; None if it starts a new one.

    May block.

    Parameters
    ----------
    maps : MapStore
        Store of the map.
    user : str
        User who must be allowed to read it.
    parameters : mapping
        Parameters of the robot.

    Raises
    ------
    InvalidParameter
        It is not a map that this user may read, or has no pose graph.
    """
    given = parameters.get("grid_slam")
    name = given.get(NAME) if isinstance(given, Mapping) else None
    if not isinstance(name, str) or not name:
        return None
    try:
        head = maps.map_head(name)
    except NotFound as error:
        raise _no_map(name) from error
    if not head.readable_by(user):
        raise _no_map(name)  # the same error as for an unknown map, so that ids are not revealed
    if POSEGRAPH not in head.present.files:
        raise InvalidParameter(
            f"{NAME}: map {name!r} has no pose graph: publish one with 'ppaas robot map' or 'ppaas map publish "
            "--posegraph'"
        )
    return MapVersion(head.id, head.version)


def is_lifelong(parameters: Mapping[str, Any]) -> bool:
    """Return whether the parameters of a robot let it map for life."""
    given = parameters.get("grid_slam")
    return isinstance(given, Mapping) and given.get("mode") == "lifelong"


def _no_map(name: str) -> InvalidParameter:
    return InvalidParameter(
        f"{NAME}: {name!r} is not a published map: publish it, or change the parameter of the robot"
    )


def mask_heads(maps: MapStore, user: str, parameters: Mapping[str, Any]) -> dict[str, MapRecord]:
    """Return the head versions of the masks in a robot's parameters, by the names of their filters. May block.

    Parameters
    ----------
    maps : MapStore
        Store of the masks.
    user : str
        User who must be allowed to read them.
    parameters : mapping
        Parameters of the robot.

    Raises
    ------
    InvalidParameter
        A mask is not a map that this user may read, or has no grid; or the parameters of a filter are invalid. The text
        names all such masks.
    """
    heads, refused = {}, []
    for name, mask in filter_masks(parameters).items():
        try:
            heads[name] = _head(maps, user, name, mask)
        except InvalidParameter as error:
            refused.append(str(error))
    if refused:
        raise InvalidParameter("; ".join(refused))
    return heads


def _head(maps: MapStore, user: str, name: str, mask: str) -> MapRecord:
    try:
        head = maps.map_head(mask)
    except NotFound as error:
        raise no_mask(name, mask) from error
    if not head.readable_by(user):
        raise no_mask(name, mask)  # the same error as for an unknown map, so that ids are not revealed
    if YAML not in head.present.files:
        raise no_grid_in(name, mask)
    return head


def no_mask(name: str, mask: str) -> InvalidParameter:
    """Return the error for a mask that does not exist."""
    return InvalidParameter(
        f"{name}: the mask {mask!r} is not a published map: publish it, or change {name} in the parameters of the robot"
    )


def no_grid_in(name: str, mask: str) -> InvalidParameter:
    """Return the error for a mask that only has an octomap."""
    return InvalidParameter(
        f"{name}: the mask {mask!r} has an octomap and no grid: publish a YAML with its image, or change {name} in the "
        "parameters of the robot"
    )


def joint_map_owner(maps: MapStore, user: str, name: str) -> str:
    """Return the user whose robots may join maps with a new map of a user; may block.

    It is the user, or the owner of the published map of that id if it is shared with the user by name. A public map
    does not count: anybody could change what the robots of its owner map.

    Parameters
    ----------
    maps : MapStore
        Store of the map.
    user : str
        Owner of the robot.
    name : str
        Id under which the new map is to be published.
    """
    try:
        head = maps.map_head(name)
    except NotFound:
        return user
    return owner_by(head, user)


def owner_by(head: MapRecord, user: str) -> str:
    """Return the same by the published map of that id."""
    return head.owner if user in head.readers else user
