"""Certificate authority of a cloud: issues certificates to machines, and checks them.

It is stored in the data folder of the cloud, so that certificates survive a restart. Only the last certificate issued
to a machine is valid: removing its file, or letting the machine join again, revokes the one before.

Keys are on the curve P-256. A machine's certificate is valid for clients only, so that no machine can impersonate the
cloud.
"""

import datetime
import re
from pathlib import Path

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, load_pem_private_key
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from engine.processes.private_files import write_private
from engine.protocols.sockets import fingerprint
from engine.protocols.tls_identity import CLOUD_NAME, TlsIdentity
from ppaas.errors import InvalidInput, NotPermitted

# -- keys and certificates ---------------------------------------------------------------------------------------------

LIFETIME = datetime.timedelta(days=3650)

SLACK = datetime.timedelta(days=1)
"""Tolerance for a clock of another host that is slow."""

Key = ec.EllipticCurvePrivateKey


def new_key() -> Key:
    """Return a new private key."""
    return ec.generate_private_key(ec.SECP256R1())


def key_pem(key: Key) -> bytes:
    """Return a private key as PKCS #8 in PEM, not encrypted."""
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def read_key(pem: bytes) -> Key:
    """Read a private key written by ``key_pem``."""
    key = load_pem_private_key(pem, None)
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise InvalidInput("the private key is not on an elliptic curve, so this program did not create it")
    return key


def authority_certificate(key: Key, name: str) -> x509.Certificate:
    """Return the self-signed certificate of an authority."""
    made = _begin(_named(name), name, key.public_key(), key, ca=True)
    usage = x509.KeyUsage(
        digital_signature=True, key_cert_sign=True, crl_sign=True, content_commitment=False, key_encipherment=False,
        data_encipherment=False, key_agreement=False, encipher_only=False, decipher_only=False,
    )  # fmt: skip
    return made.add_extension(usage, critical=True).sign(key, hashes.SHA256())


def issue(name: x509.Name, public: ec.EllipticCurvePublicKey, issuer: x509.Certificate, key: Key) -> x509.Certificate:
    """Return the certificate of a machine, valid for clients only."""
    made = _begin(name, common_name(issuer), public, key, ca=False)
    usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.CLIENT_AUTH])
    return made.add_extension(usage, critical=False).sign(key, hashes.SHA256())


def issue_for_cloud(name: str, own: Key, issuer: x509.Certificate, key: Key) -> x509.Certificate:
    """Return the certificate of the cloud, which clients verify by this name."""
    made = _begin(_named(name), common_name(issuer), own.public_key(), key, ca=False)
    usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH])
    dialled = x509.SubjectAlternativeName([x509.DNSName(name)])
    return made.add_extension(usage, critical=False).add_extension(dialled, critical=False).sign(key, hashes.SHA256())


def self_signed(name: str, own: Key) -> bytes:
    """Return the certificate of a server that its clients know by its fingerprint, in PEM."""
    usage = x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH])
    made = _begin(_named(name), name, own.public_key(), own, ca=False)
    return made.add_extension(usage, critical=False).sign(own, hashes.SHA256()).public_bytes(Encoding.PEM)


def request_pem(key: Key, name: str) -> bytes:
    """Return a certificate signing request (PKCS #10), so that the key itself never leaves its machine."""
    builder = x509.CertificateSigningRequestBuilder().subject_name(_named(name))
    return builder.sign(key, hashes.SHA256()).public_bytes(Encoding.PEM)


def read_request(pem: bytes) -> ec.EllipticCurvePublicKey:
    """Return the public key of a certificate signing request.

    Raises
    ------
    InvalidInput
        The request is invalid, or not signed with its key.
    """
    try:
        request = x509.load_pem_x509_csr(pem)
        public = request.public_key()
        if not isinstance(public, ec.EllipticCurvePublicKey) or not request.is_signature_valid:
            raise InvalidInput("the certificate request must have a key on an elliptic curve, and be signed with it")
    except (ValueError, InvalidSignature) as error:
        raise InvalidInput(f"not a certificate signing request: {error}") from error
    return public


def common_name(certificate: x509.Certificate) -> str:
    """Return the common name of a certificate's subject."""
    (attribute,) = certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    return str(attribute.value)


def _named(name: str, unit: str = "") -> x509.Name:
    common = x509.NameAttribute(NameOID.COMMON_NAME, name)
    return x509.Name([common, x509.NameAttribute(NameOID.ORGANIZATIONAL_UNIT_NAME, unit)] if unit else [common])


def _begin(
    name: x509.Name, issuer: str, public: ec.EllipticCurvePublicKey, key: Key, *, ca: bool
) -> x509.CertificateBuilder:
    """Return a certificate to be signed with ``key``, with the identifiers of keys that RFC 5280 demands."""
    now = datetime.datetime.now(datetime.UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(_named(issuer))
        .public_key(public)
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - SLACK)
        .not_valid_after(now + LIFETIME)
        .add_extension(x509.BasicConstraints(ca=ca, path_length=0 if ca else None), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(key.public_key()), critical=False)
    )


# -- authority ---------------------------------------------------------------------------------------------------------

STANDBY = "@standby"
"""End of the names of standbys, which no machine has."""

NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9._-]{{0,63}}|[A-Za-z0-9][A-Za-z0-9._-]{{0,55}}{STANDBY}")
"""Names of machines and standbys; a common name has up to 64 characters (RFC 5280, ``ub-common-name``)."""

BY_SECRET = "joined with a secret"
"""Organizational unit in the certificate of a machine that joined with a secret, not with a ticket."""


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

    def has_joined_by_secret(self, machine: str) -> bool:
        """Return whether the certificate of a machine was issued for a join secret."""
        path = self._path(machine)
        known = x509.load_pem_x509_certificate(path.read_bytes()) if path.exists() else None
        return known is not None and bool(known.subject.get_attributes_for_oid(NameOID.ORGANIZATIONAL_UNIT_NAME))

    def issue(self, machine: str, request: bytes, *, by_secret: bool = False) -> bytes:
        """Return a new certificate in PEM; it revokes the machine's earlier one.

        A standby's certificate is not recorded: each standby has the key of this authority. ``by_secret`` notes in it
        that the machine joined with a secret.

        Raises
        ------
        InvalidInput
            The name or the request is invalid.
        """
        check_name(machine)
        name = _named(machine, BY_SECRET if by_secret else "")
        certificate = issue(name, read_request(request), self._certificate, self._key)
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
