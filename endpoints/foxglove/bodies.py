"""Bodies of robots as scenes: the outline that the clone plans with."""

from ppaas.clone.robot_body import robot_body
from ppaas.errors import InvalidUrdf, MessageTooLarge, NotFound
from ppaas.robot_model.describe import describe
from ppaas.robot_model.description import RobotDescription
from ppaas.wire.foxglove.conversion.scenes import body
from storage.ports import RobotStore
from storage.records import RobotRecord

HEIGHT = 0.4
"""Height of a robot of unknown height [m]."""


def body_scene(store: RobotStore, record: RobotRecord, frame: str, name: str) -> bytes:
    """Return the scene of a robot's body in a frame; blocks.

    Raises
    ------
    NotFound, InvalidParameter
        As ``robot_body``.
    """
    found = robot_body(record.model, _urdf(store, record), record.parameters)
    return body(frame, name, found.footprint, found.robot_radius, found.height or HEIGHT)


def _urdf(store: RobotStore, record: RobotRecord) -> RobotDescription | None:
    """Return the description in the URDF of a robot; None without a URDF, or with one that cannot be read."""
    try:
        return describe(store.urdf(record.user, record.id))
    except (NotFound, InvalidUrdf, MessageTooLarge):
        return None
