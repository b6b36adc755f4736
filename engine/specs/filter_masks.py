"""Versions of the masks of costmap filters that a robot's parameters name."""

from collections.abc import Mapping
from typing import Any

from ppaas.errors import InvalidParameter, NotFound
from ppaas.nodes.map_server.costmap_filters import filter_masks
from storage.ports import MapStore
from storage.records import MapRecord
from storage.versions import YAML


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
