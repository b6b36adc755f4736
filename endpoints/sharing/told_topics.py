"""Topics whose content each route about a robot returns: no route reveals what the robot would not send a caller."""

from collections.abc import Mapping
from typing import Final

from engine.rights.access import Access, only_reads
from ppaas.nodes import topics

GOALS: Final = (topics.MOVE_BASE_GOAL.name, topics.MOVE_BASE_STATUS.name)
LOCALIZATION: Final = (topics.AMCL_STATUS.name, topics.GRID_SLAM_STATUS.name)
DESCRIPTION: Final = (topics.ROBOT_DESCRIPTION.name,)
PARAMETERS: Final = ("rosapi/get_param",)

TOLD: Final[Mapping[str, tuple[str, ...]]] = {
    "show_robot": (),  # the parts `urdf` and `parameters` need more
    "fetch_urdf": DESCRIPTION,
    "list_nodes": (topics.NODE_HOMES.name,),
    "show_robot_map": (topics.MAP.name,),
    "fetch_robot_posegraph": ("pose_graph",),
    "show_state": (topics.AMCL_POSE.name,),  # the parts `goals` and `localization` need more
    "list_goals": GOALS,
    "show_goal": GOALS,
    "diagnose_robot": (topics.DIAGNOSTICS.name,),
    "show_recorder": ("recorder/state",),
    "list_recordings": (),
    "show_recording": (),
    "fetch_recording": (),  # the file has the topics alone that the caller may subscribe to
    "unshare_robot": (),
}
"""Topics, and services that only read, by the name of the route; a caller needs the right to all of them."""


def check_told(access: Access, route: str) -> None:
    """Raise ``NotPermitted`` unless a caller may read all that a route answers with."""
    for name in TOLD[route]:
        if only_reads(name):
            access.check_call(name)
        else:
            access.check_subscribe(name)


def may_hear(access: Access, names: tuple[str, ...]) -> bool:
    """Return whether a caller may read some topics, and services that only read."""
    return access.is_full or all(access.may_read(name) for name in names)


def in_words(names: tuple[str, ...]) -> str:
    """Return names of topics and services for a text."""
    return " and ".join(f"`{name}`" for name in names)
