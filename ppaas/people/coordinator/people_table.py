"""People of a map: identities that robots share, with the filters of their motion."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ppaas.messages.people_coordination import LOST, SEEN
from ppaas.people.tracks.filter_bank import FilterBank

Array = NDArray[np.float64]

MOST_PEOPLE = 1_000
"""Limit of the number of people; beyond it the ones that were hidden longest are forgotten."""
MOST_EVIDENCE = 4.0
DOUBTFUL = 2.0
"""Doubt from which a person is not counted [s]."""
CONFIRMED = 2.0
"""Evidence from which a torso counts as a person."""


@dataclass(slots=True)
class PersonRecord:
    """A person.

    Parameters
    ----------
    id : int
    first_seen, last_seen : float
        [s since the epoch]
    evidence : float
        Logarithm of the odds that it is a person who is at its predicted position.
    confirmed : bool
        Whether the evidence has been enough once.
    waits : int
        Number of further observations before it can be confirmed: it may be a person who is known already.
    state : str
    seen_by : dict of str to str
        Robot ID to tf frame of the torso, of the robots that see the person.
    seen_total : float
        Time for which robots have seen the person in total [s].
    deviation : float
        Least deviation of the robots that saw the person last [m].
    group : int
    still_since : float
        Time since which the person stands [s].
    doubt : float
        Doubt in a person whom one robot asserts and several others deny [s].
    """

    id: int
    first_seen: float
    last_seen: float
    evidence: float = 0.0
    confirmed: bool = False
    waits: int = 0
    state: str = SEEN
    seen_by: dict[str, str] = field(default_factory=dict)
    seen_total: float = 0.0
    deviation: float = 0.5
    group: int = 0
    still_since: float = float("inf")
    doubt: float = 0.0

    @property
    def counts(self) -> bool:
        """Whether robots see the person now, and the evidence is enough."""
        return self.confirmed and self.state == SEEN and self.doubt < DOUBTFUL


class PeopleTable:
    """Rows of people: records beside the rows of a filter bank."""

    def __init__(self) -> None:
        self.bank = FilterBank()
        self.rows: list[PersonRecord] = []
        self.next_id = 1
        self.read()

    def __len__(self) -> int:
        return len(self.rows)

    def read(self) -> None:
        """Read the states of the filters."""
        mean, spread = self.bank.states()
        self.positions: Array = mean[:, :2]
        self.velocities: Array = mean[:, 2:]
        self.covariances: Array = spread[:, :2, :2]

    def row_of(self) -> dict[int, int]:
        """Return the row of each id."""
        return {person.id: row for row, person in enumerate(self.rows)}

    def predict(self, seconds: float) -> None:
        """Predict everybody by a time [s]."""
        self.bank.predict(seconds)
        self.read()

    def begin(self, positions: Array, covariances: Array, now: float) -> None:
        """Add people with new identities, at (k, 2) positions."""
        self.bank.add(positions, covariances)
        for _ in range(len(positions)):
            self.rows.append(PersonRecord(self.next_id, now, now))
            self.next_id += 1
        self.read()

    def update(self, rows: Sequence[int], positions: Array, covariances: Array) -> None:
        """Update people by a measured position each."""
        self.bank.update(rows, positions, covariances)
        self.read()

    def drop(self, rows: set[int]) -> list[int]:
        """Forget people, and return their ids."""
        if not rows:
            return []
        kept = [row for row in range(len(self.rows)) if row not in rows]
        gone = [self.rows[row].id for row in sorted(rows)]
        self.bank.keep(np.array(kept, np.intp))
        self.rows = [self.rows[row] for row in kept]
        self.read()
        return gone

    def move_times(self, seconds: float) -> None:
        """Add a time [s] to all times."""
        for person in self.rows:
            person.first_seen += seconds
            person.last_seen += seconds
            person.still_since += seconds

    @property
    def present(self) -> list[int]:
        """Rows of those who are at their predicted positions, as far as is known."""
        return [row for row, person in enumerate(self.rows) if person.confirmed and person.state != LOST]
