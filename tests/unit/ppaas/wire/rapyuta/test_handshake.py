"""Handshake of robots of 2013."""

import hashlib
import json
from urllib.parse import parse_qsl

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.wire.rapyuta.handshake import answer_master, is_digest, parse_login
from ppaas.wire.rapyuta.tags import MAX_TAG, check_tag, split_address


def _pairs(query: str) -> list[tuple[str, str]]:
    return parse_qsl(query, keep_blank_values=True)


URL = "ws://cloud:9010/"


def test_a_current_client_gets_the_address() -> None:
    answer = answer_master(_pairs("userID=ann&version=20130902"), URL)
    assert (answer.status, json.loads(answer.body)) == (200, {"url": URL})
    assert answer.media_type.startswith("application/json")


def test_an_older_client_is_told_the_newest_version() -> None:
    answer = answer_master(_pairs("version=20130415&userID=ann"), URL)
    assert json.loads(answer.body) == {"url": URL, "current": "20130902"}


@pytest.mark.parametrize(
    ("query", "status", "text"),
    [
        ("userID=ann", 400, "missing parameter: 'version'"),
        ("version=20130902", 400, "missing parameter: 'userID'"),
        ("", 400, "missing"),
        ("userID=&version=20130902", 400, "missing"),
        ("userID=a&userID=b&version=20130902", 400, "'userID' has to be unique"),
        ("userID=a&version=1&version=2", 400, "'version' has to be unique"),
        ("userID=a&version=20130414", 410, "20130415"),
        ("userID=a&version=20140101", 501, "20130902"),
    ],
)
def test_other_requests_to_the_master_are_refused_as_text(query: str, status: int, text: str) -> None:
    answer = answer_master(_pairs(query), URL)
    assert answer.status == status
    assert text in answer.body
    assert answer.media_type.startswith("text/plain")


@given(st.lists(st.tuples(st.sampled_from(["userID", "version", "x"]), st.text(max_size=9)), max_size=4))
def test_the_master_answers_any_query(query: list[tuple[str, str]]) -> None:
    assert answer_master(query, URL).status in (200, 400, 410, 501)


def test_a_login_has_user_robot_and_password() -> None:
    login = parse_login(_pairs("userID=ann&robotID=tb1&password=ab%20c"))
    assert (login.user, login.robot, login.password) == ("ann", "tb1", "ab c")


@pytest.mark.parametrize(
    "query",
    ["userID=ann&robotID=tb1", "userID=a&robotID=1&password=x", "userID=a&robotID=t&robotID=t&password=x", ""],
)
def test_incomplete_logins_are_refused(query: str) -> None:
    with pytest.raises(InvalidInput):
        parse_login(_pairs(query))


def test_a_hash_is_recognized_by_its_form() -> None:
    assert is_digest(hashlib.sha256(b"x").hexdigest())
    assert is_digest(hashlib.sha256(b"x").hexdigest().upper())
    assert not is_digest("ppaas_" + "a" * 58)
    assert not is_digest("a" * 63)


@pytest.mark.parametrize("tag", ["c1", "A_b9", "x", "Z" * MAX_TAG])
def test_a_letter_followed_by_letters_digits_and_underscores_is_a_tag(tag: str) -> None:
    assert check_tag("containerTag", tag) == tag


@pytest.mark.parametrize("tag", ["", "1c", "_c", "a-b", "a/b", "a b", "ä", "a\n", "Z" * (MAX_TAG + 1)])
def test_other_texts_are_no_tags(tag: str) -> None:
    with pytest.raises(InvalidInput, match="is not valid"):
        check_tag("containerTag", tag)


def test_an_address_has_the_tags_of_endpoint_and_interface() -> None:
    assert split_address("tagA", "c1/req") == ("c1", "req")


@pytest.mark.parametrize("text", ["c1", "/req", "c1/", "c1/a/b", ""])
def test_other_texts_are_no_addresses(text: str) -> None:
    with pytest.raises(InvalidInput, match="tagA"):
        split_address("tagA", text)
