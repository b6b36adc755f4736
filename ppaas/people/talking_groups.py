"""Space between people who stand and talk, into which nobody goes.

It is the o-space of Kendon, *Conducting Interaction* (1990). The space of a group is modelled by the
segments between each two of its members.
"""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ppaas.messages.people_coordination import LOST, TrackedPerson

Points = NDArray[np.float64]

MOST_APART = 3.5
"""Distance up to which two people of a group talk with each other [m]."""

SPACING = 0.4
"""Distance between points on a segment [m]."""


def groups_of(people: Iterable[TrackedPerson], seconds: float = 0.0) -> list[Points]:
    """Return the members of each group of two or more.

    Parameters
    ----------
    people : iterable of TrackedPerson
        Those who are lost are left out.
    seconds : float
        Time after the time of the positions, for which they are predicted [s].

    Returns
    -------
    list of (n, 2) array
        Positions of the members, x, y [m].
    """
    groups = defaultdict(list)
    for person in people:
        if person.group and person.state != LOST:
            groups[person.group].append(predicted(person, seconds))
    return [np.array(members) for members in groups.values() if len(members) > 1]


def predicted(person: TrackedPerson, seconds: float) -> tuple[float, float]:
    """Return where a person is after a time [s], at constant velocity: x, y [m]."""
    return person.position.x + seconds * person.velocity.x, person.position.y + seconds * person.velocity.y


def segments_of(members: Points) -> NDArray[np.float64]:
    """Return the segments between members who talk, (n, 2, 2): the ends of each, x, y [m]."""
    first, second = np.triu_indices(len(members), 1)
    near = np.hypot(*(members[first] - members[second]).T) <= MOST_APART
    segments: NDArray[np.float64] = np.stack((members[first[near]], members[second[near]]), axis=1)
    return segments


def between(members: Points) -> Points:
    """Return points between the members of a group, at most `SPACING` apart, without the members: (n, 2) x, y [m]."""
    points = [np.empty((0, 2))]
    for one, other in segments_of(members):
        count = int(np.hypot(*(other - one)) / SPACING)
        parts = np.arange(1, count + 1)[:, None] / (count + 1)
        points.append(one + parts * (other - one))
    return np.concatenate(points)


def distances_to(points: Points, groups: Iterable[Points]) -> NDArray[np.float64]:
    """Return the distance of each of (n, 2) points from the nearest space of a group [m]; infinite without a group."""
    nearest = np.full(len(points), np.inf)
    for members in groups:
        for one, other in segments_of(members):
            along = other - one
            parts = np.clip((points - one) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(*(points - one - parts[:, None] * along).T))
    return nearest
