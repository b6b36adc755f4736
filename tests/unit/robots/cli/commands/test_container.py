import json

from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_cloud import container


async def test_users_list_their_containers_and_administrators_list_all(ppaas: CommandLine) -> None:
    ppaas.cloud.running = [container("c1", pss=3 << 20, cpu=0.125, age=95.0, clients=2), container("c2", user="bob")]
    [_, mine] = (await ppaas("container", "list")).rows
    expected = "c1 robot ann tb1 house m1 1 ready 42 12 % 3.0 MiB 1m 35s 2"
    assert mine == expected.split()
    all_of_them = json.loads((await ppaas("container", "list", "--json", user="admin")).out)
    assert [one["id"] for one in all_of_them] == ["c1", "c2"]
    assert (await ppaas("container", "show", "c1")).rows[1] == mine
    limited = json.loads((await ppaas("container", "list", "--json", "--limit", "1", user="admin")).out)
    assert [one["id"] for one in limited] == ["c1"]


async def test_an_empty_container_list_explains_when_there_is_one(ppaas: CommandLine) -> None:
    assert (await ppaas("container", "list")).out == "no containers; a robot has one while it is connected\n"


async def test_only_its_user_deletes_a_container(ppaas: CommandLine) -> None:
    ppaas.cloud.running = [container("c1")]
    refused = await ppaas("container", "delete", "c1", user="bob")
    assert (refused.status, refused.err) == (1, "ppaas: not-found: unknown container 'c1'\n")
    assert (await ppaas("container", "delete", "c1")).status == 0
    assert ppaas.cloud.given_up == ["c1"]


async def test_a_container_is_resized(ppaas: CommandLine) -> None:
    ppaas.cloud.running = [container("c1")]
    assert (await ppaas("container", "resize", "c1", "0.5")).rows[1][6] == "0.5"
    assert ppaas.cloud.running[0].cores == 0.5
    assert (await ppaas("container", "resize", "c1", "nan")).err.startswith(
        "ppaas: invalid-input: cores must be a finite number"
    )
    assert (await ppaas("container", "resize", "c1", "-1")).err.startswith("ppaas: invalid-input: body.cores")
    assert (await ppaas("container", "resize", "c1", "0.5", user="bob")).err.startswith("ppaas: not-found: ")
