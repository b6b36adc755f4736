"""Rule of the paper: robots follow the people whom they reach at the least cost."""

from collections.abc import Sequence

from ppaas.people.rules.base import Candidate, PeopleRule


class Nearest(PeopleRule):
    """Follows the people of least cost; a person who is followed stays so until robots lose them."""

    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return those who are followed, and then the others by their least cost."""
        reachable = [each for each in candidates if each.followed or each.costs]
        ordered = sorted(reachable, key=lambda each: (not each.followed, each.least_cost, each.person))
        return [each.person for each in ordered[:limit]]

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen."""
        return "cheapest path from any robot to a person"
