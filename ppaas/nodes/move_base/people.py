"""People around a robot, from the topic ``people``."""

import math

from ppaas.costmap.social_layer import PersonNearby, Proxemics
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.people_msgs import People
from ppaas.nodes.frames import MAP
from ppaas.parameters import Parameters
from ppaas.transforms.planar import TransformTree

MOST_PEOPLE = 1_000
"""Largest number of people in a message."""

FASTEST = 3.0
"""Limit of the speed of a person [m/s]."""


class SocialLayerParameters(Parameters, frozen=True):
    """Parameters of the social layer, with the names and defaults of the proxemic layer of social_navigation_layers.

    Parameters
    ----------
    enabled : bool
        Whether people are added to the costmap.
    amplitude, covariance, cutoff, factor : float
        See `ppaas.costmap.social_layer.Proxemics`.
    keep_time : float
        Time for which people stay at the position of the last message [s].
    """

    enabled: bool = True
    amplitude: float = 77.0
    covariance: float = 0.25
    cutoff: float = 10.0
    factor: float = 5.0
    keep_time: float = 0.75

    def __post_init__(self) -> None:
        """Check the ranges."""
        self.proxemics()
        if not (math.isfinite(self.keep_time) and self.keep_time > 0.0):
            raise InvalidParameter(f"keep_time must be above 0, not {self.keep_time}")

    def proxemics(self) -> Proxemics:
        """Return the costs around people."""
        return Proxemics(self.amplitude, self.covariance, self.cutoff, self.factor)


class SeenPeople:
    """People of the last message, until it is out of date.

    Parameters
    ----------
    parameters : SocialLayerParameters
    """

    def __init__(self, parameters: SocialLayerParameters) -> None:
        self._parameters = parameters
        self._people: tuple[PersonNearby, ...] = ()
        self._at = float("-inf")

    def take(self, message: People, tree: TransformTree, now: float) -> None:
        """Replace the people by those of a message.

        Raises
        ------
        InvalidInput
            A number is not finite, or there are too many people.
        TransformError
            The frame of the message is unknown.
        """
        if len(message.people) > MOST_PEOPLE:
            raise InvalidInput(f"a message may contain at most {MOST_PEOPLE} people, not {len(message.people)}")
        source = message.header.frame_id.lstrip("/") or MAP
        frame = Pose2D(0.0, 0.0) if source == MAP else tree.lookup(MAP, source)
        turn = Pose2D(0.0, 0.0, frame.theta)
        seen = []
        for person in message.people:
            numbers = (person.position.x, person.position.y, person.velocity.x, person.velocity.y)
            if not all(map(math.isfinite, numbers)):
                raise InvalidInput(f"the position and velocity of person {person.name!r} must be finite")
            x, y, vx, vy = numbers
            slower = min(1.0, FASTEST / max(math.hypot(vx, vy), FASTEST))
            position, velocity = frame @ Pose2D(x, y), turn @ Pose2D(slower * vx, slower * vy)
            seen.append(PersonNearby(position.x, position.y, velocity.x, velocity.y))
        self._people, self._at = tuple(seen), now

    def now(self, now: float) -> tuple[PersonNearby, ...]:
        """Return the people that are not out of date."""
        believed = self._parameters.enabled and now - self._at <= self._parameters.keep_time
        return self._people if believed else ()
