"""Score and report of a group of robots that count and follow people, from the truth of the simulation.

A person is *in view* if half of the torso or more has been in the view of the same or different robots without a break
for ``LAG``: the time that an image, a detection, a report and a cycle of the coordinator take together. A person of
whom a smaller part was in view within the last ``LAG``, or who came into view or left it within that time, is *at the
edge*: a coordinator is right to count such a person, and right not to.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from ppaas.messages.people_coordination import SEEN, PeopleState

FLAP = 5.0
"""Time within which a handover that is reverted is a flap [s]."""


class Handovers:
    """Counts handovers: a person whom one robot followed is followed by another.

    Attributes
    ----------
    number : int
        Number of handovers.
    flaps : int
        Number of handovers that reverted another within `FLAP`.
    """

    def __init__(self) -> None:
        self.number = self.flaps = 0
        self._robot: dict[int, str] = {}
        self._left: dict[tuple[int, str], float] = {}

    def take(self, time: float, person: int, robot: str) -> bool:
        """Note that a robot follows a person at a time [s]; return whether it took over from another robot."""
        before = self._robot.get(person, robot)
        self._robot[person] = robot
        if before == robot:
            return False
        self.number += 1
        self.flaps += time - self._left.get((person, robot), float("-inf")) <= FLAP
        self._left[person, before] = time
        return True


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

HALF, GLIMPSE = 0.5, 0.1
"""Share of a torso that is enough to be seen, and that may be."""

LAG = 1.0
"""Time for which a person must be in view to be counted, and may still be counted afterwards [s]."""

GATE = 1.0
"""Largest distance between a person and the identity that stands for it [m]."""

KEPT = 0.35
"""Distance by which another identity must be nearer to a person [m]: nearer than this, two people cannot stand."""

NOBODY = -1
"""Number in place of that of a person."""

ABSENCE = 5.0
"""Time out of all views after which a person may come back as somebody else [s]."""

NEAR = 3.0
"""Distance within which a person is followed [m]."""


@dataclass(frozen=True, slots=True)
class Truth:
    """True state of the world at one time.

    Parameters
    ----------
    time : float
        [s].
    people : (n, 2) array
        Positions of all people [m]; NaN for a person who is not on the map.
    shares : (n,) array
        Largest share of each torso that a robot has in view.
    robots : dict of str to tuple of float
        Position of each robot by its id [m].
    """

    time: float
    people: Floats
    shares: Floats
    robots: Mapping[str, tuple[float, float]]


class PeopleFigures(msgspec.Struct, frozen=True):
    """Figures of a run.

    Parameters
    ----------
    count_error_mean : float
        Mean difference between the count and the nearest right count.
    count_exact : float
        Share of the time with a right count.
    identity_switches : int
        Number of times that a person in view had another identity than when last in view, without having been out of
        all views for ``ABSENCE``.
    followed_fraction : float
        Share of the time that a robot is within ``NEAR`` of the target, of the time that the target is in view.
    handovers, flaps : int
        Number of times that another robot took over a person, and of those that were reverted within 5 s.
    contacts : int
        Number of contacts with people, walls and robots that a robot caused.
    seen : float
        Mean number of people in view.
    seconds : float
        Duration [s].
    ghosts : float
        Mean number of identities that the coordinator sees and that are nobody.
    """

    count_error_mean: float
    count_exact: float
    identity_switches: int
    followed_fraction: float
    handovers: int
    flaps: int
    contacts: int = 0
    seen: float = 0.0
    seconds: float = 0.0
    ghosts: float = 0.0


@dataclass(slots=True)
class ScoredFrame:
    """People and identities of one time.

    Parameters
    ----------
    in_view, at_edge : (n,) bool array
        People in view, and at the edge.
    identities : list of int
        Identities that the coordinator sees.
    positions : (m, 2) array
        Their positions [m].
    person_of : dict of int to int
        The person that an identity stands for.
    """

    in_view: Mask
    at_edge: Mask
    identities: list[int]
    positions: Floats
    person_of: dict[int, int] = field(default_factory=dict)


class PeopleScore:
    """Compares states of the coordinator with the truth, at times that are evenly spaced.

    Parameters
    ----------
    people : int
        Number of people in the world.
    """

    def __init__(self, people: int) -> None:
        self._first: float | None = None
        self._time = 0.0
        self._half_since = np.full(people, np.inf)
        self._glimpsed = np.full(people, -np.inf)
        self._identity = np.zeros(people, dtype=np.int64)
        self._last_of: dict[int, int] = {}
        self._handovers = Handovers()
        self._errors: list[int] = []
        self._followed: list[bool] = []
        self._seen: list[int] = []
        self._ghosts: list[int] = []
        self._switches = 0

    def take(self, truth: Truth, state: PeopleState) -> ScoredFrame:
        """Add a state of the coordinator and the truth at that time; return what they have in common."""
        self._first = truth.time if self._first is None else self._first
        self._time = truth.time
        frame = self._frame(truth, state)
        self._count(frame, state.count)
        self._identify(frame)
        self._follow(frame, truth, state)
        return frame

    def figures(self, contacts: int = 0) -> PeopleFigures:
        """Return the figures of all that was added."""
        return PeopleFigures(
            count_error_mean=_mean(self._errors), count_exact=_mean([not error for error in self._errors]),
            identity_switches=self._switches, followed_fraction=_mean(self._followed, 1.0),
            handovers=self._handovers.number, flaps=self._handovers.flaps, contacts=contacts,
            seen=_mean(self._seen), seconds=round(self._time - (self._first or 0.0), 3), ghosts=_mean(self._ghosts),
        )  # fmt: skip

    def _frame(self, truth: Truth, state: PeopleState) -> ScoredFrame:
        now, shares = truth.time, np.where(np.isfinite(truth.people).all(axis=1), truth.shares, 0.0)
        self._half_since = np.where(shares >= HALF, np.minimum(self._half_since, now), np.inf)
        self._identity[(shares >= GLIMPSE) & (now - self._glimpsed > ABSENCE)] = 0
        self._glimpsed = np.where(shares >= GLIMPSE, now, self._glimpsed)
        in_view = now - self._half_since >= LAG
        at_edge = ~in_view & (now - self._glimpsed <= LAG)
        seen = [person for person in state.people if person.state == SEEN]
        positions = np.array([(person.position.x, person.position.y) for person in seen]).reshape(-1, 2)
        frame = ScoredFrame(in_view, at_edge, [person.id for person in seen], positions)
        self._match(frame, truth.people)
        return frame

    def _match(self, frame: ScoredFrame, people: Floats) -> None:
        """Assign identities to people by the least total distance; each favours the person for whom it stood last.

        An identity that is nobody costs as much as the farthest one: a false one beside a person leaves them their own.
        CLEAR MOT (Bernardin and Stiefelhagen, 2008) keeps correspondences before it makes new ones, too.
        """
        candidates = np.flatnonzero(frame.in_view | frame.at_edge)
        far = np.hypot(*(frame.positions[:, np.newaxis] - people[candidates]).transpose(2, 0, 1))
        last = np.array([self._last_of.get(identity, NOBODY) for identity in frame.identities], dtype=np.int64)
        kept = last[:, np.newaxis] == candidates
        cost = np.where(far <= GATE, far - KEPT * kept, GATE)
        for row, column in zip(*linear_sum_assignment(cost), strict=True):
            if far[row, column] <= GATE:
                frame.person_of[frame.identities[row]] = int(candidates[column])

    def _count(self, frame: ScoredFrame, count: int) -> None:
        least = int(frame.in_view.sum())
        most = least + int(frame.at_edge.sum())
        self._errors.append(max(least - count, count - most, 0))
        self._seen.append(least)
        self._ghosts.append(len(frame.identities) - len(frame.person_of))

    def _identify(self, frame: ScoredFrame) -> None:
        for identity, person in frame.person_of.items():
            if frame.in_view[person]:
                before, self._identity[person] = int(self._identity[person]), identity
                self._switches += before not in (0, identity)
        self._last_of.update(frame.person_of)

    def _follow(self, frame: ScoredFrame, truth: Truth, state: PeopleState) -> None:
        robots = np.array(list(truth.robots.values())).reshape(-1, 2)
        for order in state.orders:
            self._handovers.take(truth.time, order.person, order.robot)
            person = self._last_of.get(order.person)
            if person is not None and frame.in_view[person]:
                self._followed.append(bool(np.hypot(*(robots - truth.people[person]).T).min(initial=np.inf) <= NEAR))
        if not state.orders and frame.in_view.any():
            self._followed.append(False)


def _mean(values: list[int] | list[bool], empty: float = 0.0) -> float:
    return round(float(np.mean(values)), 4) if values else empty


# -- report of the demo of people --------------------------------------------------------------------------------------

KEYS = (
    "count_error_mean", "count_exact", "identity_switches", "followed_fraction", "handovers", "flaps", "contacts",
)  # fmt: skip
"""Figures of the JSON object, in order."""


class PeopleDemoReport(msgspec.Struct):
    """Report of a demo in which robots count and follow people.

    Parameters
    ----------
    map : str
        Id of the map.
    seconds : float
        Time that was scored [s].
    robots, people : int
        Numbers of robots and people.
    figures : PeopleFigures
    """

    map: str
    seconds: float
    robots: int
    people: int
    figures: PeopleFigures

    @property
    def passed(self) -> bool:
        """Whether somebody was seen and followed, without a contact, and no handover was reverted soon."""
        figures = self.figures
        return figures.seen > 0.0 and figures.followed_fraction > 0.0 and not figures.contacts and not figures.flaps

    def to_json(self) -> str:
        """Return the figures as one line of JSON."""
        return msgspec.json.encode({key: getattr(self.figures, key) for key in KEYS}).decode()

    def lines(self) -> list[str]:
        """Return the report for people."""
        figures = self.figures
        return [
            f"{self.robots} robots and {self.people} people, {figures.seen:.1f} of them in view on average",
            f"the count was exact {100 * figures.count_exact:.1f} % of the time, and {figures.count_error_mean:.2f} "
            f"off on average; {figures.identity_switches} identity switches",
            f"a robot was near the person followed {100 * figures.followed_fraction:.1f} % of the time; "
            f"{figures.handovers} handovers, {figures.flaps} of them reverted within 5 s; {figures.contacts} contacts",
            f"{'passed' if self.passed else 'failed'} after {self.seconds:.0f} s on map {self.map!r}",
        ]
