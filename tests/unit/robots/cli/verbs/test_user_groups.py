"""Tests of ``ppaas user group``."""

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
