"""Version of the map that a robot continues: the one that ``map_file_name`` in its parameters names."""

from collections.abc import Mapping
from typing import Any

from engine.specs.containers import MapVersion
from ppaas.errors import InvalidParameter, NotFound
from storage.ports import MapStore
from storage.versions import POSEGRAPH

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
