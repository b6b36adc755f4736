"""A client of a place that remembers what it is told."""

from ppaas.errors import PPaaSError


class Listening:
    """Remembers; a refusal fails the test."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, bytes]] = []
        self.reasons: list[PPaaSError] = []

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message."""
        self.heard.append((topic, payload))

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Fail."""
        raise AssertionError(f"{topic}: {error}")

    def closed(self, reason: PPaaSError) -> None:
        """Remember why the place is no more."""
        self.reasons.append(reason)
