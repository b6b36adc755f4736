"""Certificates of servers for tests, issued by an authority of the test."""

import ipaddress
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.serialization import Encoding

from engine.remote import authority


class TestAuthority:
    """Authority that issues certificates for localhost and 127.0.0.1; ``file`` has its own certificate."""

    __test__ = False

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._key = authority.new_key()
        self._certificate = authority.authority_certificate(self._key, "authority of a test")
        self.file = folder / "authority.pem"
        self.file.write_bytes(self._certificate.public_bytes(Encoding.PEM))

    def issue(self, name: str) -> tuple[Path, Path]:
        """Return the files of a new certificate and of its key; they replace those of the same name."""
        key = authority.new_key()
        address = x509.IPAddress(ipaddress.ip_address("127.0.0.1"))
        hosts = x509.SubjectAlternativeName([x509.DNSName("localhost"), address])
        builder = authority._begin(authority._named(name), "authority of a test", key.public_key(), self._key, ca=False)
        made = builder.add_extension(hosts, critical=False).sign(self._key, hashes.SHA256())
        files = self._folder / f"{name}.pem", self._folder / f"{name}.key"
        files[0].write_bytes(made.public_bytes(Encoding.PEM))
        files[1].write_bytes(authority.key_pem(key))
        return files
