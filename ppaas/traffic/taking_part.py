"""Parameters by which a robot takes part in the traffic of its map, and the name of what belongs to its group."""

import hashlib
from collections.abc import Mapping
from typing import Any

TRAFFIC = "traffic"
"""Name of the traffic node, and of the parameters of the robots that take part."""

FOLLOWS_PATHS = "follow_path"
"""Name of the parameters of robots that follow paths themselves."""


def takes_part(parameters: Mapping[str, Any]) -> bool:
    """Return whether a robot takes part in the traffic of its map: if it has parameters for it, maybe none in them."""
    return TRAFFIC in parameters


def with_traffic(parameters: Mapping[str, Any], given: bool | Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a robot whose file has the key ``traffic``.

    Parameters
    ----------
    parameters : mapping
        Parameters of the robot, by node.
    given : bool or mapping
        Value of the key: true keeps the parameters for traffic if there are some, else adds an empty section; a
        mapping replaces them; false removes them, so that the robot does not take part.
    """
    others = {name: values for name, values in parameters.items() if name != TRAFFIC}
    if given is False:
        return others
    return others | {TRAFFIC: parameters.get(TRAFFIC, {}) if given is True else dict(given)}


def on_map_with_traffic(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a robot on a map on which all robots take part in the traffic.

    Those that follow paths themselves cannot be led by grants, and stay as they are.
    """
    return dict(parameters) if FOLLOWS_PATHS in parameters else with_traffic(parameters, True)


def traffic_checkpoint(map_id: str) -> str:
    """Return the name of a traffic node's checkpoints among its user's, made of the id of its map."""
    return f"{TRAFFIC}-{hashlib.blake2b(map_id.encode(), digest_size=16).hexdigest()}"
