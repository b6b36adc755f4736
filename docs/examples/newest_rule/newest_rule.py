"""A custom rule of whom robots follow: the people who came last."""

from collections.abc import Sequence

from ppaas.people.rules.base import Candidate, PeopleRule


class Newest(PeopleRule):
    """Follows the people who came last."""

    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return the ids of the people to follow, the most important first."""
        ordered = sorted(candidates, key=lambda each: (not each.followed, -each.first_seen))
        return [each.person for each in ordered[:limit]]

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen."""
        return f"came last, at {candidate.first_seen:.0f} s"
