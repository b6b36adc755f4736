"""Frames of people on ``tf``: the ones that the robot publishes itself, and its tracker's."""

from collections import deque
from collections.abc import Sequence

from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.people_msgs import PositionMeasurement
from ppaas.nodes.people_tracker.readings import torso_id
from ppaas.people.robot_tracks.torso_ids import TorsoIds

ECHOES = 500
"""Number of own transforms that are remembered: messages may come back from another home."""

FOREIGN_FOR = 10.0
"""Time for which a frame counts as the robot's own after it was last heard [s]."""

MOST_FOREIGN = 1_000
"""Largest number of frames of the robot's own that are remembered."""


class PersonFrames:
    """Frames of the people of one robot.

    Parameters
    ----------
    robot : str
        Robot ID.

    Attributes
    ----------
    ids : TorsoIds
        Torso IDs of the tracks.
    """

    def __init__(self, robot: str) -> None:
        self.ids = TorsoIds()
        self._prefix = f"{robot}/"
        self._published: deque[tuple[str, int, int]] = deque(maxlen=ECHOES)
        self._foreign: dict[str, float] = {}

    def frame(self, name: str) -> str:
        """Return the frame of a Torso ID."""
        return self._prefix + name

    def foreign(self, transforms: Sequence[TransformStamped], now: float) -> list[TransformStamped]:
        """Return the transforms to people that the robot publishes itself, and remember their Torso IDs.

        Parameters
        ----------
        transforms : sequence of TransformStamped
        now : float
            Time by the executor's clock [s].
        """
        found = []
        for each in transforms:
            child = each.child_frame_id.lstrip("/")
            name = torso_id(child)
            if name and child.startswith(self._prefix) and not self._is_echo(each):
                found.append(each)
                self._foreign.pop(name, None)
                self._foreign[name] = now
        while len(self._foreign) > MOST_FOREIGN:
            del self._foreign[next(iter(self._foreign))]
        return found

    def taken(self, now: float) -> set[str]:
        """Return the Torso IDs of frames that the robot publishes itself."""
        return {name for name, at in self._foreign.items() if now - at <= FOREIGN_FOR}

    def transforms(self, people: Sequence[PositionMeasurement], now: float) -> list[TransformStamped]:
        """Return the transforms to people, without those that the robot publishes itself."""
        taken = self.taken(now)
        wanted = [person for person in people if person.object_id not in taken]
        self._published.extend(_key(person.name, person.header.stamp) for person in wanted)
        return [_transform(person) for person in wanted]

    def _is_echo(self, transform: TransformStamped) -> bool:
        return _key(transform.child_frame_id.lstrip("/"), transform.header.stamp) in self._published


def _key(frame: str, stamp: Time) -> tuple[str, int, int]:
    return frame, stamp.secs, stamp.nsecs


def _transform(person: PositionMeasurement) -> TransformStamped:
    place = Vector3(person.pos.x, person.pos.y, person.pos.z)
    return TransformStamped(person.header, person.name, Transform(place, Quaternion(z=0.0, w=1.0)))
