"""Rule: robots follow the people whom they have seen longest."""

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
