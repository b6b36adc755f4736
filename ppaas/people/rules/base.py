"""Interface of rules that choose whom robots follow."""

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Candidate:
    """A person who can be followed.

    Parameters
    ----------
    person : int
        Id of the person.
    costs : mapping of str to float
        Cost of the shortest path from each robot that sees the person and can follow, by Robot ID.
    first_seen : float
        Time at which a robot first saw the person [s].
    seen_for : float
        Time for which robots have seen the person in total [s].
    followed : bool
        Whether a robot follows the person now.
    name : str
        Name that a user gave; empty without one.
    """

    person: int
    costs: Mapping[str, float] = field(default_factory=dict)
    first_seen: float = 0.0
    seen_for: float = 0.0
    followed: bool = False
    name: str = ""

    @property
    def least_cost(self) -> float:
        """Cost of the cheapest robot; infinite if no robot can reach the person."""
        return min(self.costs.values(), default=math.inf)


class PeopleRule(ABC):
    """Chooses whom robots follow.

    Entry points of the group ``ppaas.people_rules`` name subclasses. A rule has no state: what it should take into
    account is in its arguments.
    """

    @abstractmethod
    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return the ids of the people to follow, the most important first.

        Parameters
        ----------
        candidates : sequence of Candidate
            By id.
        targets : sequence of int
            Ids of people whom a user picked.
        limit : int
            Largest number of people who are followed at once; more ids are ignored.
        """

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen, for people to read."""
        return f"chosen by the rule {type(self).__name__}"
