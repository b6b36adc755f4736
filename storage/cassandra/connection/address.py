"""Address and settings of a Cassandra cluster, as the URL of a store gives them.

``cassandra://user:password@host1,host2:9042/keyspace?replication=3&consistency=local_quorum&timeout=5&tls=yes``; only a
host and the keyspace are required. The driver discovers further nodes from the given ones; all nodes listen on one
port.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import SplitResult, parse_qsl, unquote, urlsplit

from ppaas.errors import InvalidInput
from ppaas.plans.encoding.granularity import GRANULARITY, MOST_GRANULARITY

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
    """TLS settings.

    Parameters
    ----------
    check_name : bool
        Whether a node's certificate must match its host name or IP address.
    ca : str or None
        PEM file with the certificate authorities of the nodes; the system's by default.
    certificate, key : str or None
        PEM files of the client certificate, if nodes require one; the key may be in the file of the certificate.
    """

    check_name: bool = True
    ca: str | None = None
    certificate: str | None = None
    key: str | None = None


@dataclass(frozen=True, slots=True)
class CassandraAddress:
    """Parsed URL of a Cassandra store.

    Parameters
    ----------
    hosts : tuple of str
        Contact points: host names or IP addresses.
    port : int
        Port of all nodes.
    keyspace : str
        Name of the keyspace; it is created if it is missing.
    user, password : str or None
        Credentials, if the cluster requires a login.
    replication : dict
        Replication map of CQL; used only to create the keyspace.
    consistency : str
        Consistency level of reads and writes: one of ``CONSISTENCIES``.
    timeout : float
        Time limit of one request [s].
    granularity : int
        Length from which segments of plans are shared, about [waypoints] (``ppaas.plans.encoding.granularity``).
    data_centre : str or None
        Local data centre; by default the first responding host's.
    tls : Tls or None
        None for unencrypted connections.
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
        """Return the URL without credentials, for messages."""
        return f"cassandra://{','.join(self.hosts)}:{self.port}/{self.keyspace}"


def parse_address(url: str) -> CassandraAddress:
    """Parse a URL.

    Raises
    ------
    InvalidInput
        The URL is malformed, or a setting is unknown or out of range. The message contains no password.
    """
    try:
        parts = _parts(url)
    except ValueError as error:
        raise InvalidInput(f"not a URL of a Cassandra cluster: {_FORM}") from error
    login, _, places = parts.netloc.rpartition("@")
    hosts, port = _hosts(places)
    keyspace = parts.path.removeprefix("/")
    if not _KEYSPACE.fullmatch(keyspace):
        raise InvalidInput(
            f"{keyspace!r} is not a valid keyspace: use lower-case letters, digits and '_', with a letter first"
        )
    settings = _settings(parts.query)
    user, _, password = login.partition(":")
    return CassandraAddress(
        hosts,
        port,
        keyspace,
        unquote(user) if login else None,
        unquote(password) if login else None,
        _replication(settings.get("replication", str(min(3, len(hosts))))),
        _consistency(settings.get("consistency", "local_quorum")),
        _number("timeout", settings.get("timeout", "5"), 0.1, 600.0),
        int(_number("granularity", settings.get("granularity", str(GRANULARITY)), 2, MOST_GRANULARITY)),
        _data_centre(settings.get("data_centre")),
        _tls(settings),
    )


def _parts(url: str) -> SplitResult:
    """Split a URL; newer Pythons refuse an address in brackets that is not the only host, so they see none."""
    parts = urlsplit(url.replace("[", "%5B").replace("]", "%5D"))
    return parts._replace(netloc=parts.netloc.replace("%5B", "[").replace("%5D", "]"))


def _hosts(places: str) -> tuple[tuple[str, ...], int]:
    hosts, ports = [], set()
    for place in places.split(","):
        bracketed = re.fullmatch(r"\[([0-9a-fA-F:.]+)\](?::(\d{1,5}))?", place)
        plain = re.fullmatch(r"([A-Za-z0-9_.-]+)(?::(\d{1,5}))?", place)
        match = bracketed or plain
        if match is None:
            raise InvalidInput(f"{place!r} is not a host: {_FORM}")
        hosts.append(match[1])
        if match[2]:
            ports.add(int(match[2]))
    if len(ports) > 1 or not all(0 < port < 1 << 16 for port in ports):
        raise InvalidInput("all nodes of a Cassandra cluster must listen on one port, from 1 to 65535: write it once")
    return tuple(hosts), ports.pop() if ports else PORT


def _settings(query: str) -> dict[str, str]:
    settings = dict(parse_qsl(query, keep_blank_values=True))
    if unknown := [name for name in settings if name not in SETTINGS]:
        raise InvalidInput(f"unknown setting {unknown[0]!r} of a Cassandra store; known: {', '.join(SETTINGS)}")
    return settings


def _replication(text: str) -> dict[str, str | int]:
    if text.isdecimal() and 0 < int(text) < 100:
        return {"class": "SimpleStrategy", "replication_factor": int(text)}
    copies: dict[str, str | int] = {"class": "NetworkTopologyStrategy"}
    for part in text.split(","):
        centre, _, count = part.rpartition(":")
        if not (_DATA_CENTRE.fullmatch(centre) and count.isdecimal() and 0 < int(count) < 100):
            raise InvalidInput(
                f"replication must be a number of replicas, or one for each data centre (a:3,b:2), not {text!r}"
            )
        copies[centre] = int(count)
    return copies


def _consistency(text: str) -> str:
    if text.lower() not in CONSISTENCIES:
        raise InvalidInput(f"unknown consistency {text!r}; known: {', '.join(CONSISTENCIES)}")
    return text.lower()


def _data_centre(text: str | None) -> str | None:
    if text is not None and not _DATA_CENTRE.fullmatch(text):
        raise InvalidInput(f"{text!r} is not the name of a data centre: see the output of nodetool status")
    return text


def _tls(settings: Mapping[str, str]) -> Tls | None:
    mode = settings.get("tls", "no").lower()
    files = [settings.get(name) or None for name in ("ca", "certificate", "key")]
    if mode not in TLS:
        raise InvalidInput(f"tls must be one of {', '.join(TLS)}, not {mode!r}")
    if mode == "no" and any(files):
        raise InvalidInput("ca, certificate and key need TLS: add tls=yes")
    if files[2] and not files[1]:
        raise InvalidInput("a key needs a certificate: add certificate=")
    return None if mode == "no" else Tls(mode == "yes", *files)


def _number(name: str, text: str, least: float, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not least <= number <= most:
        raise InvalidInput(f"{name} must be between {least:g} and {most:g}, not {text!r}")
    return number
