import json
import time

import pytest

from endpoints.audit.event import AuditEvent
from robots.cli.commands.audit import _moment
from tests.support.cloud.command_line import CommandLine


def record(ppaas: CommandLine, **fields: object) -> None:
    ppaas.services.audit.record(AuditEvent(**{"action": "remove_map", "user": "bob", **fields}))  # type: ignore[arg-type]


async def test_an_administrator_sees_events_newest_first(ppaas: CommandLine) -> None:
    record(ppaas, object="maps/old", time=time.time() - 7200.0)
    record(ppaas, object="maps/new", outcome="refused", reason="not-permitted", details={"readers": ["*"]})
    shown = await ppaas("audit", "--user", "bob", user="admin")
    assert shown.rows[0][:2] == ["time", "user"]
    assert ["maps/new" in shown.out.splitlines()[1], "maps/old" in shown.out.splitlines()[2]] == [True, True]
    assert "not-permitted" in shown.out
    assert "readers=*" in shown.out


async def test_events_are_chosen_by_user_action_outcome_and_time(ppaas: CommandLine) -> None:
    record(ppaas, object="maps/old", time=time.time() - 7200.0)
    record(ppaas, object="maps/new")
    record(ppaas, action="put_robot", object="robots/tb1", outcome="failed")

    async def objects(*arguments: str) -> list[str]:
        listed = await ppaas("audit", "--json", "--user", "bob", *arguments, user="admin")
        return [event["object"] for event in json.loads(listed.out)]

    assert await objects("--after", "1h") == ["robots/tb1", "maps/new"]
    assert await objects("--action", "remove_map", "--limit", "1") == ["maps/new"]
    assert await objects("--outcome", "failed") == ["robots/tb1"]
    assert await objects("--object", "robots/tb1") == ["robots/tb1"]
    assert await objects("--limit", "0", "--after", "2000-01-01") == ["robots/tb1", "maps/new", "maps/old"]


async def test_no_events_are_one_line(ppaas: CommandLine) -> None:
    assert (await ppaas("audit", "--user", "nobody", user="admin")).out == "no events\n"


async def test_other_users_are_refused(ppaas: CommandLine) -> None:
    assert (await ppaas("audit")).err.startswith("ppaas: not-permitted: ")


@pytest.mark.parametrize("arguments", [("--after", "soon"), ("--limit", "-1"), ("--outcome", "maybe")])
async def test_a_bad_argument_is_an_error(ppaas: CommandLine, arguments: tuple[str, ...]) -> None:
    assert (await ppaas("audit", *arguments, user="admin")).status == 2


def test_a_date_may_have_a_time_zone() -> None:
    assert _moment("1970-01-01T01:00:00+01:00") == 0.0


async def test_an_unusable_file_of_certificates_is_an_error(ppaas: CommandLine) -> None:
    shown = await ppaas("audit", "--ca-file", "/nowhere.pem", user="admin")
    assert shown.status == 2
    assert "cannot read certificates from /nowhere.pem" in shown.err
