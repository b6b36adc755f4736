import json
import time
from pathlib import Path

import pytest

from tests.support.cloud.command_line import PASSWORD, CommandLine
from tests.support.storage import records


async def test_tokens_are_listed_and_one_is_deleted(ppaas: CommandLine) -> None:
    other = (await ppaas("login", "ann", user=None, stdin=PASSWORD + "\n")).out.strip()
    listed = json.loads((await ppaas("token", "list", "--json")).out)
    assert [one["current"] for one in listed].count(True) == 1
    [unused] = [one["id"] for one in listed if not one["current"]]
    assert unused in (await ppaas("token", "list")).out
    assert (await ppaas("token", "delete", unused)).status == 0
    assert (await ppaas("user", "show", "--token", other)).err.startswith("ppaas: not-authenticated: ")


async def test_deleting_the_current_token_logs_out(ppaas: CommandLine) -> None:
    assert (await ppaas("token", "delete", "current")).status == 0
    assert (await ppaas("token", "list")).err.startswith("ppaas: not-authenticated: ")


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


async def test_a_token_for_a_display_is_created_listed_used_and_revoked(ppaas: CommandLine) -> None:
    for name in ("tb1", "kobuki"):
        ppaas.services.store.put_robot(records.robot(name, user="ann"))
    created = await ppaas(
        "token", "create", "--robot", "tb*", "--role", "look", "--topic", "map", "--topic", "amcl_pose", "--expires",
        "90d", "--name", "display",
    )  # fmt: skip
    token = created.out.strip()
    [one] = [one for one in json.loads((await ppaas("token", "list", "--json")).out) if one["scope"]]
    assert one["scope"] == {"robots": ["tb*"], "role": "look", "publish": [], "subscribe": ["map", "amcl_pose"]}
    assert (one["name"], round((one["expires"] - one["created"]) / 86400)) == ("display", 90)
    assert [row[0] for row in (await ppaas("robot", "list", "--token", token)).rows] == ["id", "tb1"]
    assert "robots tb* only" in (await ppaas("map", "list", "--token", token)).err
    assert (await ppaas("token", "delete", one["id"])).status == 0
    assert (await ppaas("robot", "list", "--token", token)).err.startswith("ppaas: not-authenticated: ")


async def test_topics_of_a_role_that_publishes_are_for_both_directions(ppaas: CommandLine) -> None:
    options = ["--robot", "tb1", "--role", "robot", "--topic", "scan", "--publish", "odom"]
    created = json.loads((await ppaas("token", "create", *options, "--json")).out)
    token = ppaas.services.store.token(created["id"])
    assert token.scope is not None
    assert (token.scope.publish, token.scope.subscribe) == (("odom", "scan"), ("scan",))
    assert created["expires"] > time.time()


@pytest.mark.parametrize("text", ["", "1", "d", "1y", "1.5h"])
async def test_an_unreadable_time_of_expiry_is_refused(ppaas: CommandLine, text: str) -> None:
    ended = await ppaas("token", "create", "--robot", "tb1", "--role", "look", "--expires", text)
    assert (ended.status, "give a time as 30m, 12h or 90d" in ended.err) == (2, True)
