"""Addresses of the masters of a cloud, on disk: the one that leads, and those that stand by for it."""

import logging
from collections.abc import Iterable
from pathlib import Path

import msgspec

from engine.processes.private_files import write_private
from engine.protocols.address import TlsAddress, parse_address
from ppaas.decoding import from_json
from ppaas.errors import InvalidInput

logger = logging.getLogger(__name__)

FILE = "masters.json"
"""Name of the file in a folder of certificates."""

MOST = 8
"""Largest number of addresses; those that were noted first are forgotten."""


class KnownMasters:
    """Addresses at which a master of a cloud may listen for machines, the latest ones first.

    Parameters
    ----------
    folder : Path
        Folder of the file. A file that cannot be read counts as empty.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / FILE
        self.addresses: tuple[TlsAddress, ...] = ()
        self.read()

    def read(self) -> None:
        """Read the file again, which another process may have replaced."""
        try:
            self.addresses = _parsed(from_json(self._file.read_bytes(), list[str]))
        except FileNotFoundError:
            self.addresses = ()
        except (OSError, msgspec.DecodeError) as error:
            logger.warning("the addresses of masters in %s cannot be read: %s", self._file, error)

    def note(self, addresses: Iterable[str]) -> bool:
        """Add addresses, and store them; return whether there was a new one. Invalid ones are left out."""
        noted = dict.fromkeys((*_parsed(addresses), *self.addresses))
        kept = tuple(noted)[:MOST]
        if set(kept) <= set(self.addresses):
            return False
        self.addresses = kept
        try:
            write_private(self._file, msgspec.json.encode(self.texts()))
        except OSError as error:
            logger.warning("the addresses of masters cannot be stored in %s: %s", self._file, error)
        return True

    def texts(self) -> tuple[str, ...]:
        """Return the addresses as text."""
        return tuple(map(str, self.addresses))


def _parsed(addresses: Iterable[str]) -> tuple[TlsAddress, ...]:
    found = []
    for text in addresses:
        try:
            address = parse_address(text)
        except InvalidInput as error:
            logger.warning("an address of a master is left out: %s", error)
            continue
        if isinstance(address, TlsAddress):
            found.append(address)
    return tuple(found)
