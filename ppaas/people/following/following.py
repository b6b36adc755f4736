"""Decides how a robot follows a person: where it stands or drives to, how fast, when it searches or gives up."""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.people_coordination import (
    FOLLOWING,
    GAVE_UP,
    LOST,
    SEARCHING,
    SEEN,
    WAITING,
    PeopleState,
    SensorView,
    TrackedPerson,
)
from ppaas.people.following.parameters import FollowParameters
from ppaas.people.following.places import GROUP_MARGIN, Places, StandingRequest, choose_place, facing
from ppaas.people.following.search import SearchArea
from ppaas.people.talking_groups import Points, distances_to, groups_of, predicted

# -- progress of a robot towards the places that were chosen for it ----------------------------------------------------

STUCK = 5.0
"""Time without progress after which a place counts as not reachable [s]."""

MOVED, SAME = 0.15, 0.5
"""Distance that counts as progress, and distance up to which a place is the one of before [m]."""

REACHED = 0.3
"""Distance from a place within which the robot has reached it [m]."""

FORGOTTEN = 20.0
"""Time for which a place that was not reached is avoided [s]."""

MOST_FAILURES = 3


class UnreachedPlaces:
    """Notes places that the robot does not get to.

    Attributes
    ----------
    failures : int
        Number of places not reached since the robot last stood well.
    most : int
        Number of them that are tried.
    """

    def __init__(self) -> None:
        self.failures, self.most = 0, MOST_FAILURES
        self._failed: list[tuple[float, float, float]] = []
        self._place: Pose2D | None = None
        self._from, self._since = Pose2D(0.0, 0.0), 0.0

    def rest(self) -> None:
        """Note that the robot stands on purpose."""
        self._place = None

    def reset(self) -> None:
        """Note that the robot has got to where it should be."""
        self.failures, self._place = 0, None

    def is_stuck(self, now: float, robot: Pose2D, place: Pose2D) -> bool:
        """Return whether the robot makes no progress to a place, which is avoided from then on."""
        other = self._place is None or self._place.distance_to(place) > SAME
        if other or robot.distance_to(self._from) > MOVED or robot.distance_to(place) <= REACHED:
            self._from, self._since = robot, now
            self._place = place
            return False
        self._place = place
        if now - self._since <= STUCK:
            return False
        self.fail(now)
        return True

    def fail(self, now: float) -> int:
        """Avoid the last place from now on; return how many places were not reached."""
        place, self._place = self._place, None
        if place is not None:
            self._failed.append((place.x, place.y, now + FORGOTTEN))
        self.failures += 1
        return self.failures

    def failed(self, now: float) -> Points:
        """Return the places to avoid, (n, 2) x, y [m]."""
        self._failed = [each for each in self._failed if math.isfinite(each[2]) and now < each[2]]
        return np.array([each[:2] for each in self._failed]).reshape(-1, 2)


# -- person whom a robot follows ---------------------------------------------------------------------------------------

STARTS, STOPS = 0.3, 0.15
"""Speeds above which a standing person walks, and below which a walking person stands [m/s]."""

LONGEST_PREDICTION = 3.0
"""Time for which a position is predicted after the last message [s]."""

STEP, MOST_STEPS = 0.1, 100
"""Distance between points of the path walked [m], and their number."""


class Target:
    """Position and motion of one person, from the messages of the coordinator.

    Parameters
    ----------
    now : float
        Start, by the clock of the node [s].

    Attributes
    ----------
    known : bool
        Whether a position is known.
    seen_at : float
        Last time at which a robot saw the person [s].
    walking : bool
        Whether the person walks.
    heading : float or None
        Direction in which the person last walked [rad].
    last : TrackedPerson or None
        Last message in which the person was not lost.
    seen : TrackedPerson or None
        Last message in which a robot saw the person, or the first if none did.
    """

    def __init__(self, now: float) -> None:
        self.known, self.walking = False, False
        self.seen_at = self._at = now
        self.heading: float | None = None
        self.last: TrackedPerson | None = None
        self.seen: TrackedPerson | None = None
        self._path: deque[tuple[float, float]] = deque(maxlen=MOST_STEPS)

    def take(self, person: TrackedPerson | None, now: float) -> None:
        """Take the person of a message, None if it has none; one who is lost keeps the last position."""
        if person is None or person.state == LOST:
            return
        if person.state == SEEN or not self.known:
            self.seen_at, self.seen = now, person
        self.last, self._at, self.known = person, now, True
        speed = self.speed
        self.walking = speed > (STOPS if self.walking else STARTS)
        if self.walking:
            self.heading = math.atan2(person.velocity.y, person.velocity.x)
        x, y = person.position.x, person.position.y
        if not self._path or math.dist(self._path[-1], (x, y)) >= STEP:
            self._path.append((x, y))

    @property
    def speed(self) -> float:
        """Speed by the last message [m/s]."""
        return 0.0 if self.last is None else math.hypot(self.last.velocity.x, self.last.velocity.y)

    def position(self, now: float, ahead: float = 0.0) -> tuple[float, float]:
        """Return where the person is now, or after a time ``ahead`` [s]: x, y [m]."""
        assert self.last is not None, "the person is known"
        return predicted(self.last, min(now - self._at, LONGEST_PREDICTION) + (ahead if self.walking else 0.0))

    def behind(self, now: float, ahead: float, distance: float) -> tuple[float, float] | None:
        """Return the point of the path walked that is a length of it [m] behind the person after a time ``ahead`` [s].

        Returns
        -------
        tuple of float or None
            x, y [m]; None if the path is too short.
        """
        path: NDArray[np.float64] = np.array([*self._path, self.position(now), self.position(now, ahead)])[::-1]
        lengths = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
        if lengths[-1] < distance:
            return None
        x, y = (float(np.interp(distance, lengths, path[:, axis])) for axis in (0, 1))
        return x, y


# -- the decision: where the robot stands or drives to, how fast, when it searches or gives up -------------------------

AHEAD = 1.0
"""Time for which the goal is ahead of a walking person: the robot does not stop at it before it moves on [s]."""

BESIDE = math.radians(120.0)
"""Direction of the places at the left and the right side of a person, from the heading: beside, and a little behind."""

REAR, STRAIGHT = math.radians(60.0), math.radians(30.0)
"""Angle from straight behind up to which a distant robot is behind a person: on a bow, a narrow camera would see the
person no longer. Angle up to which it drives on the path that the person walked, as it does when it is near."""

FAR = 1.5
"""Distance from which a robot is distant, relative to the one wanted."""

APPROACHING, TOWARDS, PASSES, NEAR = 0.2, math.radians(60.0), 1.5, 3.4
"""A person approaches who comes nearer faster than this [m/s], and walks in a direction that is off that to the robot
by at most this [rad], on a line that passes the robot within this distance [m]. Within the distance `NEAR` [m], the
robot stands then; from afar it drives straight to the person, since on a bow its camera would lose the person."""

CLOSING = 0.8
"""Speed added to the person's for each metre that the robot is too far away [1/s]."""

MATCHED = 3.0
"""Distance beyond the one wanted up to which the robot's speed is matched; farther away it is not limited [m]."""

SLOWEST = 0.15
"""Least limit of the speed while the robot follows [m/s]."""

TURN, TURNED = 0.3, 0.15
"""Angle to the person from which a waiting robot turns, and up to which it does [rad]."""

NAMED = "named"
"""Rule by which robots follow the people that users name."""

BESIDE_AREA = 0.75
"""Distance from the searched area within which somebody comes from it [m]."""

UNKNOWN = 5.0
"""Time after which a person without a position is given up [s]."""


class FollowStep(NamedTuple):
    """What the robot does now.

    Parameters
    ----------
    state : str
        A state of `ppaas.messages.people_coordination.FollowStatus`.
    reason : str
        Why, for people to read.
    distance : float
        Distance to the person [m]; 0 while it is unknown.
    place : Pose2D or None
        Where it drives; None if it stands.
    speed : float
        Fastest speed [m/s]; 0 for no limit.
    """

    state: str
    reason: str
    distance: float = 0.0
    place: Pose2D | None = None
    speed: float = 0.0


class Following:
    """Follows one person by one order.

    Parameters
    ----------
    person : int
        Id of the person.
    robot : str
        Robot ID of the robot that follows.
    parameters : FollowParameters
    places : Places
        Places of the map.
    now : float
        Start, by the clock of the node [s].
    """

    def __init__(self, person: int, robot: str, parameters: FollowParameters, places: Places, now: float) -> None:
        self.person = person
        self._robot, self._parameters, self.places = robot, parameters, places
        self._target = Target(now)
        self._began, self._heard_at = now, now
        self._state: PeopleState | None = None
        self._search: SearchArea | None = None
        self._search_began = 0.0
        self._progress = UnreachedPlaces()
        self._gave_up, self._not_found = "", False
        self._settled = self._turning = False
        self._direction: float | None = None

    def hear(self, state: PeopleState, now: float) -> None:
        """Take a message of the coordinator."""
        self._state, self._heard_at = state, now
        found = [person for person in state.people if person.id == self.person]
        self._target.take(found[0] if found else None, now)
        if self._not_found and found and found[0].state == SEEN:
            self._gave_up, self._not_found, self._search = "", False, None

    def use_places(self, places: Places) -> None:
        """Continue on another map; a search begins again there."""
        self.places, self._search = places, None

    def failed(self, reason: str) -> None:
        """Note that Move Base could not reach the last place, which is avoided from now on."""
        if self._progress.fail(self._heard_at) > self._progress.most:
            self.give_up(f"person {self.person} cannot be reached: {reason}")

    @property
    def gave_up(self) -> str:
        """Why the person was given up; empty if not."""
        return self._gave_up

    @property
    def not_found(self) -> bool:
        """Whether the person was given up because the search found nobody; it ends when a robot sees the person."""
        return self._not_found

    def give_up(self, reason: str, *, not_found: bool = False) -> None:
        """Stop following by this order, or until a robot sees a person who was ``not_found``."""
        self._gave_up, self._not_found = reason, not_found

    def step(self, now: float, robot: Pose2D, views: Sequence[SensorView]) -> FollowStep:
        """Decide what the robot does.

        Parameters
        ----------
        now : float
            By the clock of the node [s].
        robot : Pose2D
            Pose of the robot in the map.
        views : sequence of SensorView
            Views of its detectors.
        """
        if not self._gave_up:
            step = self._decide(now, robot, views)
            if not self._gave_up:
                return step
        return FollowStep(GAVE_UP, self._gave_up)

    def _decide(self, now: float, robot: Pose2D, views: Sequence[SensorView]) -> FollowStep:
        if not self._target.known:
            if now - self._began > UNKNOWN:
                self.give_up(f"the coordinator knows no position of person {self.person}")
            return FollowStep(WAITING, f"waiting for the position of person {self.person}")
        if now - self._target.seen_at > self._parameters.hidden_patience:
            return self._look(now, robot, views)
        self._search = None
        return self._follow(now, robot)

    # -- following -----------------------------------------------------------------------------------------------------

    def _follow(self, now: float, robot: Pose2D) -> FollowStep:
        person = self._target.position(now)
        apart = math.dist(person, robot[:2])
        if apart <= NEAR and self._approaches(person, robot):
            return self._wait("the person comes towards the robot", robot, person)
        if self._is_well_placed(person, robot, apart):
            self._progress.reset()
            return self._wait("near the person", robot, person)
        place = self._place(now, robot)
        if place is None:
            return self._wait("no place near the person is free", robot, person)
        if self._is_behind_robot(place, robot, person, apart):
            return self._wait("the person is nearer than the distance", robot, person)
        if self._progress.is_stuck(now, robot, place):
            if self._progress.failures > self._progress.most:
                self.give_up("the places near the person cannot be reached")
            return self._wait("the place is not reached; another one is tried", robot, person)
        return FollowStep(FOLLOWING, f"following person {self.person}", apart, place, self._speed(apart))

    def _wait(self, reason: str, robot: Pose2D, person: tuple[float, float]) -> FollowStep:
        """Stand, and turn to the person."""
        self._progress.rest()
        pose = facing((robot.x, robot.y), person)
        off = abs(wrap_angle(pose.theta - robot.theta))
        self._turning = off > (TURNED if self._turning else TURN)
        return FollowStep(WAITING, reason, math.dist(person, robot[:2]), pose if self._turning else None)

    def _approaches(self, person: tuple[float, float], robot: Pose2D) -> bool:
        """Return whether the person walks towards the robot, which stands then if the person is near."""
        heading = self._target.heading
        if not self._target.walking or heading is None:
            return False
        off = abs(wrap_angle(math.atan2(robot.y - person[1], robot.x - person[0]) - heading))
        passes = math.dist(person, robot[:2]) * math.sin(off) <= PASSES
        return off <= TOWARDS and passes and self._target.speed * math.cos(off) >= APPROACHING

    def _is_well_placed(self, person: tuple[float, float], robot: Pose2D, apart: float) -> bool:
        """Return whether the robot may stay where it is, near a person who stands."""
        p, here = self._parameters, (robot.x, robot.y)
        far = p.distance + (p.tolerance if self._settled else 0.25 * p.tolerance)
        outside = float(distances_to(np.array([here]), self._groups(0.0))[0]) >= 0.8 * GROUP_MARGIN
        self._settled = not self._target.walking and apart <= far and outside and self.places.sees(person, here)
        return self._settled

    def _place(self, now: float, robot: Pose2D) -> Pose2D | None:
        """Return the pose from which the robot follows."""
        target = self._target
        assert target.seen is not None, "the person is known"
        seen = target.seen.position.x, target.seen.position.y
        for person in (target.position(now, AHEAD), target.position(now), seen):  # predictions may be inside a wall
            wanted, path = self._wanted(now, person, robot)
            chosen = choose_place(self._request(now, person, robot, wanted, path), self.places)
            if chosen is not None:
                self._direction = math.atan2(chosen[1] - person[1], chosen[0] - person[0])
                return facing(chosen, person)
        self._direction = None
        return None

    def _wanted(
        self, now: float, ahead: tuple[float, float], robot: Pose2D
    ) -> tuple[float, tuple[float, float] | None]:
        """Return the wanted direction from the person to the robot [rad], and the place on the path walked."""
        target, p = self._target, self._parameters
        rests = not target.walking and p.side == "behind"
        if target.heading is None or rests or self._approaches(target.position(now), robot):
            return math.atan2(robot.y - ahead[1], robot.x - ahead[0]), None
        if p.side == "behind":
            off = wrap_angle(math.atan2(robot.y - ahead[1], robot.x - ahead[0]) - target.heading - math.pi)
            wanted = target.heading + math.pi + min(max(off, -REAR), REAR)
            far = abs(off) > STRAIGHT and math.dist(ahead, robot[:2]) > FAR * p.distance
            direct = far and self.places.sees(ahead, (robot.x, robot.y))
            return wrap_angle(wanted), None if direct else target.behind(now, AHEAD, p.distance)
        return wrap_angle(target.heading + (BESIDE if p.side == "left" else -BESIDE)), None

    def _request(
        self, now: float, ahead: tuple[float, float], robot: Pose2D, wanted: float, path: tuple[float, float] | None
    ) -> StandingRequest:
        assert self._state is not None, "the person is known from a message"
        age = now - self._heard_at
        others = [person for person in self._state.people if person.id != self.person and person.state != LOST]
        robots = [(each.position.x, each.position.y) for each in self._state.robots if each.robot != self._robot]
        return StandingRequest(
            ahead, robot, self._parameters.distance, wanted, self._direction, path,
            people=np.array([predicted(person, age) for person in others]).reshape(-1, 2),
            robots=np.array(robots).reshape(-1, 2),
            personal_space=self._parameters.personal_space, groups=self._groups(age),
            failed=self._progress.failed(now),
        )  # fmt: skip

    def _groups(self, age: float) -> list[Points]:
        return [] if self._state is None else groups_of(self._state.people, age)

    def _is_behind_robot(self, place: Pose2D, robot: Pose2D, person: tuple[float, float], apart: float) -> bool:
        """Return whether the robot would turn its back on a person who is near enough, in order to drive to a place."""
        if apart > self._parameters.distance + self._parameters.tolerance or not self._groups_leave(robot):
            return False
        to_place, to_person = (place.x - robot.x, place.y - robot.y), (person[0] - robot.x, person[1] - robot.y)
        return to_place[0] * to_person[0] + to_place[1] * to_person[1] < 0.0

    def _groups_leave(self, robot: Pose2D) -> bool:
        """Return whether the robot is outside of the space between people who talk."""
        return float(distances_to(np.array([robot[:2]]), self._groups(0.0))[0]) >= 0.8 * GROUP_MARGIN

    def _speed(self, apart: float) -> float:
        """Return the limit of the speed [m/s], by which the robot keeps its distance; 0 for none."""
        p, far = self._parameters, apart - self._parameters.distance
        if not self._target.walking or far > MATCHED:
            return p.max_speed
        matched = max(self._target.speed + CLOSING * far, SLOWEST)
        return min(matched, p.max_speed) if p.max_speed else matched

    # -- searching -----------------------------------------------------------------------------------------------------

    def _look(self, now: float, robot: Pose2D, views: Sequence[SensorView]) -> FollowStep:
        target = self._target
        assert target.seen is not None, "the person is known"
        search = self._search
        if search is None:
            velocity = target.seen.velocity.x, target.seen.velocity.y
            seen = target.seen.position.x, target.seen.position.y
            search = self._search = SearchArea(self.places, seen, velocity, target.seen_at)
            self._search_began = now
            self._progress.reset()
        newcomer = self._newcomer(search)
        if newcomer is not None:
            self.give_up(f"person {newcomer} appeared where person {self.person} may be", not_found=True)
        search.update(now, robot, views)
        if now - self._search_began > self._parameters.search_timeout:
            seconds = self._parameters.search_timeout
            self.give_up(f"person {self.person} was not found within {seconds:g} s", not_found=True)
        place = search.next_place(robot, views)
        if place is None:
            self.give_up(f"person {self.person} is nowhere near the place of the last sight", not_found=True)
        elif self._progress.is_stuck(now, robot, place):
            search.skip()
        return FollowStep(SEARCHING, f"searching for person {self.person}", 0.0, place, self._parameters.max_speed)

    def _newcomer(self, search: SearchArea) -> int | None:
        """Return the id of a person who appeared where the searched one may be, most likely the same with another id.

        The coordinator keeps no identity for long without a sight. If a user named the person, the search goes on.
        """
        state, seen = self._state, self._target.seen
        if state is None or seen is None or state.rule == NAMED:
            return None
        left = max(seen.last_seen.seconds(), seen.first_seen.seconds())
        came = (person for person in state.people if person.state == SEEN and person.first_seen.seconds() > left)
        there = (each for each in came if search.may_be_at(each.position.x, each.position.y, BESIDE_AREA))
        return next((each.id for each in there if each.id != self.person), None)
