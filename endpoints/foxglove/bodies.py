"""Bodies of robots as scenes: the outline by the URDF, else that of the model."""

from ppaas.errors import InvalidUrdf, MessageTooLarge, NotFound
from ppaas.robot_model.describe import describe
from ppaas.robot_model.known_models import robot_model
from ppaas.wire.foxglove.conversion.scenes import body
from storage.ports import RobotStore
from storage.records import RobotRecord

HEIGHT = 0.4
"""Height of a robot of unknown height [m]."""


def body_scene(store: RobotStore, record: RobotRecord, frame: str, name: str) -> bytes:
    """Return the scene of a robot's body in a frame; blocks.

    Raises
    ------
    NotFound
        There is no such model.
    """
    model = robot_model(record.model)
    outline, height = model.footprint, model.height
    try:
        described = describe(store.urdf(record.user, record.id))
    except (NotFound, InvalidUrdf, MessageTooLarge):
        pass  # a robot without a URDF, or with one that says nothing of its body, has the body of its model
    else:
        outline, height = described.footprint or outline, described.height or height
    return body(frame, name, outline, model.robot_radius, height or HEIGHT)
