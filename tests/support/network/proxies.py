"""Proxies of others, run with the configurations that the documents show."""

import base64
import hashlib
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from cryptography.x509 import load_pem_x509_certificate

from tests.support.network.certificates import TestAuthority

HOST = "localhost"
START_TIMEOUT = 20.0


@dataclass(frozen=True)
class Certificate:
    """Certificate of this computer: files with its authority, with the certificate, with its key, and with both."""

    authority: Path
    certificate: Path
    key: Path
    both: Path
    key_hash: str
    """Base64 of the SHA-256 hash of the public key, by which browsers pin it."""


def certificate_in(folder: Path) -> Certificate:
    """Create a certificate."""
    authority, both = TestAuthority(folder), folder / "both.pem"
    certificate, key = authority.issue("proxy")
    both.write_bytes(certificate.read_bytes() + key.read_bytes())
    public = load_pem_x509_certificate(certificate.read_bytes()).public_key()
    pinned = hashlib.sha256(public.public_bytes(Encoding.DER, PublicFormat.SubjectPublicKeyInfo)).digest()
    return Certificate(authority.file, certificate, key, both, base64.b64encode(pinned).decode())


def program(name: str) -> str:
    """Return the path of a proxy, or skip the test."""
    return shutil.which(name, path=f"/usr/sbin:/usr/bin:{os.environ['PATH']}") or pytest.skip(
        f"no {name}: install Debian's package (make proxies)"
    )


@dataclass(frozen=True)
class RunningProxy:
    """Proxy with its name, its port, its folder, which has its log, and its certificate."""

    name: str
    port: int
    folder: Path
    certificate: Certificate

    @property
    def url(self) -> str:
        """URL of the cloud behind it."""
        return f"https://{HOST}:{self.port}/ppaas"

    @property
    def log(self) -> str:
        """Log of requests and errors."""
        return "".join(file.read_text() for file in sorted(self.folder.glob("*.log")))


@contextmanager
def running_proxy(name: str, shown: str, cloud: str, folder: Path) -> Iterator[RunningProxy]:
    """Run a proxy by the configuration of a document.

    Parameters
    ----------
    name : str
        ``nginx``, ``caddy`` or ``haproxy``.
    shown : str
        Configuration as shown; its addresses and paths are replaced by those of this computer.
    cloud : str
        Host and port of the cloud.
    folder : Path
        Folder for its files.
    """
    command = program(name)
    files = certificate_in(folder)
    port = _free_port()
    config = folder / "config"
    config.write_text(_complete(name, _replaced(shown, files, port, cloud), folder))
    with (folder / "output.log").open("wb") as output:
        process = subprocess.Popen(_command(name, command, config, folder), stdout=output, stderr=output)
    proxy = RunningProxy(name, port, folder, files)
    try:
        _wait_until_listening(proxy, process)
        yield proxy
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _replaced(shown: str, files: Certificate, port: int, cloud: str) -> str:
    for old, new in (
        ("/etc/ssl/robots.example.pem", str(files.certificate)),
        ("/etc/ssl/robots.example.key", str(files.key)),
        ("/etc/ssl/robots.example.both.pem", str(files.both)),
        ("listen 443", f"listen 127.0.0.1:{port}"),
        ("bind :443", f"bind 127.0.0.1:{port}"),
        ("robots.example {", f"{HOST}:{port} {{"),
        ("robots.example", HOST),
        ("127.0.0.1:8500", cloud),
    ):
        shown = shown.replace(old, new)
    return shown


def _complete(name: str, shown: str, folder: Path) -> str:
    """Return a whole configuration: the part that a document shows, and what a test needs besides."""
    if name == "nginx":
        temporary = "".join(
            f"{kind}_temp_path {folder}/{kind};\n" for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
        )
        return (
            f"user root;\ndaemon off;\nworker_processes 1;\npid {folder}/pid;\nerror_log {folder}/error.log;\n"
            f"events {{}}\nhttp {{\naccess_log {folder}/access.log;\n{temporary}{shown}\n}}\n"
        )
    if name == "caddy":
        return f"{{\n\tadmin off\n\tauto_https disable_redirects\n\tlog {{\n\t\tlevel ERROR\n\t}}\n}}\n{shown}"
    return f"global\n    log stdout format raw local0\n\n{shown}".replace("defaults\n", "defaults\n    log global\n")


def _command(name: str, command: str, config: Path, folder: Path) -> list[str]:
    return {
        "nginx": [command, "-p", str(folder), "-c", str(config)],
        "caddy": [command, "run", "--config", str(config), "--adapter", "caddyfile"],
        "haproxy": [command, "-db", "-f", str(config)],
    }[name]


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
        return port


def _wait_until_listening(proxy: RunningProxy, process: subprocess.Popen[bytes]) -> None:
    deadline = time.monotonic() + START_TIMEOUT
    while True:
        try:
            socket.create_connection(("127.0.0.1", proxy.port), timeout=1).close()
            return
        except OSError:
            if process.poll() is not None or time.monotonic() > deadline:
                raise AssertionError(f"{proxy.name} did not start:\n{proxy.log}") from None
            time.sleep(0.05)
