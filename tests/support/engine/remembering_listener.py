"""A listener of a cloud that records all events."""

from collections.abc import Collection

from engine.control.master_driver import CloudListener


class RememberingListener(CloudListener):
    """Records events in order."""

    def __init__(self) -> None:
        self.frozen: list[str] = []
        self.removed: list[str] = []
        self.machines: list[list[str]] = []
        self.adopted: list[str] = []

    def machine_frozen(self, machine: str) -> None:
        self.frozen.append(machine)

    def machine_removed(self, machine: str) -> None:
        self.removed.append(machine)

    def machines_changed(self, machines: Collection[str]) -> None:
        self.machines.append(list(machines))

    def place_adopted(self, key: str) -> None:
        self.adopted.append(key)
