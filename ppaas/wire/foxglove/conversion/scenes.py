"""Scenes of the 3D panel: the body of a robot with its name, and people."""

import math
from collections.abc import Sequence
from typing import Final

from foxglove import messages as sdk

from ppaas.messages.people_msgs import People, Person
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.foxglove.conversion.drawn import Encodable, drawn, stamp_of
from ppaas.wire.foxglove.conversion.frames import SharedFrames
from ppaas.wire.foxglove.conversion.schemas import protobuf

SCENE: Final[Schema] = protobuf(sdk.SceneUpdate)

BODY: Final = "model"
"""Topic of the body of a robot."""

CORNERS: Final = 32
"""Corners of a round outline."""

PERSON_RADIUS, PERSON_HEIGHT = 0.25, 1.7
"""Size at which a person is drawn [m]."""

PERSON_LIFETIME: Final = sdk.Duration(2)
"""Time for which a person is drawn who is not seen any more [s]."""

_BLUE: Final = sdk.Color(r=0.1, g=0.45, b=0.9, a=1.0)
_ORANGE: Final = sdk.Color(r=0.95, g=0.55, b=0.1, a=0.7)
_LABEL: Final = sdk.Color(r=0.5, g=0.5, b=0.5, a=1.0)


def body(frame: str, name: str, outline: Sequence[tuple[float, float]], radius: float, height: float) -> bytes:
    """Return the scene of a robot: its outline, an arrow ahead and its name, which move with its frame.

    Parameters
    ----------
    frame : str
        Frame of the robot's body, as it is named in the tree.
    name : str
    outline : sequence of (x, y)
        Corners in that frame [m]; empty for a circle.
    radius : float
        Radius of the circle [m].
    height : float
        Height of the name [m].
    """
    corners = outline or [
        (radius * math.cos(2.0 * math.pi * i / CORNERS), radius * math.sin(2.0 * math.pi * i / CORNERS))
        for i in range(CORNERS)
    ]
    line = sdk.LinePrimitive(
        type=sdk.LinePrimitiveLineType.LineLoop,
        pose=_at(0.0, 0.0, 0.0),
        thickness=0.03,
        points=[sdk.Point3(x=x, y=y, z=0.02) for x, y in corners],
        color=_BLUE,
    )
    length = max((x for x, _ in corners), default=radius)
    arrow = sdk.ArrowPrimitive(
        pose=_at(0.0, 0.0, 0.05),
        shaft_length=0.6 * length,
        shaft_diameter=0.04,
        head_length=0.4 * length,
        head_diameter=0.1,
        color=_BLUE,
    )
    entity = sdk.SceneEntity(
        frame_id=frame,
        id=name,
        frame_locked=True,
        lines=[line],
        arrows=[arrow],
        texts=[_label(name, height + 0.2)],
    )
    return sdk.SceneUpdate(entities=[entity]).encode()


def _people(message: People, frames: SharedFrames) -> Encodable:
    header = message.header
    frame, stamp = frames.shared(header.frame_id), stamp_of(header.stamp)
    return sdk.SceneUpdate(entities=[_person(person, frames.robot, frame, stamp) for person in message.people])


def _person(person: Person, robot: str, frame: str, stamp: sdk.Timestamp) -> sdk.SceneEntity:
    x, y = person.position.x, person.position.y
    return sdk.SceneEntity(
        timestamp=stamp,
        frame_id=frame,
        id=f"{robot}/{person.name}",
        lifetime=PERSON_LIFETIME,
        cylinders=[
            sdk.CylinderPrimitive(
                pose=_at(x, y, PERSON_HEIGHT / 2.0),
                size=sdk.Vector3(x=2.0 * PERSON_RADIUS, y=2.0 * PERSON_RADIUS, z=PERSON_HEIGHT),
                bottom_scale=1.0,
                top_scale=1.0,
                color=_ORANGE,
            )
        ],
        texts=[_label(person.name, PERSON_HEIGHT + 0.2, x, y)],
    )


def _label(text: str, height: float, x: float = 0.0, y: float = 0.0) -> sdk.TextPrimitive:
    return sdk.TextPrimitive(pose=_at(x, y, height), billboard=True, font_size=0.2, color=_LABEL, text=text)


def _at(x: float, y: float, z: float) -> sdk.Pose:
    return sdk.Pose(position=sdk.Vector3(x=x, y=y, z=z), orientation=sdk.Quaternion(w=1.0))


PEOPLE: Final = drawn(sdk.SceneUpdate, People, _people)
"""Conversion of people to a scene."""
