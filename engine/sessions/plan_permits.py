"""Permits of path requests: whether a path that a client requests is within the quota of its user.

The quota is counted outside of the container, so an operation that requests a path waits for the answer.
"""

from ppaas.errors import PPaaSError


class PermitAwaited(Exception):
    """An operation requests a path, and whether it may is being asked."""


class PlanPermits:
    """Answers to the questions of one session, each for one operation."""

    def __init__(self) -> None:
        self._answers: list[PPaaSError | None] = []

    def answer(self, refusal: PPaaSError | None) -> None:
        """Take an answer: None if the path may be requested."""
        self._answers.append(refusal)

    def take(self) -> None:
        """Use an answer.

        Raises
        ------
        PermitAwaited
            There is none yet.
        PPaaSError
            The path may not be requested.
        """
        if not self._answers:
            raise PermitAwaited
        refusal = self._answers.pop(0)
        if refusal is not None:
            raise refusal
