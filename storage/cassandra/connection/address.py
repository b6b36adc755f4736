"""Where a Cassandra is, and how to speak with it: what a URL of such a store says.

``cassandra://user:password@host1,host2:9042/keyspace?replication=3&consistency=local_quorum&timeout=5&tls=yes``; all
but a host and the keyspace may be left out. Nodes that are not named are learnt from those that are; all listen on one
port.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl, unquote, urlsplit

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.chunks import GRANULARITY, MOST_GRANULARITY

PORT = 9042
CONSISTENCIES = ("one", "local_one", "quorum", "local_quorum", "each_quorum", "all")
TLS = ("no", "yes", "any_name")
SETTINGS = (
    *("replication", "consistency", "data_centre", "timeout", "granularity"),
    *("tls", "ca", "certificate", "key"),
)

_KEYSPACE = re.compile(r"[a-z][a-z0-9_]{0,47}")
_DATA_CENTRE = re.compile(r"[A-Za-z0-9_.-]{1,64}")
_FORM = "write cassandra://[user:password@]host[,host…][:port]/keyspace"


@dataclass(frozen=True, slots=True)
class Tls:
    """How nodes are proved, and who asks.

    Parameters
    ----------
    check_name : bool
        Whether a node's certificate must be of the name or number under which it is reached.
    ca : str or None
        File of the authorities who sign nodes; those of the system unless told.
    certificate, key : str or None
        Files by which this client is proved, where nodes want that; the key may be in the certificate's.
    """

    check_name: bool = True
    ca: str | None = None
    certificate: str | None = None
    key: str | None = None


@dataclass(frozen=True, slots=True)
class CassandraAddress:
    """What a URL says.

    Parameters
    ----------
    hosts : tuple of str
        Nodes to begin with.
    port : int
        Of all nodes.
    keyspace : str
        Made if it is not there.
    user, password : str or None
        How to log in, if at all.
    replication : dict
        As CQL takes it; used only where the keyspace is made.
    consistency : str
        How many copies have to answer: one of ``CONSISTENCIES``.
    timeout : float
        How long one request may take [s].
    granularity : int
        Fewest waypoints of an entry of the path plan database (``ppaas.plans.encoding.chunks``).
    data_centre : str or None
        Whose nodes are asked; unless told that of the first host that answers.
    tls : Tls or None
        None where nodes are spoken with in the clear.
    """

    hosts: tuple[str, ...]
    port: int
    keyspace: str
    user: str | None
    password: str | None
    replication: Mapping[str, str | int]
    consistency: str = "local_quorum"
    timeout: float = 5.0
    granularity: int = GRANULARITY
    data_centre: str | None = None
    tls: Tls | None = None

    def __str__(self) -> str:
        """Return it without the password, for texts."""
        return f"cassandra://{','.join(self.hosts)}:{self.port}/{self.keyspace}"


def parse_address(url: str) -> CassandraAddress:
    """Return what a URL says.

    Raises
    ------
    InvalidInput
        It is not of the form, or a setting is unknown or out of range. The text tells no password.
    """
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise InvalidInput(f"this is no URL of a Cassandra: {_FORM}") from error
    login, _, places = parts.netloc.rpartition("@")
    hosts, port = _hosts(places)
    keyspace = parts.path.removeprefix("/")
    if not _KEYSPACE.fullmatch(keyspace):
        raise InvalidInput(f"{keyspace!r} cannot name a keyspace: take small letters, digits and '_', a letter first")
    said = _settings(parts.query)
    user, _, password = login.partition(":")
    return CassandraAddress(
        hosts,
        port,
        keyspace,
        unquote(user) if login else None,
        unquote(password) if login else None,
        _replication(said.get("replication", str(min(3, len(hosts))))),
        _consistency(said.get("consistency", "local_quorum")),
        _number("timeout", said.get("timeout", "5"), 0.1, 600.0),
        int(_number("granularity", said.get("granularity", str(GRANULARITY)), 2, MOST_GRANULARITY)),
        _data_centre(said.get("data_centre")),
        _tls(said),
    )


def _hosts(places: str) -> tuple[tuple[str, ...], int]:
    hosts, ports = [], set()
    for place in places.split(","):
        bracketed = re.fullmatch(r"\[([0-9a-fA-F:.]+)\](?::(\d{1,5}))?", place)
        plain = re.fullmatch(r"([A-Za-z0-9_.-]+)(?::(\d{1,5}))?", place)
        match = bracketed or plain
        if match is None:
            raise InvalidInput(f"{place!r} is no host: {_FORM}")
        hosts.append(match[1])
        if match[2]:
            ports.add(int(match[2]))
    if len(ports) > 1 or not all(0 < port < 1 << 16 for port in ports):
        raise InvalidInput("all nodes of a Cassandra listen on one port, from 1 to 65535: write it once")
    return tuple(hosts), ports.pop() if ports else PORT


def _settings(query: str) -> dict[str, str]:
    said = dict(parse_qsl(query, keep_blank_values=True))
    if unknown := [name for name in said if name not in SETTINGS]:
        raise InvalidInput(f"unknown setting {unknown[0]!r} of a Cassandra; known: {', '.join(SETTINGS)}")
    return said


def _replication(text: str) -> dict[str, str | int]:
    if text.isdecimal() and 0 < int(text) < 100:
        return {"class": "SimpleStrategy", "replication_factor": int(text)}
    copies: dict[str, str | int] = {"class": "NetworkTopologyStrategy"}
    for part in text.split(","):
        centre, _, count = part.rpartition(":")
        if not (_DATA_CENTRE.fullmatch(centre) and count.isdecimal() and 0 < int(count) < 100):
            raise InvalidInput(
                f"replication is a number of copies, or such numbers by data centre (a:3,b:2): not {text!r}"
            )
        copies[centre] = int(count)
    return copies


def _consistency(text: str) -> str:
    if text.lower() not in CONSISTENCIES:
        raise InvalidInput(f"unknown consistency {text!r}; known: {', '.join(CONSISTENCIES)}")
    return text.lower()


def _data_centre(text: str | None) -> str | None:
    if text is not None and not _DATA_CENTRE.fullmatch(text):
        raise InvalidInput(f"{text!r} is no name of a data centre: take that which nodetool status tells")
    return text


def _tls(said: Mapping[str, str]) -> Tls | None:
    wanted = said.get("tls", "no").lower()
    files = [said.get(name) or None for name in ("ca", "certificate", "key")]
    if wanted not in TLS:
        raise InvalidInput(f"tls is one of {', '.join(TLS)}, not {wanted!r}")
    if wanted == "no" and any(files):
        raise InvalidInput("a ca, a certificate or a key is for tls: write tls=yes too")
    if files[2] and not files[1]:
        raise InvalidInput("a key goes with a certificate: write certificate= too")
    return None if wanted == "no" else Tls(wanted == "yes", *files)


def _number(name: str, text: str, least: float, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not least <= number <= most:
        raise InvalidInput(f"{name} is from {least:g} to {most:g}, not {text!r}")
    return number
