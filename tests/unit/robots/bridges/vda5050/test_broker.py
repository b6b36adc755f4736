"""Addresses of MQTT brokers."""

from pathlib import Path

import pytest

from ppaas.errors import InvalidInput
from robots.bridges.vda5050.broker import PASSWORD, Broker, password_of


def test_urls_name_host_port_and_user() -> None:
    broker = Broker.parse("mqtt://fleet%40hall@broker.local:1884", "secret")
    assert (broker.host, broker.port, broker.user, broker.password) == ("broker.local", 1884, "fleet@hall", "secret")
    assert broker.tls is None
    assert "secret" not in repr(broker)


def test_ports_are_those_of_mqtt() -> None:
    assert Broker.parse("mqtt://broker").port == 1883
    secured = Broker.parse("mqtts://broker/")
    assert secured.port == 8883 and secured.tls is not None and secured.tls.check_hostname


@pytest.mark.parametrize(
    "url", ["broker", "http://broker", "mqtt://", "mqtt://broker/topic", "mqtt://broker:port", "mqtt://[::1"]
)
def test_other_urls_are_refused(url: str) -> None:
    with pytest.raises(InvalidInput, match="broker"):
        Broker.parse(url)


def test_a_password_in_the_url_is_refused_and_not_repeated() -> None:
    with pytest.raises(InvalidInput, match=PASSWORD) as refused:
        Broker.parse("mqtt://user:secret@broker")
    assert "secret" not in str(refused.value)


def test_a_file_without_certificates_is_refused(tmp_path: Path) -> None:
    (tmp_path / "ca.pem").write_text("nothing")
    with pytest.raises(InvalidInput, match=r"cannot read certificates from .*ca\.pem"):
        Broker.parse("mqtts://broker", ca_file=tmp_path / "ca.pem")


def test_passwords_come_from_a_file_or_the_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(PASSWORD, raising=False)
    assert password_of(None) is None
    monkeypatch.setenv(PASSWORD, "of the environment")
    assert password_of(None) == "of the environment"
    (tmp_path / "password").write_text("of the file\n")
    assert password_of(tmp_path / "password") == "of the file"
    with pytest.raises(InvalidInput, match="cannot read the password"):
        password_of(tmp_path / "missing")
