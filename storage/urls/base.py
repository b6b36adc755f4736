"""Interface of backends of stores: plug-ins that open stores by URL."""

from abc import ABC, abstractmethod
from pathlib import Path
from typing import ClassVar, Generic, TypeVar

from storage.ports import MapStore, Store

S = TypeVar("S")


class Backend(ABC, Generic[S]):
    """Opens the stores of a URL scheme, which is the name of its entry point.

    A backend imports its driver when it opens a store, so a driver must be installed only where it is used.

    Attributes
    ----------
    extra : str, optional
        Extra of this project that installs the driver of one of its own backends.
    remote : bool
        Whether a server stores the data, which may be unreachable while this process runs; plans then wait in a file.
    takes_password : bool
        Whether the URL may have a password, and so the setting ``password_file``.
    """

    extra: ClassVar[str | None] = None
    remote: ClassVar[bool] = False
    takes_password: ClassVar[bool] = False

    def path(self, url: str) -> Path | None:
        """Return the file or folder of a store on this machine, which only one cloud may use; None if it has none.

        Raises
        ------
        InvalidInput
            The URL has no path, or one that is not valid.
        """
        return None

    def is_store(self, path: Path) -> bool:
        """Return whether a file or a folder that is not empty is such a store, as far as that can be seen."""
        return True

    @abstractmethod
    def open(self, url: str, *, create: bool = True) -> S:
        """Open a store.

        Parameters
        ----------
        url : str
            URL of the store, with its scheme.
        create : bool
            Whether a store on a server is created if it does not exist. Whether one with a path exists was checked.

        Raises
        ------
        InvalidInput
            The URL is not valid.
        Unavailable
            The store cannot be opened now; the message says why and what to do.
        """


class StoreBackend(Backend[Store]):
    """Opens stores of everything but maps, found by an entry point in the group ``ppaas.stores``."""


class MapStoreBackend(Backend[MapStore]):
    """Opens stores of maps, found by an entry point in the group ``ppaas.map_stores``."""
