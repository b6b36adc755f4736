"""Presence of people: seen, predicted while hidden, lost; gone from where a robot should see them and does not."""

from collections.abc import Collection, Mapping

import numpy as np

from ppaas.messages.people_coordination import LOST, PREDICTED, SEEN
from ppaas.people.coordinator.parameters import CoordinatorParameters
from ppaas.people.coordinator.people_table import PeopleTable, PersonRecord

MISSED = 0.9
"""Evidence that a person loses for each cycle in which a robot with a new report should see them and does not."""
SPREAD = 1.0
"""Standard deviation that is added to the position of a person who is not where predicted [m]."""
UNCONFIRMED = 1.0
"""Time without a sighting after which a person who was never confirmed is forgotten [s]."""


def update_presence(
    table: PeopleTable,
    missed_by: Mapping[int, Collection[bool]],
    seconds: float,
    now: float,
    parameters: CoordinatorParameters,
) -> None:
    """Update the states of all people.

    Parameters
    ----------
    table : PeopleTable
    missed_by : mapping of int to collection of bool
        Of people without a sighting in this cycle, by row: for each robot that should see them whether its report is
        new. An empty collection means that they are hidden from all robots.
    seconds : float
        Time since the last cycle [s].
    now : float
        [s]
    parameters : CoordinatorParameters
    """
    for row, person in enumerate(table.rows):
        missing = missed_by.get(row, ())
        if any(missing) and not person.seen_by:
            person.evidence -= MISSED
        before = person.state
        person.state = _state(person, bool(missing), now, parameters)
        if person.state == SEEN:
            person.seen_total += seconds
        elif person.state == LOST and before != LOST:
            table.bank.covariances[row, :, :2, :2] += SPREAD**2 * np.eye(2)


def _state(person: PersonRecord, in_view: bool, now: float, parameters: CoordinatorParameters) -> str:
    """Return the state of a person.

    A person whom the robots just saw, and who is still in somebody's view, counts as seen: detectors miss people now
    and then. A person who is hidden is predicted. One who should be seen and is not has left.
    """
    hidden = now - person.last_seen
    if person.seen_by or (in_view and hidden <= parameters.seen_for and person.evidence > 0.0):
        return SEEN
    if person.evidence <= 0.0 or hidden > parameters.predict_for or person.state == LOST:
        return LOST
    return PREDICTED


def forgotten(table: PeopleTable, now: float, parameters: CoordinatorParameters, most: int) -> set[int]:
    """Return the rows of people to forget: hidden for too long, never confirmed, or more than the table holds."""
    gone = set()
    for row, person in enumerate(table.rows):
        hidden = now - person.last_seen
        limit = parameters.forget_after if person.confirmed else UNCONFIRMED
        if hidden > limit or (not person.confirmed and person.evidence <= 0.0):
            gone.add(row)
    surplus = len(table) - len(gone) - most
    if surplus > 0:
        rest = sorted(set(range(len(table))) - gone, key=lambda row: (table.rows[row].last_seen, -table.rows[row].id))
        gone |= set(rest[:surplus])
    return gone
