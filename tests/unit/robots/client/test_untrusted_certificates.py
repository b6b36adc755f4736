"""Certificates that clients do not trust, also those that only Python 3.13 and newer refuse."""

import ssl
from collections.abc import AsyncIterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from aiomqtt import MqttError
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.serialization import Encoding

from engine.remote import authority as certificates
from ppaas.errors import Unavailable
from robots.bridges.vda5050.mqtt_link import _words_of
from robots.client.connection import ConnectionOptions, open_socket
from robots.client.rest import RestClient
from tests.support.endpoints.serving import serve
from tests.support.network.certificates import TestAuthority


@pytest.fixture(autouse=True)
def _as_in_python_3_13(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check certificates as strictly as Python 3.13 does by default."""
    create = ssl.create_default_context

    def strict(*arguments: object, **options: object) -> ssl.SSLContext:
        context = create(*arguments, **options)  # type: ignore[arg-type]
        context.verify_flags |= ssl.VERIFY_X509_STRICT
        return context

    monkeypatch.setattr(ssl, "create_default_context", strict)
    monkeypatch.setattr(ssl, "_create_default_https_context", strict)


class LaxAuthority(TestAuthority):
    """Authority as old instructions make it: without the usage and the identifiers of its key."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        name, now = certificates._named("authority of a test"), datetime.now(UTC)
        made = x509.CertificateBuilder(name, name, self._key.public_key(), 1, now, now + timedelta(days=1))
        basic = x509.BasicConstraints(ca=True, path_length=None)
        self._certificate = made.add_extension(basic, critical=True).sign(self._key, hashes.SHA256())
        self.file.write_bytes(self._certificate.public_bytes(Encoding.PEM))


async def app(_scope: object, _receive: object, send: object) -> None:
    """Answer with an empty object."""
    await send({"type": "http.response.start", "status": 200, "headers": []})  # type: ignore[operator]
    await send({"type": "http.response.body", "body": b"{}"})  # type: ignore[operator]


@pytest.fixture(params=[TestAuthority, LaxAuthority])
def authority(request: pytest.FixtureRequest, tmp_path: Path) -> TestAuthority:
    made: TestAuthority = request.param(tmp_path)
    return made


@pytest.fixture
async def port(authority: TestAuthority) -> AsyncIterator[int]:
    """Serve by a certificate of the authority."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(*authority.issue("server"))
    async with serve(app, ssl_context_factory=lambda *_: context) as served:
        yield served


async def reasons(port: int) -> list[str]:
    """Return why the REST client and the WebSocket client do not connect."""
    found = []
    for attempt in (
        RestClient(f"https://127.0.0.1:{port}").get("/"),
        open_socket(f"wss://127.0.0.1:{port}/", {}, ConnectionOptions()),
    ):
        try:
            await attempt  # type: ignore[misc]
        except Unavailable as refusal:
            found.append(str(refusal))
    return found


async def test_certificates_of_the_project_pass_the_strict_checks(
    authority: TestAuthority, port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SSL_CERT_FILE", str(authority.file))
    if not isinstance(authority, LaxAuthority):
        assert await RestClient(f"https://127.0.0.1:{port}").get("/") == {}
        return
    refused = await reasons(port)
    assert len(refused) == 2
    for reason in refused:
        assert "is not trusted (" in reason and "key usage" in reason
        assert "Python 3.13 and newer" in reason and "keyUsage=critical,keyCertSign" in reason
        assert "check that a cloud runs" not in reason


async def test_an_unknown_authority_is_reported_with_the_option(port: int) -> None:
    refused = await reasons(port)
    assert len(refused) == 2
    assert all("is not trusted (" in each and "--ca-file or SSL_CERT_FILE" in each for each in refused)
    assert not any("Python 3.13" in each for each in refused)


def test_the_certificate_of_a_broker_is_reported_as_well() -> None:
    cause = ssl.SSLCertVerificationError()
    cause.verify_message = "CA cert does not include key usage extension"
    try:
        try:
            raise cause
        except OSError as error:
            raise MqttError(str(error)) from None  # as aiomqtt does
    except MqttError as refusal:
        assert "Python 3.13 and newer" in _words_of(refusal)
    assert _words_of(MqttError("refused")) == "refused"
