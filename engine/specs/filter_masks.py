"""Masks of costmap filters: maps that a robot's parameters name."""

from collections.abc import Mapping
from typing import Any

from engine.specs.containers import MapVersion
from ppaas.errors import InvalidParameter, NotFound
from ppaas.nodes.map_server.costmap_filters import filter_masks
from storage.ports import MapStore
from storage.versions import YAML


def mask_versions(maps: MapStore, user: str, parameters: Mapping[str, Any]) -> dict[str, MapVersion]:
    """Return the present versions of the masks that a robot's parameters want, by the names of their filters.

    Parameters
    ----------
    maps : MapStore
        Has them; this may block.
    user : str
        Who must be allowed to read them.
    parameters : mapping
        Of the robot's file.

    Raises
    ------
    InvalidParameter
        A mask is no map that this user may read, or has no grid; or the parameters of a filter are none.
    """
    return {name: _version(maps, user, name, mask) for name, mask in filter_masks(parameters).items()}


def _version(maps: MapStore, user: str, name: str, mask: str) -> MapVersion:
    try:
        head = maps.map_head(mask)
    except NotFound as error:
        raise no_mask(name, mask) from error
    if not head.readable_by(user):
        raise no_mask(name, mask)  # as if there were none, so that ids are not given away
    if YAML not in head.present.files:
        raise no_grid_in(name, mask)
    return MapVersion(head.id, head.version)


def no_mask(name: str, mask: str) -> InvalidParameter:
    """Return the error for a mask that is not there."""
    return InvalidParameter(
        f"{name}: the mask {mask!r} is no map here: publish it, or change {name} in the parameters of the robot"
    )


def no_grid_in(name: str, mask: str) -> InvalidParameter:
    """Return the error for a mask that lies in space alone."""
    return InvalidParameter(
        f"{name}: the mask {mask!r} has an octomap and no grid: publish a YAML with its image, or change {name} in the "
        "parameters of the robot"
    )
