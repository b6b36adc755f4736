"""Redaction of what leaves a computer: secrets are planted in all forms, and none is left."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.cli.support.redaction import REMOVED, Redaction

SECRET = "h0rse-Battery_9"

PLANTED = [
    f"cassandra://ppaas:{SECRET}@db1,db2/keyspace",
    f"hdfs://user:pa@ss/{SECRET}@namenode:9870/maps",
    f"opened ws://ann:{SECRET}@hall-2:8500/?robot=tb1",
    f"GET /?robot=tb1&token={SECRET}&queue=1",
    f"GET /?ticket={SECRET} HTTP/1.1",
    f"Authorization: Bearer {SECRET}",
    f"authorization: Basic {SECRET}==",
    f"ppaas login ann --password {SECRET}",
    f"ppaas up --s3-secret={SECRET} --port 1",
    f'{{"password": "{SECRET} and more"}}',
    json.dumps({"message": json.dumps({"token": SECRET})}),
    f"password: '{SECRET} x'",
    f"admin_password={SECRET}",
    f"API_KEY={SECRET}",
    "token ppaas_0123456789abcdefghijklmnopqrstuvwxyz-_012345 is unknown".replace("0123456789abcdef", SECRET),
    f"ppaas machine join ppaas-join-{SECRET}{SECRET}",
    f"claims of eyJhbGciOiJFUzI1NiJ9.eyJzdWIiOiJ4In0.{SECRET}-x",
    f"-----BEGIN EC PRIVATE KEY-----\n{SECRET}\n-----END EC PRIVATE KEY-----",
    json.dumps(f"-----BEGIN PRIVATE KEY-----\n{SECRET}\n-----END PRIVATE KEY-----"),
    f"-----BEGIN PRIVATE KEY-----\n{SECRET}",
]

HARMLESS = [
    "127.0.0.1: GET /v1/robots/tb1/goals/g7: 401 not-authenticated",
    "serving at http://127.0.0.1:8500",
    "cassandra://db1/keyspace",
    "the password of user 'admin' is in /srv/var/admin-password",
    "machine local joined with 2 cores and 0 containers",
    "--password-file /run/secrets/admin",
]


@pytest.mark.parametrize("text", PLANTED)
def test_no_secret_is_left_in_a_text(text: str) -> None:
    redacted = Redaction().text(text)
    assert SECRET not in redacted and REMOVED in redacted


@pytest.mark.parametrize("text", PLANTED)
def test_no_secret_is_left_in_a_value(text: str) -> None:
    assert SECRET not in json.dumps(Redaction().value({"lines": [{"text": text}]}))


@pytest.mark.parametrize("text", HARMLESS)
def test_other_text_is_left_as_it_is(text: str) -> None:
    assert Redaction().text(text) == text


@pytest.mark.parametrize("name", ["token", "PPAAS_TOKEN", "admin_password", "secret", "api_key", "private_key"])
def test_a_member_named_as_a_secret_is_removed(name: str) -> None:
    assert Redaction().value({name: "x y z"}) == {name: REMOVED}


def test_other_members_stay() -> None:
    value = {"password_file": "/run/admin", "kernels": 7, "token": None, "robots": ["tb1"], "keep": 1.5}
    assert Redaction().value(value) == value


@given(st.text("0123456789abcdef", min_size=16), st.text(), st.text())
def test_a_known_secret_is_removed_wherever_it_is(secret: str, before: str, after: str) -> None:
    assert secret not in Redaction([secret]).text(before + secret + after)


def test_a_known_secret_that_is_a_part_of_words_is_left() -> None:
    assert Redaction(["a", ""]).text("a map") == "a map"
