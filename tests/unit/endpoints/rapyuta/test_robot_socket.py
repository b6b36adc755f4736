"""Handshake, connections and rights of robots of 2013, over real sockets."""

import asyncio
import hashlib
import json
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import httpx
import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from endpoints.audit.event import AuditQuery
from endpoints.http.front_settings import FrontSettings
from endpoints.rapyuta import registry as registry_module
from endpoints.rapyuta.app import rapyuta_app, refusal
from endpoints.rapyuta.registry import RobotRegistry
from endpoints.resources.services import Services
from ppaas.errors import NotPermitted
from storage.sharing_records import TokenScope
from tests.support.clients.rce import RceRobot, login_query
from tests.support.endpoints.rapyuta import StillSessions
from tests.support.endpoints.serving import serve
from tests.support.sources import ROOT
from tests.support.waiting import PATIENCE, until

OWN, ROBOTS = "correct horse", "the robots of 2013"


class Rapyuta:
    """Port for robots of 2013 of a cloud in which ann may use it."""

    def __init__(self, services: Services, registry: RobotRegistry, port: int) -> None:
        self.services = services
        self.registry = registry
        self.host = f"127.0.0.1:{port}"

    def url(self, robot: str = "tb1", user: str = "ann", password: str = ROBOTS) -> str:
        return f"ws://{self.host}/?{login_query(user, robot, password)}"

    @asynccontextmanager
    async def robot(self, robot: str = "tb1") -> AsyncIterator[RceRobot]:
        async with connect(self.url(robot)) as socket:
            client = RceRobot(socket)
            running = asyncio.create_task(client.run())
            yield client
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    async def refusal(self, url: str, **options: Any) -> tuple[int, str]:
        """Connect, expecting a refusal; return its status and text."""
        with pytest.raises(InvalidStatus) as refused:
            await connect(url, **options)
        response = refused.value.response
        assert response.headers["content-type"].startswith("text/plain")
        return response.status_code, (response.body or b"").decode()


@pytest.fixture
async def rapyuta(services: Services, sessions: StillSessions, token: str) -> AsyncIterator[Rapyuta]:
    await services.accounts.rapyuta.set("ann", ROBOTS)
    registry = RobotRegistry(services, sessions)  # type: ignore[arg-type]
    async with serve(rapyuta_app(services, registry, FrontSettings())) as port:
        yield Rapyuta(services, registry, port)
        await registry.close()
    assert len(registry) == 0
    assert not sessions.attached


# -- the master --------------------------------------------------------------------------------------------------------


async def test_the_master_names_the_address_by_which_it_was_reached(rapyuta: Rapyuta) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE) as client:
        answer = await client.get(f"http://{rapyuta.host}/?userID=ann&version=20130902")
        assert (answer.status_code, answer.json()) == (200, {"url": f"ws://{rapyuta.host}/"})
        named = await client.get(
            f"http://{rapyuta.host}/?userID=ann&version=20130415", headers={"Host": "cloud.example:9000"}
        )
        assert named.json() == {"url": "ws://cloud.example:9000/", "current": "20130902"}
        for query, status in (("", 400), ("userID=a&version=2012", 410), ("userID=a&version=2014", 501)):
            refused = await client.get(f"http://{rapyuta.host}/?{query}")
            assert (refused.status_code, refused.headers["content-type"]) == (status, "text/plain; charset=utf-8")
        assert (await client.post(f"http://{rapyuta.host}/")).status_code == 405


# -- logins ------------------------------------------------------------------------------------------------------------


async def test_a_robot_logs_in_by_the_hash_of_its_own_password(rapyuta: Rapyuta, sessions: StillSessions) -> None:
    async with rapyuta.robot() as robot:
        await robot.create_container("c1")
        await until(lambda: sessions.attached)
        await robot.create_container("c1")
        await until(lambda: robot.errors)
        assert robot.errors == ["Invalid Request: ID is already used for a container or robot: 'c1'"]
    assert (await rapyuta.services.accounts.user_of(sessions.attached[0].token)).id == "ann"


@pytest.mark.parametrize("login", [{"password": OWN}, {"password": "guess"}, {"user": "bob"}, {"user": "no/name"}])
async def test_other_logins_are_refused_alike(rapyuta: Rapyuta, login: dict[str, str]) -> None:
    assert await rapyuta.refusal(rapyuta.url(**login)) == (401, "wrong user or password")


async def test_a_user_without_a_password_for_robots_and_an_administrator_have_no_such_login(rapyuta: Rapyuta) -> None:
    accounts = rapyuta.services.accounts
    await accounts.change("ann", role="admin")
    assert (await rapyuta.refusal(rapyuta.url()))[0] == 401
    await accounts.change("ann", role="user")
    async with rapyuta.robot():
        pass
    await accounts.rapyuta.set("ann", None)
    assert (await rapyuta.refusal(rapyuta.url()))[0] == 401


@pytest.mark.parametrize(
    ("query", "text"),
    [
        ("userID=ann&robotID=tb1", "missing parameter: 'password'"),
        ("userID=ann&robotID=tb1&robotID=tb2&password=x", "'robotID' has to be unique"),
        ("userID=ann&robotID=1&password=x", "robotID '1' is not valid"),
    ],
)
async def test_incomplete_logins_are_bad_requests(rapyuta: Rapyuta, query: str, text: str) -> None:
    status, body = await rapyuta.refusal(f"ws://{rapyuta.host}/?{query}")
    assert status == 400
    assert text in body


async def test_guessing_is_throttled_and_opens_no_way_to_guess_the_own_password(rapyuta: Rapyuta) -> None:
    for _ in range(10):
        assert (await rapyuta.refusal(rapyuta.url(password="guess")))[0] == 401
    status, text = await rapyuta.refusal(rapyuta.url())
    assert status == 401
    assert "too many failed logins" in text
    assert await rapyuta.services.accounts.login("ann", OWN)  # of another throttle


async def test_a_token_logs_in_too(rapyuta: Rapyuta) -> None:
    accounts = rapyuta.services.accounts
    text = await accounts.login("ann", OWN)
    await accounts.register("bob", OWN)
    header = {"Authorization": f"Bearer {text}"}
    async with connect(rapyuta.url(password="unused"), additional_headers=header):
        assert len(rapyuta.registry) == 1
    bobs = {"Authorization": f"Bearer {await accounts.login('bob', OWN)}"}
    assert (await rapyuta.refusal(rapyuta.url(), additional_headers=bobs))[0] == 401
    query = urlencode({"userID": "ann", "robotID": "tb2", "password": "-", "token": text})
    async with connect(f"ws://{rapyuta.host}/?{query}"):
        assert len(rapyuta.registry) == 2


async def test_a_token_for_some_robots_does_not_log_in(rapyuta: Rapyuta) -> None:
    scoped = await rapyuta.services.accounts.issue_scoped("ann", TokenScope(("tb1",), "drive"), 60.0)
    header = {"Authorization": f"Bearer {scoped.token}"}
    status, text = await rapyuta.refusal(rapyuta.url(), additional_headers=header)
    assert (status, "tb1" in text) == (401, True)


async def test_logins_are_audited_without_secrets(rapyuta: Rapyuta) -> None:
    await rapyuta.refusal(rapyuta.url(user="bob"))
    async with rapyuta.robot():
        pass
    log = rapyuta.services.audit
    await until(lambda: len(log.read(AuditQuery())) == 3)
    end, good, bad = log.read(AuditQuery())
    assert [(event.action, event.status, event.user, event.object) for event in (bad, good, end)] == [
        ("connect", 401, None, "robots/tb1"),
        ("connect", 101, "ann", "robots/tb1"),
        ("disconnect", None, "ann", "robots/tb1"),
    ]  # fmt: skip
    assert bad.details == {"role": "robot", "protocol": "rapyuta", "login": "(unknown)"}
    digest = hashlib.sha256(ROBOTS.encode()).hexdigest()
    assert digest not in "".join(map(repr, (bad, good, end)))


# -- connections -------------------------------------------------------------------------------------------------------


async def test_a_second_connection_of_a_robot_is_refused(rapyuta: Rapyuta) -> None:
    async with rapyuta.robot():
        status, text = await rapyuta.refusal(rapyuta.url())
    assert (status, "already used" in text) == (400, True)


async def test_a_robot_that_does_not_answer_is_replaced(rapyuta: Rapyuta, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry_module, "PROBE_TIMEOUT", 0.05)
    async with connect(rapyuta.url(), max_queue=1) as frozen:
        await frozen.send('{"type": "CC", "data": {"containerTag": "c1"}}')
        await until(lambda: len(rapyuta.registry) == 1)
        frozen.transport.pause_reading()
        async with rapyuta.robot() as robot:
            await robot.create_container("c1")
            await until(lambda: robot.errors)
        frozen.transport.resume_reading()
        with pytest.raises(ConnectionClosed):
            await frozen.recv()


async def test_a_robot_that_comes_back_finds_its_containers_and_what_waited(
    rapyuta: Rapyuta, sessions: StillSessions
) -> None:
    async with rapyuta.robot() as robot:
        await robot.create_container("c1")
        await robot.add_interface("c1", "drive", "SubscriberInterface", "geometry_msgs/Twist", "/cmd_vel")
        await robot.add_interface("tb1", "drive", "PublisherConverter", "geometry_msgs/Twist")
        await robot.add_connection("c1/drive", "tb1/drive")
        await until(lambda: robot.statuses)
    first = sessions.attached[0].token
    sessions.place.publish_json("cmd_vel", {"linear": {"x": 0.25}})
    async with rapyuta.robot() as robot:
        await until(lambda: robot.received)
        assert robot.received[0]["data"]["msg"] == {"linear": {"x": 0.25}}
    assert sessions.opened == ["tb1"]
    assert sessions.attached[0].token != first
    await until(lambda: len(rapyuta.services.store.tokens("ann")) == 2)  # of the fixture, and of the last login


async def test_what_a_robot_made_is_removed_if_it_does_not_come_back(
    services: Services, sessions: StillSessions, token: str
) -> None:
    await services.accounts.rapyuta.set("ann", ROBOTS)
    registry = RobotRegistry(services, sessions, reconnect=0.05)  # type: ignore[arg-type]
    async with serve(rapyuta_app(services, registry, FrontSettings())) as port:
        async with Rapyuta(services, registry, port).robot() as robot:
            await robot.create_container("c1")
            await until(lambda: sessions.attached)
        await until(lambda: len(registry) == 0)
        assert not sessions.attached
        await until(lambda: len(services.store.tokens("ann")) == 1)
        await registry.close()


async def _end(socket: ClientConnection) -> tuple[int | None, str]:
    with pytest.raises(ConnectionClosed):
        while True:
            await socket.recv()
    return socket.close_code, socket.close_reason or ""


@pytest.mark.parametrize("right", ["token", "password"])
async def test_a_robot_that_lost_its_right_is_disconnected_for_good(
    rapyuta: Rapyuta, sessions: StillSessions, right: str
) -> None:
    accounts = rapyuta.services.accounts
    async with connect(rapyuta.url()) as socket:
        await socket.send(json.dumps({"type": "CC", "data": {"containerTag": "c1"}}))
        await until(lambda: sessions.attached)
        await (accounts.revoke_all("ann") if right == "token" else accounts.rapyuta.set("ann", "another password"))
        await rapyuta.registry.check()
        assert (await _end(socket))[0] == 1008
    await until(lambda: len(rapyuta.registry) == 0)
    assert not sessions.attached


async def test_a_robot_that_lost_its_right_while_it_was_away_is_removed(
    rapyuta: Rapyuta, sessions: StillSessions
) -> None:
    async with rapyuta.robot() as robot:
        await robot.create_container("c1")
        await until(lambda: sessions.attached)
    await until(lambda: not any(one.carrier for one, _ in rapyuta.registry._robots.values()))
    await rapyuta.services.accounts.revoke_all("ann")
    await rapyuta.registry.check()
    assert len(rapyuta.registry) == 0


@pytest.mark.parametrize(
    ("frame", "text"),
    [
        ("{", "Invalid Request: "),
        ("[]", "Invalid Request: "),
        (b"short", "Invalid Request: "),
        ('{"type": "CC", "data": 5}', "Invalid Request: "),
        ('{"type": "DM", "data": {"iTag": "a", "type": "b", "msgID": "c", "msg": {}}}', "Invalid Request: unknown"),
    ],
)
async def test_wrong_frames_are_errors_and_end_nothing(rapyuta: Rapyuta, frame: str | bytes, text: str) -> None:
    async with rapyuta.robot() as robot:
        await robot.socket.send(frame)
        await until(lambda: robot.errors)
        assert robot.errors[0].startswith(text)
        await robot.create_container("c1")
        await robot.socket.send('{"type": "CC", "data": {"containerTag": "c1"}}')
        await until(lambda: len(robot.errors) == 2)


async def test_a_fault_of_the_cloud_is_told_without_details(
    rapyuta: Rapyuta, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(*_: Any) -> None:
        raise RuntimeError("secret")

    async with rapyuta.robot() as robot:
        monkeypatch.setattr("endpoints.rapyuta.executor.check_tag", broken)
        await robot.create_container("c1")
        await until(lambda: robot.errors)
        assert robot.errors == ["Fatal Error"]
    assert "secret" in caplog.text


def test_other_refusals_are_faults() -> None:
    assert refusal(TimeoutError()).status_code == 500
    assert refusal(NotPermitted("x")).status_code == 401


async def test_the_example_configures_the_cloud_by_a_file_of_rce_ros(rapyuta: Rapyuta, tmp_path: Path) -> None:
    examples = ROOT / "docs" / "examples"
    file = tmp_path / "client.json"
    file.write_text((examples / "rapyuta_tb1.json").read_text().replace("127.0.0.1:9000", rapyuta.host))
    script = await asyncio.create_subprocess_exec(
        sys.executable, str(examples / "rapyuta_check.py"), str(file), "60",
        stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
    )  # fmt: skip
    assert script.stdin is not None and script.stdout is not None
    script.stdin.write(f"{ROBOTS}\n".encode())
    lines = [json.loads(await script.stdout.readline()) for _ in range(4)]
    script.terminate()
    await script.communicate()
    assert [line["data"] for line in lines] == [
        {"topic": "iu", "iTag": tag, "status": True} for tag in ("scan", "odom", "cmd", "map")
    ]


async def test_a_login_that_is_refused_leaves_no_token(rapyuta: Rapyuta) -> None:
    async with rapyuta.robot():
        before = len(rapyuta.services.store.tokens("ann"))
        assert (await rapyuta.refusal(rapyuta.url()))[0] == 400
        await until(lambda: len(rapyuta.services.store.tokens("ann")) == before)
