"""The person whom a token is about: name, groups and role."""

import dataclasses
from typing import Any

import pytest

from endpoints.oidc.person import groups_of, person_of
from endpoints.oidc.settings import OidcSettings
from ppaas.errors import NotAuthenticated, NotPermitted
from storage.names import is_name

SETTINGS = OidcSettings(
    issuer="https://login.example", client_id="ppaas", cloud_url="https://cloud.example",
    roles=(("staff", "user"), ("operators", "admin")),
)  # fmt: skip
CLAIMS = {"iss": "https://login.example", "sub": "7", "preferred_username": "ann", "groups": ["staff"]}


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("ann", "ann"),
        ("ann@lab.example", "ann-lab.example"),
        ("LAB\\ann lee", "LAB-ann-lee"),
        ("..ann", "ann"),
        ("x" * 99, "x" * 64),
        ("Ånn", "nn"),
    ],
)
def test_a_name_has_the_characters_of_a_user(given: str, name: str) -> None:
    assert person_of(CLAIMS | {"preferred_username": given}, SETTINGS).name == name
    assert is_name(name)


@pytest.mark.parametrize("given", ["", "漢字", "@", None, 7, ["ann"]])
def test_a_person_without_a_name_is_refused(given: Any) -> None:
    with pytest.raises(NotAuthenticated, match="--oidc-username-claim"):
        person_of(CLAIMS | {"preferred_username": given}, SETTINGS)


def test_a_program_has_the_name_of_its_client_if_it_has_no_other() -> None:
    claims = CLAIMS | {"preferred_username": None, "azp": "fleet"}
    assert person_of(claims, SETTINGS, is_program=True).name == "fleet"
    assert person_of(claims | {"client_id": "drone"}, SETTINGS, is_program=True).name == "drone"


@pytest.mark.parametrize("verified", [False, None, "true", 1])
def test_an_address_that_is_not_verified_is_no_name(verified: Any) -> None:
    settings = dataclasses.replace(SETTINGS, username_claim="email")
    with pytest.raises(NotAuthenticated, match="not verified"):
        person_of(CLAIMS | {"email": "ann@lab.example", "email_verified": verified}, settings)


@pytest.mark.parametrize(
    ("claims", "name", "groups"),
    [
        ({"groups": ["a", "b", 7, None]}, "groups", {"a", "b"}),
        ({"groups": "a"}, "groups", {"a"}),
        ({"groups": {"a": 1}}, "groups", set()),
        ({}, "groups", set()),
        ({"realm_access": {"roles": ["a"]}}, "realm_access.roles", {"a"}),
        ({"realm_access": ["roles"]}, "realm_access.roles", set()),
        ({"https://x.example/groups": ["a"]}, "https://x.example/groups", {"a"}),
    ],
)
def test_groups_are_texts_in_a_claim_or_at_a_path(claims: dict[str, Any], name: str, groups: set[str]) -> None:
    assert groups_of(claims, name) == groups


def test_the_highest_role_of_the_groups_counts_and_none_is_refused() -> None:
    assert person_of(CLAIMS | {"groups": ["staff", "operators"]}, SETTINGS).role == "admin"
    assert person_of(CLAIMS, SETTINGS).role == "user"
    for groups in (["Staff"], ["*"], [], None):
        with pytest.raises(NotPermitted, match="none of your groups"):
            person_of(CLAIMS | {"groups": groups}, SETTINGS)
