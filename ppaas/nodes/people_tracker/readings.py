"""Messages of detectors as readings, in the frame of the message, and frames of people on ``tf``."""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple, TypeVar

from ppaas.errors import InvalidInput
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Point, Pose, Quaternion, Transform, TransformStamped, Vector3
from ppaas.messages.people_msgs import People, PositionMeasurement, PositionMeasurementArray
from ppaas.messages.vision_msgs import Detection3D, Detection3DArray
from ppaas.nodes.frames import PERSON
from ppaas.nodes.people_tracker.parameters import PeopleTrackerParameters
from ppaas.people.tracks.robot_tracker import TorsoIds
from ppaas.transforms.planar import tf_time

T = TypeVar("T")

# -- messages of detectors as readings ---------------------------------------------------------------------------------

MOST_PEOPLE = 200
"""Largest number of people in a message: more than fit into any view."""

FARTHEST = 1e4
"""Largest coordinate [m]."""

LEAST_VARIANCE, MOST_VARIANCE = 1e-4, 4.0
"""Limits of the variance of a position [m²]."""

SURE = 0.9
"""Score of a person that comes without one."""


class FramedPerson(NamedTuple):
    """A person in a reading: position [m] and covariance (row-major 3 × 3) [m²] in the frame of the reading."""

    position: tuple[float, float, float]
    covariance: tuple[float, ...]
    score: float
    begins: bool
    id: str = ""


class Reading(NamedTuple):
    """The people of one measurement.

    Parameters
    ----------
    source : str
        Topic.
    frame : str
        Frame of the positions; empty for the robot's frame.
    stamp : float
        Time of the measurement, 0 for the newest odometry's [s].
    at : float
        Time of arrival, by the executor's clock [s].
    people : tuple of FramedPerson
    """

    source: str
    frame: str
    stamp: float
    at: float
    people: tuple[FramedPerson, ...]


def measured(source: str, message: PositionMeasurementArray, own: PeopleTrackerParameters, now: float) -> Reading:
    """Return the reading of a detector of ``people_msgs``.

    Raises
    ------
    InvalidInput
        A number is not finite, a score is not from 0 to 1, or there are too many people; likewise below.
    """
    people = [
        FramedPerson(
            _position(each.pos, each.object_id), _covariance(each.covariance, own.sigma),
            _score(each.reliability, each.object_id), bool(each.initialization),
        )
        for each in _limited(message.people)
    ]  # fmt: skip
    return _reading(source, message.header, people, now)


def of_people(source: str, message: People, own: PeopleTrackerParameters, now: float) -> Reading:
    """Return the reading of ``people_msgs/People``, whose names are the ids of the robot's own tracker."""
    people = []
    for each in _limited(message.people):
        score = _score(each.reliability, each.name)
        begins = score >= own.min_score
        people.append(FramedPerson(_position(each.position, each.name), _round(own.sigma), score, begins, each.name))
    return _reading(source, message.header, people, now)


def of_detections(source: str, message: Detection3DArray, own: PeopleTrackerParameters, now: float) -> Reading:
    """Return the reading of ``vision_msgs/Detection3DArray``; other classes than people are left out."""
    found = (_person_of(each, own) for each in _limited(message.detections))
    return _reading(source, message.header, [each for each in found if each is not None], now)


def of_frames(
    source: str, transforms: Sequence[TransformStamped], own: PeopleTrackerParameters, now: float
) -> list[Reading]:
    """Return the readings of frames of people that the robot publishes, one for each parent frame and stamp."""
    groups: dict[tuple[str, float], list[FramedPerson]] = {}
    for each in _limited(transforms):
        name = torso_id(each.child_frame_id)
        t = each.transform.translation
        person = FramedPerson(_position(Point(t.x, t.y, t.z), name), _round(own.sigma), SURE, True, name)
        groups.setdefault((each.header.frame_id, tf_time(each.header.stamp)), []).append(person)
    return [Reading(source, frame.lstrip("/"), stamp, now, tuple(group)) for (frame, stamp), group in groups.items()]


def torso_id(frame: str) -> str:
    """Return the Torso ID of a person's frame; empty for other frames."""
    match = PERSON.fullmatch(frame.lstrip("/"))
    return match[2] if match else ""


def _person_of(detection: Detection3D, own: PeopleTrackerParameters) -> FramedPerson | None:
    """Return a detection if it is more likely a person than anything else."""
    best = max(detection.results, key=lambda each: each.hypothesis.score, default=None)
    if best is None or best.hypothesis.class_id not in own.class_ids:
        return None
    score = _score(best.hypothesis.score, detection.id)
    six = best.pose.covariance
    nine = (six[0], six[1], six[2], six[6], six[7], six[8], six[12], six[13], six[14])
    # Many detectors fill the box alone.
    pose = detection.bbox.center if _is_origin(best.pose.pose) else best.pose.pose
    place = _position(pose.position, detection.id)
    return FramedPerson(place, _covariance(nine, own.sigma), score, score >= own.min_score, detection.id)


def _is_origin(pose: Pose) -> bool:
    return pose.position.x == pose.position.y == pose.position.z == 0.0


def _reading(source: str, header: Header, people: Iterable[FramedPerson], now: float) -> Reading:
    return Reading(source, header.frame_id.lstrip("/"), tf_time(header.stamp), now, tuple(people))


def _limited(people: Sequence[T]) -> Sequence[T]:
    if len(people) > MOST_PEOPLE:
        raise InvalidInput(f"a message may contain at most {MOST_PEOPLE} people, not {len(people)}")
    return people


def _position(point: Point, name: str) -> tuple[float, float, float]:
    place = point.x, point.y, point.z
    if not all(abs(number) <= FARTHEST for number in place):
        raise InvalidInput(f"the position of person {name!r} must be finite, and at most {FARTHEST:g} m, not {place}")
    return place


def _score(score: float, name: str) -> float:
    if not 0.0 <= score <= 1.0:
        raise InvalidInput(f"the score of person {name!r} must be from 0 to 1, not {score}")
    return score


def _covariance(values: Sequence[float], sigma: float) -> tuple[float, ...]:
    """Return a covariance with variances within limits; the covariance of ``sigma`` [m] if all are 0."""
    if not all(map(math.isfinite, values)):
        raise InvalidInput("the covariance of a person must be finite; all zeros mean that it is unknown")
    if not any(values):
        return _round(sigma)
    variances = [min(max(values[k], LEAST_VARIANCE), MOST_VARIANCE) for k in (0, 4, 8)]

    # Off the diagonal, no more than a matrix with these variances can have.
    def mixed(i: int, k: int) -> float:
        most = 0.99 * math.sqrt(variances[i] * variances[k])
        return min(max(0.5 * (values[3 * i + k] + values[3 * k + i]), -most), most)

    xy, xz, yz = mixed(0, 1), mixed(0, 2), mixed(1, 2)
    return variances[0], xy, xz, xy, variances[1], yz, xz, yz, variances[2]


def _round(sigma: float) -> tuple[float, ...]:
    variance = sigma**2
    return variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance


# -- frames of people on ``tf`` ----------------------------------------------------------------------------------------

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
