import json

from tests.support.command_line import CommandLine
from tests.support.records import house


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
    ppaas.services.map_store.put_map(house())
    ended = await ppaas("user", "delete", "ann", user="admin")
    assert ended.err.startswith("ppaas: conflict: ")
    assert "house" in ended.err
