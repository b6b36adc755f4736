"""Joint maps: the robots whose new maps may be joined."""

from ppaas.errors import NotFound
from storage.ports import MapStore
from storage.records import MapRecord


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
