"""TLS identity of a process: a key, a certificate, and the certificate of the authority that signed it."""

import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

CLOUD_NAME = "cloud.ppaas"
"""Name in the certificate of every cloud; clouds differ in the authority that issued it."""

Purpose = Literal["control", "robot", "terms", "join", "standby", "endpoint"]
"""Purpose of a connection, sent as its ALPN protocol (RFC 7301), so that one port serves all purposes."""

PURPOSES: tuple[Purpose, ...] = ("control", "robot", "terms", "join", "standby", "endpoint")


@dataclass(frozen=True, slots=True)
class TlsIdentity:
    """Files of a TLS identity, in PEM.

    Parameters
    ----------
    key, certificate : Path
        Key and certificate of this process.
    authority : Path
        Certificate of the cloud's authority.
    """

    key: Path
    certificate: Path
    authority: Path

    @classmethod
    def in_folder(cls, folder: Path, name: str) -> "TlsIdentity":
        """Return the identity of this name in a folder."""
        return cls(folder / f"{name}.key", folder / f"{name}.pem", folder / "authority.pem")

    def server_context(self) -> ssl.SSLContext:
        """Return the TLS settings of the cloud as a server.

        A client certificate must be signed by our authority. A client without one can only request to join.
        """
        context = _strict(ssl.PROTOCOL_TLS_SERVER)
        self._load_files(context)
        context.verify_mode = ssl.CERT_OPTIONAL
        context.set_alpn_protocols(list(PURPOSES))
        return context

    def client_context(self, purpose: Purpose) -> ssl.SSLContext:
        """Return the TLS settings of a machine that dials the cloud."""
        context = _strict(ssl.PROTOCOL_TLS_CLIENT)
        self._load_files(context)
        context.set_alpn_protocols([purpose])
        return context

    def pinning_context(self, purpose: Purpose) -> ssl.SSLContext:
        """Return the TLS settings of a machine that dials a server which it knows by its fingerprint."""
        context = _any_server(purpose)
        context.load_cert_chain(self.certificate, self.key)
        return context

    def _load_files(self, context: ssl.SSLContext) -> None:
        context.load_cert_chain(self.certificate, self.key)
        context.load_verify_locations(self.authority)


def stranger_context() -> ssl.SSLContext:
    """Return the TLS settings of a machine without a certificate.

    It must compare the fingerprint of the cloud's certificate with its ticket.
    """
    return _any_server("join")


def _any_server(purpose: Purpose) -> ssl.SSLContext:
    context = _strict(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    context.set_alpn_protocols([purpose])
    return context


def _strict(protocol: int) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    return context
