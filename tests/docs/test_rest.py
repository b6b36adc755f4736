"""Numbers and names in rest.md are those of the service, and its commands work."""

import asyncio
import json
import re
from pathlib import Path

import httpx
import pytest

from endpoints.resources.services import MIB, RequestLimits
from endpoints.rest.paging import DEFAULT_LIMIT, MAX_LIMIT, Page
from ppaas.geometry import Pose2D
from ppaas.maps.formats.map_files import load_map
from ppaas.maps.grid import GridMap
from robots.client.robot_file import RobotFile, load_robot_file
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.documents import blocks, run_shell, script, table, text_of
from tests.support.endpoints.fuzzed_rest import description
from tests.support.sources import pyproject
from tests.support.waiting import PATIENCE

REST = "docs/rest.md"
COMMANDS = pyproject()["project"]["entry-points"]["ppaas.commands"]


def states(words: str) -> bool:
    return words in re.sub(r"\s+", " ", text_of(REST))


def test_resources_and_commands_exist() -> None:
    rows = table(REST, "resource", "operations", "commands")
    named = {path for row in rows for path in re.findall(r"/v1/[\w/-]+", row[0])}
    assert {path.split("/")[2] for path in named} == {path.split("/")[2] for path in description()["paths"]} - {
        "models"
    }
    assert {command for row in rows for command in re.findall(r"ppaas (\w+)", row[2])} <= set(COMMANDS)


async def test_a_running_cloud_describes_each_operation(cloud: RunningCloud) -> None:
    async with httpx.AsyncClient(base_url=cloud.url, timeout=PATIENCE) as client:
        shown = (await client.get("/openapi.json")).json()
    operations = [operation for path in shown["paths"].values() for operation in path.values()]
    assert [operation["operationId"] for operation in operations if not operation.get("description")] == []


def test_the_numbers_are_those_of_the_code() -> None:
    settings = RequestLimits()
    assert states(f"{DEFAULT_LIMIT} by default, {MAX_LIMIT} at most")
    assert states(
        f"did not arrive within {settings.max_body_seconds:g} s, or {settings.max_upload_seconds:g} s for a map"
    )
    assert states(f"larger than {settings.max_body // MIB} MiB, or {settings.max_upload // MIB} MiB for a map")


def test_every_status_is_declared_by_the_service() -> None:
    listed = {int(code) for status, _ in table(REST, "status", "when") for code in status.split(", ")}
    declared = {405} | {
        int(status)
        for methods in description()["paths"].values()
        for operation in methods.values()
        for status in operation["responses"]
        if status >= "400"
    }
    assert listed | {500} == declared


def test_the_example_of_a_page_is_valid() -> None:
    [page] = blocks(REST, "json")
    assert Page[str].model_validate_json(page).model_dump() == json.loads(page)


@pytest.mark.journey
def test_the_shell_commands_work(cloud: RunningCloud, tmp_path: Path) -> None:
    robot = "ppaas map publish docs/examples/office.yaml\nppaas robot put tb1 docs/examples/tb1.json\n"
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    answers = run_shell(f"{login}\n{robot}{script(REST)}", tmp_path, cloud).splitlines()
    text = "\n".join(answers)
    assert '"expires"' in text and '"items"' in text
    changed, _ = json.JSONDecoder().raw_decode(text[text.rindex('{"id":"tb1"') :])
    assert changed["cores"] == 0.5
    assert re.search(r'"poses":"[?-~]+"', text), "a polyline"


@pytest.fixture
def office() -> GridMap:
    """Return the map of the examples."""
    return load_map(Path("docs/examples/office.yaml").read_bytes(), Path("docs/examples/office.pgm").read_bytes())


@pytest.fixture
def robot() -> RobotFile:
    """Return the robot of the examples."""
    return load_robot_file(Path("docs/examples/tb1.json"))


@pytest.mark.journey
async def test_the_commands_of_navigation_drive_a_robot(
    cloud: RunningCloud, office: GridMap, robot: RobotFile, tmp_path: Path
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office)
    await rest.put_robot("tb1", robot)
    assert rest.token is not None
    [commands] = blocks(REST, "bash")
    async with driving(cloud.url, rest.token, "tb1", office, Pose2D(*robot.initial_pose)) as drive:
        shell = f"export PPAAS_TOKEN={rest.token}\n{commands}"
        printed = await asyncio.to_thread(run_shell, shell, tmp_path, cloud)
        assert '"connected":true' in printed and "succeeded" in printed
        assert drive.scorer.error(0, Pose2D(3.0, 2.0, 0.0)) <= 0.25
