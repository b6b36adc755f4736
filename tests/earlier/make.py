"""Writes what an earlier release is remembered by: run in its checkout, before it is changed.

``python -m tests.earlier.make FOLDER`` wants Java 17 and Maven, as ``make test-servers`` does. It starts a cloud over
an SQLite file and another over a real Cassandra, tells both over REST of one user, maps, robots and plans, lets a robot
drive in each, and ends the cloud while it is under way. All but the maps is said and read as anybody's program does.
"""

import contextlib
import json
import math
import os
import re
import sqlite3
import subprocess
import sys
import tarfile
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
from cassandra.auth import PlainTextAuthProvider
from cassandra.cluster import Cluster
from cassandra.encoder import Encoder
from cassandra.query import dict_factory
from websockets.sync.client import connect

from ppaas.maps.formats.map_files import save_map
from ppaas.maps.generate import office
from tests.servers.cassandra_server import PASSWORD, CassandraServer
from tests.support.storage.earlier import ADMIN_PASSWORD, ANN_PASSWORD, KEYSPACE, without_poses
from tests.support.world.places import free_pose, reachable_pose

FAR = 4102444800.0  # in 2100, when tokens expire
LONG_AGO = 1700000000.0  # when checkpoints were saved: of one from the future nobody goes on
ROBOT = {
    "map": "house", "cores": 0.25, "base_global_planner": "astar", "description": "drives to a goal",
    "parameters": {"dwa": {"max_vel_x": 0.4}, "move_base": {"planner_frequency": 0.5}},
    "properties": {"colour": "red", "wheels": [1, 2]},
}  # fmt: skip
GOAL_ID = "to the other room"


class Rest:
    """Asks a cloud."""

    def __init__(self, url: str) -> None:
        self.url, self.token = url, ""

    def ask(self, method: str, path: str, body: Any = None, kind: str = "application/json") -> Any:
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(f"{self.url}/v1{path}", data, {"Content-Type": kind}, method=method)
        if self.token:
            request.add_header("Authorization", f"Bearer {self.token}")
        with urllib.request.urlopen(request) as answer:
            return json.loads(answer.read() or b"null")

    def log_in(self, user: str, password: str) -> str:
        self.token = self.ask("POST", "/tokens", {"user": user, "password": password})["token"]
        return self.token


@contextlib.contextmanager
def cloud(folder: Path, *arguments: str) -> Iterator[Rest]:
    """Run one with its data in a folder."""
    (folder / "password").write_text(ADMIN_PASSWORD)
    ready = folder / "ready.json"
    ready.unlink(missing_ok=True)
    more = ["--port", "0", "--data", str(folder / "data"), "--admin-password-file", str(folder / "password")]
    process = ppaas("up", *more, "--ready-file", str(ready), *arguments)
    try:
        wait_for(ready.exists)
        yield Rest(json.loads(ready.read_text())["url"])
    finally:
        process.terminate()
        process.wait()


def ppaas(*arguments: str, **environment: str) -> "subprocess.Popen[bytes]":
    command = [sys.executable, "-m", "robots.cli.main", *arguments]
    return subprocess.Popen(command, env=os.environ | environment)


def run(rest: Rest, *arguments: str) -> None:
    assert ppaas(*arguments, PPAAS_URL=rest.url, PPAAS_TOKEN=rest.token).wait() == 0, arguments


def wait_for(holds: Callable[[], Any], seconds: float = 90.0) -> Any:
    deadline = time.monotonic() + seconds
    while not (found := holds()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return found


def fill(rest: Rest, maps: Path) -> tuple[str, "subprocess.Popen[bytes]"]:
    """Tell a cloud of everything; return ann's token, and a robot under way."""
    rest.log_in("admin", ADMIN_PASSWORD)
    rest.ask("POST", "/users", {"id": "ann", "password": ANN_PASSWORD})
    rest.ask("PATCH", "/users/ann", {"limits": {"robots": 7}}, "application/merge-patch+json")
    (machine,) = rest.ask("GET", "/machines")["items"]
    run(rest, "machine", "label", machine["id"], "floor=2")
    token = rest.log_in("ann", ANN_PASSWORD)
    house = office(seed=1, width=12.0, height=10.0)
    for version, grid in (("older", office(seed=2, width=12.0, height=10.0)), ("newer", house)):
        (maps / version).mkdir(parents=True, exist_ok=True)
        yaml, image = save_map(grid, "house.pgm")
        (maps / version / "house.yaml").write_bytes(yaml)
        (maps / version / "house.pgm").write_bytes(image)
        said = ["--message", f"the {version} one", "--reader", "*", "--description", "a house"]
        run(rest, "map", "publish", str(maps / version / "house.yaml"), *said)
    run(rest, "map", "publish", str(maps / "older" / "house.yaml"), "--id", "cellar", "--message", "mine alone")
    start = free_pose(house, seed=3)
    goal = reachable_pose(house, start, seed=5, at_least=6.0)
    robot = ROBOT | {"initial_pose": [start.x, start.y, start.theta]}
    (maps / "tb1.json").write_text(json.dumps(robot))
    urdf = Path("docs/examples/robots/turtlebot3_burger.urdf")
    run(rest, "robot", "put", "tb1", str(maps / "tb1.json"))
    (maps / "tb2.json").write_text(json.dumps({"map": "cellar", "model": "turtlebot3_burger"}))
    run(rest, "robot", "put", "tb2", str(maps / "tb2.json"), "--urdf", str(urdf))
    plans(rest, [start.x, start.y], [goal.x, goal.y, goal.theta])
    return token, drive(rest, maps, [goal.x, goal.y, goal.theta])


def plans(rest: Rest, start: list[float], goal: list[float]) -> None:
    """Have plans made that share stretches, others, one that is kept by a program, and one that fails."""

    def plan(begin: list[float], end: list[float], **more: Any) -> dict[str, Any]:
        made: dict[str, Any] = rest.ask("POST", "/maps/house/plans", {"start": begin, "goal": end, **more})
        return made

    first = plan(start, goal, reuse=False)
    poses = first["poses"]
    for number in (10, 21, 33):
        plan(poses[number][:2], goal, reuse=False)
    plan(start, poses[-40][:2], planner="astar", reuse=False)
    plan(start, goal, planner="theta_star", reuse=False)
    plan(start, goal)
    with contextlib.suppress(urllib.error.HTTPError):
        plan(start, [200.0, 200.0])
    given = {"map": "house", "planner": "mine", "poses": poses[:90], "parameters": {"weight": 2.5}}
    rest.ask("PUT", "/plans/by-hand", given)
    rest.ask("PATCH", "/plans/by-hand", {"cost": 42.5}, "application/merge-patch+json")


def drive(rest: Rest, maps: Path, goal: list[float]) -> "subprocess.Popen[bytes]":
    """Let the robot drive, and return its process when it is under way."""
    world = str(maps / "newer" / "house.yaml")
    robot = ppaas("simulate", str(maps / "tb1.json"), "--map", world, PPAAS_URL=rest.url, PPAAS_TOKEN=rest.token)
    x, y, yaw = goal
    pose = {"position": {"x": x, "y": y}, "orientation": {"z": math.sin(yaw / 2.0), "w": math.cos(yaw / 2.0)}}
    target = {"header": {"frame_id": "map"}, "pose": pose}
    with connect(f"{rest.url.replace('http', 'ws', 1)}/?robot=tb1&role=operator&token={rest.token}") as operator:
        operator.send(json.dumps({"op": "subscribe", "topic": "amcl_pose"}))
        begin = position(operator.recv(30.0))
        goal_message = {"goal_id": {"id": GOAL_ID}, "goal": {"target_pose": target}}
        operator.send(json.dumps({"op": "publish", "topic": "move_base/goal", "msg": goal_message}))
        while math.dist(begin, position(operator.recv(30.0))) < 1.5:
            continue
    return robot


def position(heard: str | bytes) -> tuple[float, float]:
    """Return where the robot is believed to be."""
    at = json.loads(heard)["msg"]["pose"]["pose"]["position"]
    return at["x"], at["y"]


def told(rest: Rest) -> dict[str, Any]:
    """Return what a cloud says of all that is ann's."""
    rest.log_in("ann", ANN_PASSWORD)
    ids = sorted(plan["plan_id"] for plan in rest.ask("GET", "/maps/house/plans?limit=500")["items"])
    return {
        "user": rest.ask("GET", "/users/me"),
        "maps": rest.ask("GET", "/maps")["items"],
        "versions": rest.ask("GET", "/maps/house/versions")["items"],
        "robots": rest.ask("GET", "/robots")["items"],
        "plans": {plan_id: without_poses(rest.ask("GET", f"/plans/{plan_id}")) for plan_id in ids},
        "parts": {plan_id: rest.ask("GET", f"/plans/{plan_id}/parts")["items"] for plan_id in ids},
        "evaluation": rest.ask("GET", "/maps/house/evaluation"),
    }


def written(folder: Path, *arguments: str) -> dict[str, Any]:
    """Have a cloud write, end it while its robot drives, start it again, and return what it says."""
    folder.mkdir(parents=True)
    with cloud(folder, *arguments) as rest:
        token, robot = fill(rest, folder / "given")
    robot.terminate()
    robot.wait()
    with cloud(folder, *arguments) as rest:
        return {"token": token, "goal_id": GOAL_ID} | told(rest)


def keep_well(file: Path) -> bytes:
    """Let what is in a file be good whatever the clock says; return the checkpoint that is in it, as it is kept."""
    with contextlib.closing(sqlite3.connect(file)) as connection, connection:
        for key, data in connection.execute("SELECT hash, record FROM tokens").fetchall():
            update = "UPDATE tokens SET expires = ?, record = ? WHERE hash = ?"
            connection.execute(update, (FAR, changed(data, expires=FAR), key))
        checkpoint = changed(connection.execute("SELECT record FROM clones").fetchone()[0], saved=LONG_AGO)
        connection.execute("UPDATE clones SET record = ?", (checkpoint,))
    return checkpoint


def changed(record: bytes, **fields: float) -> bytes:
    """Return a record with other numbers in it."""
    return msgspec.msgpack.encode(msgspec.msgpack.decode(record) | fields)


def dump(port: int) -> str:
    """Return the statements that make the keyspace, and what is in it, one a line."""
    login = PlainTextAuthProvider("cassandra", PASSWORD)
    with Cluster(["127.0.0.1"], port=port, protocol_version=5, auth_provider=login) as cluster:
        session = cluster.connect(KEYSPACE)
        session.row_factory = dict_factory
        encoder, lines = Encoder(), []
        for name, table in sorted(cluster.metadata.keyspaces[KEYSPACE].tables.items()):
            lines.append(shortened(table.as_cql_query()))
            for row in session.execute(f"SELECT * FROM {name}"):
                values = {column: value for column, value in row.items() if value is not None}
                literals = ", ".join(map(encoder.cql_encode_all_types, values.values()))
                lines.append(f"INSERT INTO {name} ({', '.join(values)}) VALUES ({literals})")
    return "\n".join(lines) + "\n"


def shortened(statement: str) -> str:
    """Return what makes a table in any keyspace, without what Cassandra chooses itself."""
    columns, _, options = " ".join(statement.replace(f"{KEYSPACE}.", "").split()).partition(" WITH ")
    order = re.search(r"CLUSTERING ORDER BY \([^)]*\)", options)
    return columns if order is None else f"{columns} WITH {order.group()}"


def main(target: Path) -> None:
    """Write all into a folder."""
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="e-") as name:
        folder = Path(name)
        expected = {"data": written(folder / "embedded")}
        data = folder / "embedded" / "data"
        (target / "checkpoint.msgpack").write_bytes(keep_well(data / "ppaas.sqlite"))
        server = CassandraServer(folder / "cassandra")
        try:
            server.start()
            store = "--store", server.url(KEYSPACE)
            expected["keyspace"] = written(folder / "apart", *store)
            (target / "keyspace.cql").write_text(dump(server.port))
            with cloud(folder / "apart", *store) as rest:
                expected["outbox"] = asked_while_away(rest, server)
        finally:
            server.stop()
        with tarfile.open(target / "data.tar.xz", "w:xz") as archive:
            archive.add(data, "data", filter=nobodys)
            archive.add(folder / "apart" / "data" / "outbox.sqlite", "outbox.sqlite", filter=nobodys)
    (target / "expected.json").write_text(json.dumps(expected, separators=(",", ":")) + "\n")


def asked_while_away(rest: Rest, server: CassandraServer) -> dict[str, Any]:
    """Have a plan made that waits for its store."""
    rest.log_in("ann", ANN_PASSWORD)
    plan = rest.ask("GET", "/maps/house/plans?limit=1")["items"][0]
    ends = {"start": plan["goal"], "goal": plan["start"], "reuse": False}
    first = rest.ask("POST", "/maps/house/plans", ends | {"planner": "navfn"})
    rest.ask("GET", f"/plans/{first['plan_id']}/parts")  # once it is kept
    server.kill()
    made = rest.ask("POST", "/maps/house/plans", ends)
    wait_for(lambda: rest.ask("GET", "/health")["plans_waiting"])
    return {made["plan_id"]: without_poses(made)}


def nobodys(entry: tarfile.TarInfo) -> tarfile.TarInfo | None:
    """Leave out locks, and who owns what."""
    entry.uid = entry.gid = 0
    entry.uname = entry.gname = ""
    return None if entry.name.endswith((".lock", ".sending", ".sock")) else entry


if __name__ == "__main__":
    main(Path(sys.argv[1]))
