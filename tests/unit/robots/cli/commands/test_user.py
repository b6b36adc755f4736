import json
from pathlib import Path

from tests.support.cloud.command_line import PASSWORD, CommandLine
from tests.support.storage.records import house, put_map


async def test_a_user_is_created_logs_in_and_is_deleted(ppaas: CommandLine) -> None:
    added = await ppaas("user", "create", "cid", user="admin", stdin="battery staple\n")
    assert added.rows == [["id", "role"], ["cid", "user"]]
    ppaas.tokens["cid"] = (await ppaas("login", "cid", user=None, stdin="battery staple\n")).out.strip()
    assert (await ppaas("user", "show", user="cid")).rows[1] == ["cid", "user"]
    assert (await ppaas("user", "delete", "cid", user="admin")).status == 0
    assert (await ppaas("user", "show", user="cid")).err.startswith("ppaas: not-authenticated: ")


async def test_a_user_is_logged_out_everywhere(ppaas: CommandLine) -> None:
    assert (await ppaas("user", "logout", "ann", user="admin")).status == 0
    assert (await ppaas("user", "show")).err.startswith("ppaas: not-authenticated: ")
    assert (await ppaas("user", "logout", user="bob")).status == 0
    assert (await ppaas("user", "show", user="bob")).err.startswith("ppaas: not-authenticated: ")


async def test_a_user_is_deleted_by_force(ppaas: CommandLine) -> None:
    assert (await ppaas("user", "delete", "bob", "--force", user="admin")).status == 0


async def test_an_administrator_creates_another_administrator(ppaas: CommandLine) -> None:
    await ppaas("user", "create", "eve", "--role", "admin", user="admin", stdin="battery staple\n")
    assert {"id": "eve", "role": "admin", "groups": []} in json.loads(
        (await ppaas("user", "list", "--json", user="admin")).out
    )


async def test_user_commands_require_an_administrator(ppaas: CommandLine) -> None:
    for verb in (["create", "cid"], ["list"], ["delete", "bob"]):
        ended = await ppaas("user", *verb, stdin="battery staple\n")
        assert ended.err == "ppaas: not-permitted: only an administrator may do this\n"


async def test_a_short_password_is_refused(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "create", "cid", user="admin", stdin="short\n")
    assert ended.status == 1
    assert "body.password" in ended.err


async def test_an_existing_user_is_not_created_again(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "create", "ann", user="admin", stdin="battery staple\n")
    assert ended.err.startswith("ppaas: conflict: ")


async def test_a_user_with_maps_is_not_deleted_and_they_are_named(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())
    ended = await ppaas("user", "delete", "ann", user="admin")
    assert ended.err.startswith("ppaas: conflict: ")
    assert "house" in ended.err


async def test_a_password_change_asks_for_the_old_password(ppaas: CommandLine) -> None:
    changed = await ppaas("user", "change", "--password", stdin=f"{PASSWORD}\nbattery staple\n")
    assert (changed.status, changed.err, changed.rows[1]) == (0, "", ["ann", "user"])
    assert (await ppaas("login", "ann", user=None, stdin="battery staple\n")).status == 0
    refused = await ppaas("user", "change", "--password", stdin=f"{PASSWORD}\nanother one\n")
    assert refused.err.startswith("ppaas: not-permitted: old_password is not")


async def test_an_administrator_sets_password_and_role_of_another(ppaas: CommandLine, tmp_path: Path) -> None:
    (tmp_path / "new").write_text("battery staple\n")
    changed = await ppaas(
        "user", "change", "ann", "--role", "admin", "--password-file", str(tmp_path / "new"), user="admin"
    )
    assert changed.rows[1] == ["ann", "admin"], changed.err
    assert (await ppaas("login", "ann", user=None, stdin="battery staple\n")).status == 0
    assert (await ppaas("user", "show", "ann", user="admin")).rows[1] == ["ann", "admin"]


async def test_an_empty_change_is_refused_with_the_options(ppaas: CommandLine) -> None:
    assert (await ppaas("user", "change")).err == "ppaas: invalid-input: nothing to change; give --password or --role\n"


async def test_a_list_has_the_requested_length(ppaas: CommandLine) -> None:
    for count in (1, 2, 3):
        listed = json.loads((await ppaas("user", "list", "--json", "--limit", str(count), user="admin")).out)
        assert [one["id"] for one in listed] == ["admin", "ann", "bob"][:count]
    assert (await ppaas("user", "list", "--limit", "0", user="admin")).status == 2


async def test_a_user_is_shown_with_quota_and_usage(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())
    rows = (await ppaas("user", "show")).rows
    assert rows[3] == ["quota", "used", "limit", "own"]
    assert rows[4:] == [
        ["containers", "0", "64", "-"],
        ["cores", "0", "64", "-"],
        ["robots", "0", "1000", "-"],
        ["maps", "1", "1000", "-"],
        ["plans_per_minute", "0", "120000", "-"],
        ["stored_bytes", str(sum(map(len, house().files.values()))), str(1 << 34), "-"],
        ["versions_per_map", "1", "1000", "-"],
    ]


async def test_an_administrator_sets_and_resets_limits(ppaas: CommandLine) -> None:
    limited = await ppaas("user", "limit", "ann", "--cores", "1.5", "--plans-per-minute", "0", user="admin")
    assert limited.rows[5] == ["cores", "0", "1.5", "1.5"], limited.err
    assert limited.rows[8] == ["plans_per_minute", "0", "0", "0"]
    shown = json.loads((await ppaas("user", "show", "--json")).out)
    assert (shown["limits"]["cores"], shown["quota"]["cores"], shown["quota"]["maps"]) == (1.5, 1.5, 1000)
    back = await ppaas("user", "limit", "ann", "--cores", "default", user="admin")
    assert (back.rows[5], back.rows[8][3]) == (["cores", "0", "64", "-"], "0")


async def test_invalid_and_missing_limits_are_refused(ppaas: CommandLine) -> None:
    for wrong in (["--cores", "nan"], ["--cores", "-1"], ["--maps", "1.5"], ["--robots", "many"]):
        assert (await ppaas("user", "limit", "ann", *wrong, user="admin")).status == 2
    assert (await ppaas("user", "limit", "ann", user="admin")).err.startswith("ppaas: invalid-input: nothing to change")
    refused = await ppaas("user", "limit", "ann", "--maps", "9")
    assert refused.err == "ppaas: not-permitted: only an administrator may change limits\n"
