"""Mandate of a master: the right to give orders, and the epoch that its orders are of."""

from typing import Protocol


class Mandate(Protocol):
    """The right to give orders to machines."""

    @property
    def epoch(self) -> int:
        """Epoch of the orders: a later master has a later one."""
        ...

    def leads(self) -> bool:
        """Return whether orders may be given now."""
        ...

    def heard_of(self, epoch: int) -> None:
        """Take note of an epoch that a machine follows; a later one than this epoch means that another master leads."""
        ...


class SoleMaster:
    """Mandate of a master that shares its machines with no other, as in tests of parts of a cloud."""

    epoch = 0

    def leads(self) -> bool:
        """Return true."""
        return True

    def heard_of(self, epoch: int) -> None:
        """Do nothing."""
