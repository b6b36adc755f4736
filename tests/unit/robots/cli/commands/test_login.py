import json
from pathlib import Path

from tests.support.cloud.command_line import PASSWORD, CommandLine


async def test_login_prints_only_a_valid_token(ppaas: CommandLine, tmp_path: Path) -> None:
    (tmp_path / "password").write_text(PASSWORD + "\n")
    ended = await ppaas("login", "ann", "--password-file", str(tmp_path / "password"), user=None)
    assert (ended.status, ended.err) == (0, "")
    ppaas.tokens["new"] = ended.out.strip()
    assert (await ppaas("user", "show", user="new")).rows[1] == ["ann", "user"]


async def test_login_as_json_includes_the_expiry_of_the_token(ppaas: CommandLine) -> None:
    ended = await ppaas("login", "ann", "--json", user=None, stdin=PASSWORD + "\n")
    assert set(json.loads(ended.out)) == {"token", "expires"}


async def test_a_wrong_password_prints_no_token(ppaas: CommandLine) -> None:
    ended = await ppaas("login", "ann", user=None, stdin="wrong horse\n")
    assert (ended.status, ended.out) == (1, "")
    assert ended.err == "ppaas: not-authenticated: wrong user or password\n"
