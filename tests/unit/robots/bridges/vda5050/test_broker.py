"""Addresses of MQTT brokers."""

import asyncio
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, Unavailable
from robots.bridges.vda5050.broker import PASSWORD, Broker, password_of
from robots.bridges.vda5050.mqtt_link import Outbox, Outgoing


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


def of(topic: str, payload: bytes = b"") -> Outgoing:
    return Outgoing(topic, payload)


async def taken(outbox: Outbox) -> list[tuple[str, bytes]]:
    return [((one := await outbox.next()).topic, one.payload) for _ in range(len(outbox))]


async def test_messages_leave_in_order() -> None:
    outbox = Outbox()
    for payload in (b"1", b"2"):
        outbox.put(of("order", payload))
    outbox.put_newest(of("state", b"3"))
    assert await taken(outbox) == [("order", b"1"), ("order", b"2"), ("state", b"3")]


async def test_the_newest_message_of_a_topic_replaces_the_others() -> None:
    outbox = Outbox()
    for payload in (b"1", b"2"):
        outbox.put_newest(of("state", payload))
        outbox.put_newest(of("visualization", payload))
    assert await taken(outbox) == [("state", b"2"), ("visualization", b"2")]
    assert outbox.dropped == 2


async def test_a_full_outbox_says_so() -> None:
    outbox = Outbox(capacity=2)
    outbox.put(of("order"))
    outbox.put(of("order"))
    with pytest.raises(Unavailable, match="broker"):
        outbox.put(of("order"))
    outbox.put_newest(of("state"))
    assert (len(outbox), outbox.dropped) == (2, 1)


async def test_a_message_that_was_not_sent_comes_first_again() -> None:
    outbox = Outbox()
    outbox.put(of("order", b"1"))
    outbox.put(of("order", b"2"))
    outbox.put_back(await outbox.next())
    assert await taken(outbox) == [("order", b"1"), ("order", b"2")]


async def test_an_older_message_does_not_come_back_beside_a_newer() -> None:
    outbox = Outbox()
    outbox.put_newest(of("state", b"1"))
    old = await outbox.next()
    outbox.put_newest(of("state", b"2"))
    outbox.put_back(old)
    assert await taken(outbox) == [("state", b"2")]


async def test_the_sender_waits_for_a_message() -> None:
    outbox = Outbox()
    waiting = asyncio.create_task(outbox.next())
    await asyncio.sleep(0)
    assert not waiting.done()
    outbox.put(of("order"))
    assert (await waiting).topic == "order"
