from tests.support.command_line import CommandLine


async def test_an_administrator_sees_the_machines(ppaas: CommandLine) -> None:
    ended = await ppaas("machine", "list", user="admin")
    assert ended.rows == [
        ["id", "cores", "capacity", "containers", "load", "memory_used", "memory"],
        ["m1", "4", "16", "1", "0.5", "1.0", "GiB", "8.0", "GiB"],
    ]


async def test_nobody_else_does(ppaas: CommandLine) -> None:
    ended = await ppaas("machine", "list")
    assert (ended.status, ended.out) == (1, "")
    assert ended.err == "ppaas: not-permitted: only an administrator may do this\n"


async def test_one_machine_is_shown_by_its_id(ppaas: CommandLine) -> None:
    shown = await ppaas("machine", "show", "m1", user="admin")
    assert shown.out == (await ppaas("machine", "list", user="admin")).out
    assert (
        await ppaas("machine", "show", "m2", user="admin")
    ).err == "ppaas: not-found: unknown machine 'm2'; known: m1\n"
