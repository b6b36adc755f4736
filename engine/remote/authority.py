"""Certificate authority of a cloud: issues certificates to machines, and checks them.

It is stored in the data folder of the cloud, so that certificates survive a restart. Only the last certificate issued
to a machine is valid: removing its file, or letting the machine join again, revokes the one before.
"""

import re
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from engine.processes.private_files import write_private
from engine.protocols.pinned import fingerprint
from engine.protocols.tls_identity import CLOUD_NAME, TlsIdentity
from engine.remote.certificates import (
    authority_certificate,
    common_name,
    issue,
    issue_for_cloud,
    key_pem,
    new_key,
    read_key,
    read_request,
)
from ppaas.errors import InvalidInput, NotPermitted

STANDBY = "@standby"
"""End of the names of standbys, which no machine has."""

NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9._-]{{0,63}}|[A-Za-z0-9][A-Za-z0-9._-]{{0,55}}{STANDBY}")
"""Names of machines and standbys; a common name has up to 64 characters (RFC 5280, ``ub-common-name``)."""


class Authority:
    """Issues certificates, and identifies their machines.

    Parameters
    ----------
    folder : Path
        Folder of its files; created, private to this user, if it does not exist.

    Raises
    ------
    InvalidInput
        The folder cannot be used.
    """

    def __init__(self, folder: Path) -> None:
        self._issued = folder / "issued"
        self._key_file, self._file = folder / "authority.key", folder / "authority.pem"
        self.identity = TlsIdentity.in_folder(folder, "cloud")
        try:
            self._issued.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not self.identity.certificate.exists():
                self._make()
            self._key = read_key(self._key_file.read_bytes())
            self.pem = self._file.read_bytes()
            self._certificate = x509.load_pem_x509_certificate(self.pem)
            own = x509.load_pem_x509_certificate(self.identity.certificate.read_bytes())
            self.fingerprint = fingerprint(own.public_bytes(Encoding.DER))
        except (OSError, ValueError) as error:
            raise InvalidInput(
                f"the certificate authority of the cloud cannot be read or created in {folder}: {error}"
            ) from error

    def _make(self) -> None:
        key, own = new_key(), new_key()
        certificate = authority_certificate(key, "ppaas")
        cloud = issue_for_cloud(CLOUD_NAME, own, certificate, key)
        write_private(self._key_file, key_pem(key))
        write_private(self._file, certificate.public_bytes(Encoding.PEM))
        write_private(self.identity.key, key_pem(own))
        # Written last: its existence shows that all files are complete.
        write_private(self.identity.certificate, cloud.public_bytes(Encoding.PEM))

    def has_issued(self, machine: str) -> bool:
        """Return whether a machine of that name has a certificate."""
        return self._path(machine).exists()

    def issue(self, machine: str, request: bytes) -> bytes:
        """Return a new certificate in PEM; it revokes the machine's earlier one.

        A standby's certificate is not recorded: each standby has the key of this authority.

        Raises
        ------
        InvalidInput
            The name or the request is invalid.
        """
        check_name(machine)
        certificate = issue(machine, read_request(request), self._certificate, self._key)
        pem = certificate.public_bytes(Encoding.PEM)
        if not machine.endswith(STANDBY):
            write_private(self._path(machine), pem)
        return pem

    def machine_of(self, certificate: bytes) -> str:
        """Return the name of the machine with this certificate, in DER. TLS has verified its signature already.

        Raises
        ------
        NotPermitted
            The certificate was revoked, or replaced by a newer one.
        """
        machine = common_name(x509.load_der_x509_certificate(certificate))
        if machine.endswith(STANDBY):
            return machine
        path = self._path(machine)
        known = x509.load_pem_x509_certificate(path.read_bytes()) if path.exists() else None
        if known is None or known.public_bytes(Encoding.DER) != certificate:
            raise NotPermitted(
                f"the certificate of machine {machine!r} is no longer valid: join again with a new ticket"
            )
        return machine

    def _path(self, machine: str) -> Path:
        return self._issued / f"{machine}.pem"


def check_name(machine: str) -> None:
    """Check the name of a machine.

    Raises
    ------
    InvalidInput
        The name is invalid.
    """
    if NAME.fullmatch(machine) is None:
        raise InvalidInput(
            f"{machine[:80]!r} is not a valid name of a machine: use 1 to 64 letters, digits, '.', '_' and '-', and a "
            "letter or digit first"
        )
