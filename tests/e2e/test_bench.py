"""The bench measures a running cloud."""

import asyncio
import json

import pytest

from robots.cli.main import main
from tests.support.cloud.cloud import RunningCloud

pytestmark = pytest.mark.journey


async def test_plans_are_measured_beside_their_baselines(
    cloud: RunningCloud, capsys: pytest.CaptureFixture[str]
) -> None:
    token = (await cloud.admin()).token
    arguments = ["bench", "service", "--quick", "--json", "--only", "plans", "--url", cloud.url, "--token", str(token)]
    assert await asyncio.to_thread(main, arguments) == 0
    figures = {figure["name"]: figure for figure in json.loads(capsys.readouterr().out)["figures"]}
    assert figures["websockets, echo"]["yardstick"] and figures["FastAPI, echo"]["yardstick"]
    assert figures["planner, in its container"]["value"] > 0.0
    assert figures["REST, beyond its planner's time"]["limit"] == 1.0
