"""URL of a folder in HDFS: ``hdfs://host[:port]/path[?user=name]``."""

import getpass
from dataclasses import dataclass
from urllib.parse import parse_qs, unquote, urlsplit

from hdfs import InsecureClient

from ppaas.errors import InvalidInput

PORT = 9870
"""Default port of a NameNode's HTTP server (``dfs.namenode.http-address``)."""

_TIMEOUT = (5.0, 30.0)
"""Time limits to connect, and between two packets of a response [s]."""


@dataclass(frozen=True, slots=True)
class HdfsAddress:
    """A folder in HDFS.

    Parameters
    ----------
    host : str
        Host name or address of the NameNode, with its port.
    path : str
        Absolute path of the folder.
    user : str
        HDFS user that reads and writes it.
    """

    host: str
    path: str
    user: str

    @classmethod
    def parse(cls, url: str) -> "HdfsAddress":
        """Parse a URL; ``InvalidInput`` if it is not valid."""
        try:
            parts = urlsplit(url)
            host, port = parts.hostname, parts.port or PORT
            query = parse_qs(parts.query, strict_parsing=True, keep_blank_values=True) if parts.query else {}
        except ValueError as error:
            raise InvalidInput(f"{url!r} is not a URL: {error}") from error
        path = unquote(parts.path).rstrip("/")
        names = path.split("/")[1:]
        if not host or not names or any(name in ("", ".", "..") or "#" in name for name in names):
            raise InvalidInput(
                f"{url!r} has no valid host or folder: write hdfs://host[:port]/path, optionally with ?user=name"
            )
        users = query.pop("user", None) or [getpass.getuser()]
        if query or parts.fragment or parts.username or len(users) > 1 or not users[0]:
            raise InvalidInput(f"{url!r}: only ?user=name may follow the path, and nothing may precede the host")
        return cls(f"[{host}]:{port}" if ":" in host else f"{host}:{port}", path, users[0])

    def __str__(self) -> str:
        return f"hdfs://{self.host}{self.path}"

    def client(self) -> InsecureClient:
        """Return a WebHDFS client."""
        return InsecureClient(f"http://{self.host}", user=self.user, timeout=_TIMEOUT)
