"""What is told of a cloud, to whoever put it together."""

from collections.abc import Collection


class CloudListener:
    """Does nothing about what it is told; a subclass does about what it minds."""

    def machine_frozen(self, machine: str) -> None:
        """Take note of a machine whose agent shows no sign of life, for whoever can end it; it was hung up on."""

    def machine_removed(self, machine: str) -> None:
        """Take note of a machine that an administrator removed, for whoever would start its agent again."""

    def machines_changed(self, machines: Collection[str]) -> None:
        """Take note of the names of all machines when one has come or gone."""

    def place_adopted(self, key: str) -> None:
        """Take note of a place that goes on with a container that ran since another cloud process."""
