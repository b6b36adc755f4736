import json

from tests.support.cloud.command_line import PASSWORD, CommandLine


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
