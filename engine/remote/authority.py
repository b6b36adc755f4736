"""The authority of a cloud: it issues certificates to machines and knows which are good.

It is kept in the data folder of the cloud, so that machines stay known when the cloud is started again. A machine has
one good certificate, the last that was issued to it: who takes the file away, or lets the machine join anew, makes the
one before worth nothing.
"""

import re
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from engine.processes.private_files import write_private
from engine.protocols.tls_identity import CLOUD_NAME, TlsIdentity
from engine.remote.certificates import (
    authority_certificate,
    common_name,
    fingerprint,
    issue,
    issue_for_cloud,
    key_pem,
    new_key,
    read_key,
    read_request,
)
from ppaas.errors import InvalidInput, NotPermitted

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")
"""A machine's; a common name has up to 64 characters (RFC 5280, ``ub-common-name``)."""


class Authority:
    """Issues certificates, and tells whose one is.

    Parameters
    ----------
    folder : Path
        For its files; made with all in it, readable by this user alone, where it is not there.

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
            raise InvalidInput(f"the authority of the cloud cannot be read or made in {folder}: {error}") from error

    def _make(self) -> None:
        key, own = new_key(), new_key()
        certificate = authority_certificate(key, "ppaas")
        cloud = issue_for_cloud(CLOUD_NAME, own, certificate, key)
        write_private(self._key_file, key_pem(key))
        write_private(self._file, certificate.public_bytes(Encoding.PEM))
        write_private(self.identity.key, key_pem(own))
        # The last of them says that all are there.
        write_private(self.identity.certificate, cloud.public_bytes(Encoding.PEM))

    def has_issued(self, machine: str) -> bool:
        """Tell whether a machine of that name has a certificate."""
        return self._path(machine).exists()

    def issue(self, machine: str, request: bytes) -> bytes:
        """Return a certificate in PEM; the one that the machine had before is good no more.

        Raises
        ------
        InvalidInput
            The name cannot be in a certificate, or the request is none.
        """
        check_name(machine)
        certificate = issue(machine, read_request(request), self._certificate, self._key)
        pem = certificate.public_bytes(Encoding.PEM)
        write_private(self._path(machine), pem)
        return pem

    def machine_of(self, shown: bytes) -> str:
        """Return the name of the machine that showed a certificate, in DER; that it is of ours, TLS has seen to.

        Raises
        ------
        NotPermitted
            The machine was sent away, or has another one by now.
        """
        machine = common_name(x509.load_der_x509_certificate(shown))
        path = self._path(machine)
        known = x509.load_pem_x509_certificate(path.read_bytes()) if path.exists() else None
        if known is None or known.public_bytes(Encoding.DER) != shown:
            raise NotPermitted(f"the certificate of machine {machine!r} is good no more: have it join by a new ticket")
        return machine

    def _path(self, machine: str) -> Path:
        return self._issued / f"{machine}.pem"


def check_name(machine: str) -> None:
    """Make sure that a machine may be called so.

    Raises
    ------
    InvalidInput
        It may not.
    """
    if NAME.fullmatch(machine) is None:
        raise InvalidInput(f"a machine is named with 1 to 64 letters, digits, '.', '_' or '-', not {machine[:80]!r}")
