"""People around a robot, from ``people`` and from the coordinator, also people who stand and are not seen any more."""

import math
from collections.abc import Iterable

from ppaas.costmap.moving_obstacles import MovingObstacle
from ppaas.costmap.social_layer import PersonNearby, Proxemics
from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN, PeopleState, TrackedPerson
from ppaas.messages.people_msgs import People
from ppaas.nodes.frames import MAP
from ppaas.parameters import Parameters
from ppaas.people.state_checks import check_state
from ppaas.people.talking_groups import between, groups_of, predicted
from ppaas.transforms.planar import TransformTree

# -- standing people whom cameras do not see any more ------------------------------------------------------------------

STANDING = 0.3
"""Speed below which a person counts as standing [m/s]."""

KEEP = 60.0
"""Time for which the position of a standing person is kept after they were last seen [s]."""

SAME = 0.5
"""Distance within which a person who is seen takes the place of one who is kept: it is the same person [m]."""


class StandingPeople:
    """Positions at which people stood when they were last seen.

    A camera does not see a person who is nearer than about 1 m, and the tracks of people who are not seen soon end. The
    positions alone do not prove that somebody is there: the caller checks that a laser sees legs.

    Parameters
    ----------
    most : int
        Largest number of positions; positions of people who were not seen for the longest time are forgotten first.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._stood: dict[int, tuple[float, float, float]] = {}

    def take(self, people: Iterable[TrackedPerson], now: float) -> None:
        """Update the positions by the people of a message at ``now`` [s]."""
        for person in (each for each in people if each.state == SEEN):
            self._stood.pop(person.id, None)
            if math.hypot(person.velocity.x, person.velocity.y) < STANDING:
                self._stood[person.id] = now, person.position.x, person.position.y
        for number in list(self._stood)[: max(len(self._stood) - self._most, 0)]:
            del self._stood[number]

    def unseen(self, seen: Iterable[tuple[float, float]], now: float) -> tuple[tuple[float, float], ...]:
        """Return the positions x, y [m], except those near a person at ``seen`` [m] and those older than `KEEP`."""
        known = tuple(seen)
        return tuple(
            (x, y)
            for at, x, y in self._stood.values()
            if now - at <= KEEP and all(math.hypot(x - px, y - py) > SAME for px, py in known)
        )


# -- people from the topics --------------------------------------------------------------------------------------------

MOST_PEOPLE = 1_000
"""Largest number of people in a message."""

FASTEST = 3.0
"""Limit of the speed of a person [m/s]."""

STEP = 0.2
"""Steps of the time for which positions are predicted [s]: the local costmap is not updated more often for people."""

BODY = 0.25
"""Radius of the body of a person, of which a laser sees the legs alone [m]."""

WELL_KNOWN = 0.25
"""Variance up to which the position of a hidden person is known well [m²]."""

COORDINATED = 1.0
"""Time for which people of the coordinator are predicted after its last message [s]; it sends five a second."""


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
    group_amplitude : float
        Cost between people who stand and talk with each other; below 253, the cost of a collision.
    """

    enabled: bool = True
    amplitude: float = 77.0
    covariance: float = 0.25
    cutoff: float = 10.0
    factor: float = 5.0
    keep_time: float = 0.75
    group_amplitude: float = 200.0

    def __post_init__(self) -> None:
        """Check the ranges."""
        self.proxemics()
        if not (math.isfinite(self.keep_time) and self.keep_time > 0.0):
            raise InvalidParameter(f"keep_time must be above 0, not {self.keep_time}")

    def proxemics(self) -> Proxemics:
        """Return the costs around people."""
        return Proxemics(self.amplitude, self.covariance, self.cutoff, self.factor, self.group_amplitude)


class RecentPeople:
    """People of the last message of each topic, until it is out of date.

    A person whom both report has the costs of one, since the higher of two costs counts.

    Parameters
    ----------
    parameters : SocialLayerParameters
    """

    def __init__(self, parameters: SocialLayerParameters) -> None:
        self._parameters = parameters
        self._people: tuple[PersonNearby, ...] = ()
        self._at = float("-inf")
        self._state = PeopleState(Header(), 0)
        self._state_at = float("-inf")
        self._standing = StandingPeople(MOST_PEOPLE)

    def take(self, message: People, tree: TransformTree, now: float) -> None:
        """Replace the people by a message's people.

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
            x, y, *velocity_of = numbers
            position, velocity = frame @ Pose2D(x, y), turn @ Pose2D(*_slowed(*velocity_of))
            seen.append(PersonNearby(position.x, position.y, velocity.x, velocity.y))
        self._people, self._at = tuple(seen), now

    def take_state(self, state: PeopleState, now: float) -> None:
        """Replace the people of the coordinator, in the map frame, by the people in its message.

        Raises
        ------
        InvalidInput
            A number is not finite, or there are too many people.
        """
        if len(state.people) > MOST_PEOPLE:
            raise InvalidInput(f"a message may contain at most {MOST_PEOPLE} people, not {len(state.people)}")
        check_state(state)
        self._state, self._state_at = state, now
        self._standing.take(state.people, now)

    def now(self, now: float) -> tuple[PersonNearby, ...]:
        """Return the people that are not out of date; the coordinator's people at their predicted positions.

        The coordinator's positions are predicted from the arrival of its message, by the clock of this node.
        """
        if not self._parameters.enabled:
            return ()
        people = self._people if now - self._at <= self._parameters.keep_time else ()
        age = self._age(now)
        if age is None:
            return people
        seen = (person for person in self._state.people if person.state != LOST)
        return people + tuple(
            PersonNearby(*predicted(person, age), *_slowed(person.velocity.x, person.velocity.y)) for person in seen
        )

    def bodies(self, now: float) -> tuple[MovingObstacle, ...]:
        """Return the bodies of people of the coordinator whose positions are known well, where they are predicted."""
        age = self._age(now)
        if age is None or not self._parameters.enabled:
            return ()
        return tuple(
            MovingObstacle(*predicted(each, age), *_slowed(each.velocity.x, each.velocity.y), BODY)
            for each in self._state.people
            if each.state == SEEN or (each.state == PREDICTED and max(each.covariance) <= WELL_KNOWN)
        )

    def unseen(self, now: float) -> tuple[MovingObstacle, ...]:
        """Return the bodies of people who stood when they were last seen, and whose positions are not known well now.

        They may have left: a body counts only where a laser sees something.
        """
        if not self._parameters.enabled:
            return ()
        known = tuple((each.x, each.y) for each in self.bodies(now))
        return tuple(MovingObstacle(x, y, 0.0, 0.0, BODY) for x, y in self._standing.unseen(known, now))

    def between(self, now: float) -> tuple[PersonNearby, ...]:
        """Return points between people who stand and talk with each other, as if somebody stood there."""
        age = self._age(now)
        if age is None or not self._parameters.enabled:
            return ()
        return tuple(
            PersonNearby(x, y) for members in groups_of(self._state.people, age) for x, y in between(members).tolist()
        )

    def _age(self, now: float) -> float | None:
        """Return the age of the coordinator's message, rounded down to a step [s]; None if it is out of date."""
        age = now - self._state_at
        return STEP * math.floor(age / STEP) if age <= COORDINATED else None


def _slowed(vx: float, vy: float) -> tuple[float, float]:
    """Return a velocity, limited to `FASTEST` [m/s]."""
    slower = min(1.0, FASTEST / max(math.hypot(vx, vy), FASTEST))
    return slower * vx, slower * vy
