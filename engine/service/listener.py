"""Notifications of a cloud service to the engine that created it."""

from collections.abc import Collection


class CloudListener:
    """Ignores all notifications; a subclass overrides those that it handles."""

    def machine_frozen(self, machine: str) -> None:
        """Handle a machine whose agent missed its heartbeats; its link is already closed. Kill it if possible."""

    def machine_removed(self, machine: str) -> None:
        """Handle a machine that an administrator removed: do not restart its agent."""

    def machines_changed(self, machines: Collection[str]) -> None:
        """Handle a change of the set of machines, given by name."""

    def place_opened(self, key: str) -> None:
        """Handle a place that was opened, or that waits in the queue."""

    def place_adopted(self, key: str) -> None:
        """Handle a place that adopted a container of an earlier cloud process."""
