import pytest

from tests.support.cloud.command_line import CommandLine

COMMANDS = [
    ("map", "list"), ("map", "show", "house"), ("map", "delete", "house"), ("robot", "list"), ("robot", "show", "tb1"),
    ("robot", "delete", "tb1"), ("plan", "house", "--start", "0", "0", "--goal", "1", "1"), ("machine", "list"),
    ("container", "list"), ("user", "list"), ("user", "show"), ("user", "create", "cid"), ("user", "delete", "bob"),
    ("user", "change", "--role", "user"), ("machine", "show", "m1"), ("container", "show", "c1"), ("top", "--once"),
    ("container", "delete", "c1"), ("token", "list"), ("token", "delete", "current"), ("robot", "change", "a", "b=1"),
    ("map", "change", "house", "--reader", "*"), ("map", "versions", "house"), ("map", "fetch", "house"),
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
async def test_every_command_without_a_token_tells_how_to_get_one(ppaas: CommandLine, command: tuple[str, ...]) -> None:
    ended = await ppaas(*command, user=None, stdin="correct horse\n")
    assert (ended.status, ended.out) == (1, "")
    assert ended.err == "ppaas: not-authenticated: no token: export PPAAS_TOKEN=$(ppaas login USER)\n"


async def test_an_unknown_token_error_names_the_login_command(ppaas: CommandLine) -> None:
    ended = await ppaas("map", "list", "--token", "made-up")
    assert ended.status == 1
    assert "log in again ('ppaas login'" in ended.err


@pytest.mark.parametrize("token", ["ü", "a\nb", "\udcff", "a\x00b"])
async def test_a_token_with_invalid_characters_is_not_sent(ppaas: CommandLine, token: str) -> None:
    ended = await ppaas("map", "list", "--token", token)
    assert (ended.status, ended.err) == (
        1,
        "ppaas: not-authenticated: the token has characters that no token has; log in again\n",
    )


async def test_an_unreachable_cloud_is_named(ppaas: CommandLine) -> None:
    ended = await ppaas("map", "list", "--url", "http://127.0.0.1:1")
    assert ended.status == 1
    assert ended.err.startswith("ppaas: unavailable: cannot reach 127.0.0.1:1:")
    assert "check that a cloud runs at" in ended.err


@pytest.mark.parametrize("url", ["localhost", "http://[", "http://a:b", "http://a:0", "ftp://a", "http://\udcff", ""])
async def test_an_invalid_url_is_refused_with_an_example(ppaas: CommandLine, url: str) -> None:
    ended = await ppaas("map", "list", "--url", url)
    assert ended.status == 1
    assert "http://host:port" in ended.err
