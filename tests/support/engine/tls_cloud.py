"""Machines that have joined a certificate authority, without a cloud."""

from pathlib import Path

from engine.protocols.tls_identity import TlsIdentity
from engine.remote.authority import Authority, key_pem, new_key, request_pem


def joined(authority: Authority, folder: Path, machine: str) -> TlsIdentity:
    """Return the identity of a machine that has joined."""
    folder.mkdir(parents=True)
    identity = TlsIdentity.in_folder(folder, "machine")
    key = new_key()
    identity.key.write_bytes(key_pem(key))
    identity.certificate.write_bytes(authority.issue(machine, request_pem(key, machine)))
    identity.authority.write_bytes(authority.pem)
    return identity
