"""Who this machine is to others: a key, a certificate, and the authority by which it knows the others'."""

import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

CLOUD_NAME = "cloud.ppaas"
"""Whom the certificate of every cloud names; whose cloud it is says the authority that issued it."""

Purpose = Literal["control", "robot", "terms", "join"]
"""What a connection is for; told by ALPN (RFC 7301), so that one port serves all."""

PURPOSES: tuple[Purpose, ...] = ("control", "robot", "terms", "join")


@dataclass(frozen=True, slots=True)
class TlsIdentity:
    """Files in PEM.

    Parameters
    ----------
    key, certificate : Path
        Own.
    authority : Path
        Certificate of the authority of the cloud.
    """

    key: Path
    certificate: Path
    authority: Path

    @classmethod
    def in_folder(cls, folder: Path, name: str) -> "TlsIdentity":
        """Return the files of one in a folder."""
        return cls(folder / f"{name}.key", folder / f"{name}.pem", folder / "authority.pem")

    def server_context(self) -> ssl.SSLContext:
        """Return how the cloud takes connections.

        Who shows a certificate must have one of our authority; whoever shows none can only ask to join.
        """
        context = _strict(ssl.PROTOCOL_TLS_SERVER)
        self._show(context)
        context.verify_mode = ssl.CERT_OPTIONAL
        context.set_alpn_protocols(list(PURPOSES))
        return context

    def client_context(self, purpose: Purpose) -> ssl.SSLContext:
        """Return how a machine dials the cloud."""
        context = _strict(ssl.PROTOCOL_TLS_CLIENT)
        self._show(context)
        context.set_alpn_protocols([purpose])
        return context

    def _show(self, context: ssl.SSLContext) -> None:
        context.load_cert_chain(self.certificate, self.key)
        context.load_verify_locations(self.authority)


def stranger_context() -> ssl.SSLContext:
    """Return how somebody dials who has no certificate yet, and must compare the cloud's with what the ticket says."""
    context = _strict(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    context.set_alpn_protocols(["join"])
    return context


def _strict(protocol: int) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    return context
