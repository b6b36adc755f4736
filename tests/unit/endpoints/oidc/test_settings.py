"""Options of the login with an identity provider: whole, safe, and from a file."""

import argparse
from pathlib import Path

import pytest

from endpoints.cli import oidc_options
from endpoints.cli.settings_tree import TABLES
from endpoints.oidc import settings
from endpoints.oidc.settings import OidcSettings, provider_settings
from endpoints.settings.effective import SettingsTree
from ppaas.errors import InvalidInput

ISSUER = "https://login.example/realms/lab"
WHOLE = [
    "--oidc-issuer",
    ISSUER,
    "--oidc-client-id",
    "ppaas",
    "--oidc-cloud-url",
    "https://cloud.example/",
    "--oidc-role",
]


def parsed(*words: str) -> OidcSettings | None:
    parser = argparse.ArgumentParser(exit_on_error=False)
    oidc_options.add(parser)
    return provider_settings(parser.parse_args(words))


def test_without_options_there_is_no_provider() -> None:
    assert parsed() is None
    assert parsed("--oidc-leeway", "10") is None


def test_the_options_make_the_settings(tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("x")
    found = parsed(*WHOLE, "a=b=admin", "--oidc-role", "*=user", "--oidc-client-secret-file", str(tmp_path / "secret"))
    assert found is not None
    assert found.roles == (("a=b", "admin"), ("*", "user"))
    assert (found.redirect, found.shown_name) == ("https://cloud.example/dashboard/", "login.example")
    assert (found.scope, found.allowed_algorithms) == ("openid profile", settings.USUAL_ALGORITHMS)
    assert found.role_of(frozenset()) == "user" and found.role_of(frozenset({"a=b", "c"})) == "admin"


def test_openid_is_asked_for_whatever_else_is() -> None:
    found = parsed(*WHOLE, "*=user", "--oidc-scope", "groups", "--oidc-algorithm", "ES512")
    assert found is not None
    assert (found.scope, found.allowed_algorithms) == ("openid groups", ("ES512",))


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--oidc-issuer", ISSUER], "--oidc-client-id, --oidc-cloud-url, --oidc-role"),
        (WHOLE[:-1], r"'\*=user' lets in everybody"),
        (["--oidc-audience", "api"], "--oidc-issuer"),
        ([*WHOLE, "*=user", "--oidc-audience", "ppaas"], "must not be the client"),
        ([*WHOLE, "*=user", "--oidc-client-secret-file", "/nowhere"], "cannot read the secret"),
        ([*WHOLE, "*=user", "--oidc-client-secret-file", "/dev/null"], "is empty"),
    ],
)
def test_settings_that_are_not_whole_are_refused(words: list[str], why: str) -> None:
    with pytest.raises(InvalidInput, match=why):
        parsed(*words)


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settings, "find_spec", lambda _: None)
    with pytest.raises(InvalidInput, match=r"needs the extra oidc: .*\[cloud,oidc\]"):
        parsed(*WHOLE, "*=user")


@pytest.mark.parametrize(
    "url",
    ["login.example", "http://login.example", "ftp://x", "https://", "https://u:p@x", "https://x#y", "https://x:0",
     "https://x y", "https://x/?a=b", "javascript:alert(1)", "https://[", ""],
)  # fmt: skip
def test_an_issuer_that_others_could_read_or_that_is_no_url_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput):
        settings.issuer_url(url)


@pytest.mark.parametrize(
    "url", [ISSUER, f"{ISSUER}/", "http://127.0.0.1:8080/realms/lab", "http://[::1]", "http://localhost:1"]
)
def test_an_issuer_stays_as_it_is(url: str) -> None:
    assert settings.issuer_url(url) == url


@pytest.mark.parametrize("text", ["staff", "=user", "staff=owner", "staff=", ""])
def test_a_group_without_a_role_is_refused(text: str) -> None:
    with pytest.raises(InvalidInput, match="GROUP=admin or GROUP=user"):
        settings.group_role(text)


@pytest.mark.parametrize("name", ["none", "HS256", "rs256", ""])
def test_only_signatures_with_a_key_pair_are_allowed(name: str) -> None:
    with pytest.raises(InvalidInput, match="key pair"):
        settings.algorithm(name)


@pytest.mark.parametrize("text", ["a b", 'a"', "", "a\\", "é"])
def test_a_scope_has_no_space_and_no_quotes(text: str) -> None:
    with pytest.raises(InvalidInput, match="scope"):
        settings.scope(text)


def test_variables_and_files_give_roles(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "ppaas.toml"
    file.write_text('[up]\noidc-role = {staff = "user", "lab admins" = "admin"}\n')
    tree = SettingsTree(TABLES, file)
    values, wrong = tree.values("up")
    assert wrong == []
    roles = {setting.name: each.value for setting, each in values.items()}["oidc-role"]
    assert roles == [("staff", "user"), ("lab admins", "admin")]
    monkeypatch.setenv("PPAAS_OIDC_ROLE", "staff=admin")
    values, _ = SettingsTree(TABLES, file).values("up")
    assert {setting.name: each.value for setting, each in values.items()}["oidc-role"] == [("staff", "admin")]
