import json

from tests.support.command_line import CommandLine
from tests.support.fake_cloud import container


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


async def test_a_user_sees_the_own_containers_and_an_administrator_all(ppaas: CommandLine) -> None:
    ppaas.cloud.running = [container("c1", pss=3 << 20, cpu=0.125, age=95.0, clients=2), container("c2", user="bob")]
    [_, mine] = (await ppaas("container", "list")).rows
    assert mine == [
        "c1",
        "robot",
        "ann",
        "tb1",
        "house",
        "m1",
        "1",
        "ready",
        "42",
        "12",
        "%",
        "3.0",
        "MiB",
        "1m",
        "35s",
        "2",
    ]
    all_of_them = json.loads((await ppaas("container", "list", "--json", user="admin")).out)
    assert [one["id"] for one in all_of_them] == ["c1", "c2"]


async def test_where_there_is_none_it_says_so(ppaas: CommandLine) -> None:
    assert (await ppaas("container", "list")).out == "no containers: a robot has one while it is connected\n"
