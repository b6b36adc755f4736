"""A client of a place that records all events."""

from ppaas.errors import PPaaSError


class Listening:
    """Records messages and reasons; a refusal fails the test."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, bytes]] = []
        self.reasons: list[PPaaSError] = []

    def published(self, topic: str, payload: bytes) -> None:
        """Record a message."""
        self.heard.append((topic, payload))

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Fail the test."""
        raise AssertionError(f"{topic}: {error}")

    def closed(self, reason: PPaaSError) -> None:
        """Record the reason why the place was closed."""
        self.reasons.append(reason)

    def acknowledged(self, sequence: int) -> None:
        """Ignore that messages are in a checkpoint."""
