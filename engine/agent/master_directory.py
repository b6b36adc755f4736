"""Master directory: where the current master of a machine is, and where the others are."""

from typing import Protocol


class MasterDirectory(Protocol):
    """Where the masters of a machine's cloud are."""

    @property
    def current(self) -> str:
        """Address of the master that this machine follows."""
        ...

    def note(self, masters: tuple[str, ...]) -> tuple[str, ...]:
        """Take the addresses of all masters; return the Zenoh endpoints of their routers."""
        ...

    async def another_leads(self) -> bool:
        """Return whether a master at another address leads; that is then the current one."""
        ...


class OneMaster:
    """The directory of a machine whose masters all have one address, as on the cloud's own host.

    Parameters
    ----------
    current : str
        The address.
    """

    def __init__(self, current: str) -> None:
        self.current = current

    def note(self, masters: tuple[str, ...]) -> tuple[str, ...]:
        """Do nothing: the router connects to no other."""
        return ()

    async def another_leads(self) -> bool:
        """Return false."""
        return False
