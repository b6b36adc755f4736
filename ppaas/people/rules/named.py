"""Rule: robots follow the people whom a user picked."""

from collections.abc import Sequence

from ppaas.people.rules.base import Candidate, PeopleRule


class Named(PeopleRule):
    """Follows the targets of the settings, in their order, and nobody else."""

    def choose(self, candidates: Sequence[Candidate], targets: Sequence[int], limit: int) -> list[int]:
        """Return the targets that robots know."""
        known = {each.person for each in candidates}
        return [person for person in dict.fromkeys(targets) if person in known][:limit]

    def reason(self, candidate: Candidate) -> str:
        """Return why a person was chosen."""
        return f"a user picked {candidate.name or f'person {candidate.person}'}"
