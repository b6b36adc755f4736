"""Rules that come with the project: robots follow the nearest people, the longest seen, or a user's choice."""

from collections.abc import Sequence

from ppaas.people.rules.base import Candidate, PeopleRule


class LongestSeen(PeopleRule):
    """Follows the people whom robots have seen longest in total; a person who is followed stays so until lost."""

    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return those who are followed, and then the others by the time for which they were seen."""
        reachable = [each for each in candidates if each.followed or each.costs]
        ordered = sorted(reachable, key=lambda each: (not each.followed, -each.seen_for, each.first_seen, each.person))
        return [each.person for each in ordered[:limit]]

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen."""
        return f"seen longest, for {candidate.seen_for:.0f} s"


class Named(PeopleRule):
    """Follows the targets of the settings, in their order, and nobody else."""

    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return the targets that robots know."""
        known = {each.person for each in candidates}
        return [person for person in dict.fromkeys(targets) if person in known][:limit]

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen."""
        return f"a user picked {candidate.name or f'person {candidate.person}'}"


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
