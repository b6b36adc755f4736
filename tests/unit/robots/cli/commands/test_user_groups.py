"""``ppaas user group`` and ``ppaas user rapyuta``."""

import hashlib
from pathlib import Path

from tests.support.cloud.command_line import CommandLine


async def test_a_group_is_created_shown_changed_and_deleted(ppaas: CommandLine) -> None:
    assert (await ppaas("user", "group", user="admin")).out.startswith("no groups; create one: ")
    added = await ppaas("user", "group", "hall", "--add", "ann", "bob", user="admin")
    assert added.rows == [["id", "members"], ["hall", "ann,", "bob"]]
    assert (await ppaas("user", "group", "hall", user="bob")).rows == added.rows
    changed = await ppaas("user", "group", "hall", "--add", "admin", "--remove", "ann", user="admin")
    assert changed.rows[1] == ["hall", "admin,", "bob"]
    assert (await ppaas("user", "group", user="admin")).rows == changed.rows
    assert (await ppaas("user", "group", "hall", "--delete", user="admin")).status == 0
    assert (await ppaas("user", "group", "hall", user="admin")).err == "ppaas: not-found: unknown group 'hall'\n"


async def test_a_group_is_not_left_without_members_by_mistake(ppaas: CommandLine) -> None:
    await ppaas("user", "group", "hall", "--add", "bob", user="admin")
    for options, text in (
        (["hall", "--remove", "bob"], "would have no members: delete it with --delete"),
        (["--add", "ann"], "name the group to change"),
        (["hall", "--delete", "--add", "ann"], "give --delete alone"),
    ):
        ended = await ppaas("user", "group", *options, user="admin")
        assert (ended.status, text in ended.err) == (1, True)
    assert (await ppaas("user", "group", "hall", "--add", "ann")).err.startswith("ppaas: not-permitted: ")


async def test_the_password_for_robots_is_set_and_removed(ppaas: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "robots"
    file.write_text("battery staple\n")
    ended = await ppaas("user", "rapyuta", "ann", "--password-file", str(file), user="admin")
    assert ended.rows[1][:2] == ["ann", "user"]
    digest = hashlib.sha256(b"battery staple").hexdigest()
    assert (await ppaas.services.accounts.rapyuta.sign_in("ann", digest))[0].id == "ann"
    assert (await ppaas("user", "rapyuta", "ann", "--off", user="admin")).status == 0
    assert ppaas.services.store.user("ann").rapyuta_hash == ""


async def test_only_an_administrator_sets_it(ppaas: CommandLine) -> None:
    ended = await ppaas("user", "rapyuta", "ann", stdin="battery staple\n")
    assert ended.err.startswith("ppaas: not-permitted: ")
