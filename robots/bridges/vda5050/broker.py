"""Address of an MQTT broker, and the login there."""

import os
import ssl
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self
from urllib.parse import unquote, urlsplit

from ppaas.errors import InvalidInput

PORTS = {"mqtt": 1883, "mqtts": 8883}

PASSWORD = "PPAAS_MQTT_PASSWORD"
"""Environment variable with the password."""

MAX_PASSWORD = 65535
"""Largest password of MQTT [bytes]."""


@dataclass(frozen=True, slots=True)
class Broker:
    """MQTT broker.

    Attributes
    ----------
    host : str
    port : int
    user : str or None
        Name for the login.
    password : str or None
    tls : SSLContext or None
        Certificates to trust; None without TLS.
    """

    host: str
    port: int
    user: str | None = None
    password: str | None = field(default=None, repr=False)
    tls: ssl.SSLContext | None = None

    @classmethod
    def parse(cls, url: str, password: str | None = None, ca_file: Path | None = None) -> Self:
        """Return the broker of a URL, ``mqtt://user@host:port`` or ``mqtts://…`` with TLS.

        Parameters
        ----------
        url : str
        password : str, optional
            Password of the user; it is not part of the URL, which other processes can read.
        ca_file : Path, optional
            Certificates in PEM to trust for mqtts, instead of the system's.

        Raises
        ------
        InvalidInput
            The URL has another form, or the file has no certificates.
        """
        try:
            parts = urlsplit(url)
            port = parts.port or PORTS.get(parts.scheme, 0)
        except ValueError as error:
            raise InvalidInput(f"the URL of the broker is not valid: {error}") from error
        if parts.password is not None:
            raise InvalidInput(f"give the password in {PASSWORD} or by --password-file: everybody can read the URL")
        if parts.scheme not in PORTS or not parts.hostname or parts.path.strip("/") or parts.query or parts.fragment:
            raise InvalidInput(f"the broker is mqtt://user@host:port, or mqtts:// with TLS, not {url!r}")
        user = unquote(parts.username) if parts.username else None
        return cls(parts.hostname, port, user, password, _tls(ca_file) if parts.scheme == "mqtts" else None)


def password_of(file: Path | None) -> str | None:
    """Return the password in the first line of a file, else from the environment, else None.

    Raises
    ------
    InvalidInput
        The file cannot be read.
    """
    if file is None:
        return os.environ.get(PASSWORD)
    try:
        with file.open(encoding="utf-8") as lines:
            return lines.readline(MAX_PASSWORD).rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"cannot read the password in {file}: {error}") from error


def _tls(ca_file: Path | None) -> ssl.SSLContext:
    try:
        return ssl.create_default_context(cafile=None if ca_file is None else str(ca_file))
    except OSError as error:
        raise InvalidInput(f"cannot read certificates from {ca_file}: {error}; give a file in PEM") from error
