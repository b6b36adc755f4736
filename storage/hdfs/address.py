"""Where maps are in HDFS: ``hdfs://host[:port]/path[?user=name]``."""

import getpass
from dataclasses import dataclass
from urllib.parse import parse_qs, unquote, urlsplit

from hdfs import InsecureClient

from ppaas.errors import InvalidInput

PORT = 9870
"""Of a NameNode's HTTP server, unless ``dfs.namenode.http-address`` says otherwise."""

_TIMEOUT = (5.0, 30.0)
"""To connect, and to wait for more of an answer [s]."""


@dataclass(frozen=True, slots=True)
class HdfsAddress:
    """A folder in HDFS.

    Parameters
    ----------
    host : str
        Name or address of the NameNode, with its port.
    path : str
        Of the folder, absolute.
    user : str
        Who reads and writes it.
    """

    host: str
    path: str
    user: str

    @classmethod
    def parse(cls, url: str) -> "HdfsAddress":
        """Read a URL; ``InvalidInput`` if it is none."""
        try:
            parts = urlsplit(url)
            host, port = parts.hostname, parts.port or PORT
            query = parse_qs(parts.query, strict_parsing=True, keep_blank_values=True) if parts.query else {}
        except ValueError as error:
            raise InvalidInput(f"{url!r} is no URL: {error}") from error
        path = unquote(parts.path).rstrip("/")
        names = path.split("/")[1:]
        if not host or not names or any(name in ("", ".", "..") or "#" in name for name in names):
            raise InvalidInput(f"{url!r} names no folder: write hdfs://host[:port]/path, with ?user=name if need be")
        users = query.pop("user", None) or [getpass.getuser()]
        if query or parts.fragment or parts.username or len(users) > 1 or not users[0]:
            raise InvalidInput(f"{url!r}: nothing but ?user=name may follow the path, and nothing precede the host")
        return cls(f"[{host}]:{port}" if ":" in host else f"{host}:{port}", path, users[0])

    def __str__(self) -> str:
        return f"hdfs://{self.host}{self.path}"

    def client(self) -> InsecureClient:
        """Return what speaks WebHDFS."""
        return InsecureClient(f"http://{self.host}", user=self.user, timeout=_TIMEOUT)
