import json
from pathlib import Path

from tests.support.command_line import PASSWORD, CommandLine
from tests.support.records import house, put_map


async def test_a_user_is_added_logs_in_and_is_deleted(ppaas: CommandLine) -> None:
    added = await ppaas("user", "create", "cid", user="admin", stdin="battery staple\n")
    assert added.rows == [["id", "role"], ["cid", "user"]]
    ppaas.tokens["cid"] = (await ppaas("login", "cid", user=None, stdin="battery staple\n")).out.strip()
    assert (await ppaas("user", "show", user="cid")).rows[1] == ["cid", "user"]
    assert (await ppaas("user", "delete", "cid", user="admin")).status == 0
    assert (await ppaas("user", "show", user="cid")).err.startswith("ppaas: not-authenticated: ")


async def test_an_administrator_may_add_another(ppaas: CommandLine) -> None:
    await ppaas("user", "create", "eve", "--role", "admin", user="admin", stdin="battery staple\n")
    assert {"id": "eve", "role": "admin"} in json.loads((await ppaas("user", "list", "--json", user="admin")).out)


async def test_nobody_else_may(ppaas: CommandLine) -> None:
    for verb in (["create", "cid"], ["list"], ["delete", "bob"]):
        ended = await ppaas("user", *verb, stdin="battery staple\n")
        assert ended.err == "ppaas: not-permitted: only an administrator may do this\n"


async def test_a_password_that_is_too_short_is_refused(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "create", "cid", user="admin", stdin="short\n")
    assert ended.status == 1
    assert "body.password" in ended.err


async def test_a_user_who_is_there_is_not_added_again(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "create", "ann", user="admin", stdin="battery staple\n")
    assert ended.err.startswith("ppaas: conflict: ")


async def test_a_user_with_maps_is_kept_and_told_which(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())
    ended = await ppaas("user", "delete", "ann", user="admin")
    assert ended.err.startswith("ppaas: conflict: ")
    assert "house" in ended.err


async def test_a_user_changes_the_own_password_and_is_asked_for_the_old_one(ppaas: CommandLine) -> None:
    changed = await ppaas("user", "change", "--password", stdin=f"{PASSWORD}\nbattery staple\n")
    assert (changed.status, changed.err, changed.rows[1]) == (0, "", ["ann", "user"])
    assert (await ppaas("login", "ann", user=None, stdin="battery staple\n")).status == 0
    refused = await ppaas("user", "change", "--password", stdin=f"{PASSWORD}\nanother one\n")
    assert refused.err.startswith("ppaas: not-permitted: old_password is not")


async def test_an_administrator_gives_another_a_password_and_a_role(ppaas: CommandLine, tmp_path: Path) -> None:
    (tmp_path / "new").write_text("battery staple\n")
    changed = await ppaas(
        "user", "change", "ann", "--role", "admin", "--password-file", str(tmp_path / "new"), user="admin"
    )
    assert changed.rows[1] == ["ann", "admin"], changed.err
    assert (await ppaas("login", "ann", user=None, stdin="battery staple\n")).status == 0
    assert (await ppaas("user", "show", "ann", user="admin")).rows[1] == ["ann", "admin"]


async def test_a_change_that_changes_nothing_says_what_may_be_changed(ppaas: CommandLine) -> None:
    assert (await ppaas("user", "change")).err == "ppaas: invalid-input: nothing to change: give --password or --role\n"


async def test_a_list_is_as_long_as_told(ppaas: CommandLine) -> None:
    for count in (1, 2, 3):
        listed = json.loads((await ppaas("user", "list", "--json", "--limit", str(count), user="admin")).out)
        assert [one["id"] for one in listed] == ["admin", "ann", "bob"][:count]
    assert (await ppaas("user", "list", "--limit", "0", user="admin")).status == 2
