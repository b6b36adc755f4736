"""Driving by hand over real sockets: commands, the dead-man's control, walls, other drivers, and faults of links."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio

from ppaas.errors import Conflict, PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.teleop import PERIOD, Hand, driving_by_hand
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.local_nodes import ABLE, managing
from tests.support.network.forwarder import Forwarder
from tests.support.waiting import patience, until
from tests.support.world.planar_world import walled_map

pytestmark = [pytest.mark.journey, pytest.mark.asyncio(loop_scope="module")]

ROOM = walled_map(6.0, 4.0, [])
START = Pose2D(4.0, 2.0, 0.0)
ROBOT = "tb-hand"


class StallingForwarder(Forwarder):
    """Forwarder whose connections can stall: what comes meanwhile is forwarded later, in order."""

    def __init__(self, url: str) -> None:
        super().__init__(url)
        self.flows = asyncio.Event()
        self.flows.set()

    async def pipe(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while data := await reader.read(1 << 16):
                await self.flows.wait()
                writer.write(data)
                await writer.drain()
        writer.close()


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def token(cloud: RunningCloud) -> str:
    """Return the token of a user who has a robot."""
    admin, rest = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": "hanna", "password": ADMIN_PASSWORD})
    await rest.login("hanna", ADMIN_PASSWORD)
    await publish_map(rest, "hand-room", ROOM)
    return await register_robot(rest, ROBOT, "hand-room", START)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def drive(cloud: RunningCloud, token: str) -> AsyncIterator[Drive]:
    """Return the robot, which stands in a room, with an operator."""
    async with driving(cloud.url, token, ROBOT, ROOM, START) as drive:
        await until(lambda: drive.poses)
        yield drive


async def hold(hand: Hand, linear: float, angular: float = 0.0, *, seconds: float) -> None:
    """Hold the control for a time [s], and press it again if a busy computer has locked it."""
    for _ in range(round(seconds / PERIOD)):
        if hand.state is not None and hand.state.mode == "locked":
            await hand.let_go()
        await hand.drive(linear, angular)
        await asyncio.sleep(PERIOD)


async def press(hand: Hand, angular: float, *, seconds: float) -> None:
    """Hold the control for a time, whatever the robot says [s]."""
    for _ in range(round(seconds / PERIOD)):
        await hand.drive(0.0, angular)
        await asyncio.sleep(PERIOD)


def commanded(drive: Drive, since: int) -> set[tuple[float, float]]:
    """Return the velocities that have come to the robot since a number of them."""
    return {(twist.linear.x, twist.angular.z) for _, twist in drive.commands[since:]}


def last(drive: Drive) -> tuple[float, float]:
    twist = drive.commands[-1][1]
    return twist.linear.x, twist.angular.z


async def test_a_robot_is_driven_and_stops_when_the_control_is_let_go(drive: Drive) -> None:
    begin, had = drive.world.robots[0].base.pose, len(drive.commands)
    async with driving_by_hand(drive.operator) as hand:
        await hold(hand, 0.3, seconds=1.5)
        assert (0.3, 0.0) in commanded(drive, had)
        await hand.let_go()
        await until(lambda: last(drive) == (0.0, 0.0))
        assert hand.state is not None and hand.state.driver == "hanna", "the cloud says who drives"
    assert begin.distance_to(drive.world.robots[0].base.pose) > 0.2


async def test_the_robot_stops_before_a_wall_and_leaves_it(drive: Drive) -> None:
    async with driving_by_hand(drive.operator) as hand:
        async with patience(30.0):
            while hand.state is None or hand.state.mode != "blocked":
                await hold(hand, 0.5, seconds=0.1)
        await hold(hand, 0.5, seconds=0.5)
        assert last(drive) == (0.0, 0.0)
        assert drive.scorer.collisions(0) == 0
        near = drive.world.robots[0].base.pose
        await hold(hand, -0.4, seconds=2.0)
        assert near.distance_to(drive.world.robots[0].base.pose) > 0.4


async def test_a_goal_waits_while_somebody_drives_and_goes_on_if_the_robot_is_given_back(drive: Drive) -> None:
    await drive.send(START, "first")
    async with driving_by_hand(drive.operator) as hand:
        await hold(hand, 0.0, 0.5, seconds=0.3)
        await drive.send(START, "second")
        rejected = (await drive.result()).status
        assert (rejected.status, rejected.text) == (Status.REJECTED, "hanna drives the robot by hand")
        await hand.leave(give_back=True)
    reached = (await drive.result()).status
    assert (reached.goal_id.id, reached.status) == ("first", Status.SUCCEEDED)
    await drive.send(Pose2D(2.0, 2.0), "third")
    async with driving_by_hand(drive.operator) as hand:
        await hold(hand, 0.0, 0.5, seconds=0.3)
    assert (await drive.result()).status.status == Status.PREEMPTED, "nobody has given it back"
    assert await drive.go(START) < 0.3


async def test_one_operator_drives_until_another_takes_over(drive: Drive, cloud: RunningCloud, token: str) -> None:
    async with (
        RobotClient(cloud.url, robot=ROBOT, token=token, role="operator") as second,
        driving_by_hand(drive.operator) as hand,
    ):
        with pytest.raises(Conflict, match="hanna drives the robot"):
            async with driving_by_hand(second):
                pass
        await hold(hand, 0.0, 0.4, seconds=0.3)
        async with driving_by_hand(second, take_over=True) as other:
            await until(lambda: not hand.drives)
            with pytest.raises(Conflict):
                await hand.drive(0.0, 0.4)
            had = len(drive.commands)
            await hold(other, 0.0, -0.3, seconds=0.5)
            assert {(0.0, -0.3)} <= commanded(drive, had) <= {(0.0, 0.0), (0.0, -0.3)}


async def test_a_link_that_stalls_stops_the_robot_which_does_not_move_when_it_recovers(
    drive: Drive, cloud: RunningCloud, token: str
) -> None:
    async with (
        StallingForwarder(cloud.url) as link,
        RobotClient(link.url, robot=ROBOT, token=token, role="operator") as far,
        driving_by_hand(far) as hand,
    ):
        had = len(drive.commands)
        await hold(hand, 0.0, 0.4, seconds=0.5)
        assert (0.0, 0.4) in commanded(drive, had)
        link.flows.clear()
        stalled = asyncio.create_task(press(hand, 0.4, seconds=1.0))
        await until(lambda: last(drive) == (0.0, 0.0))
        await stalled
        stopped = len(drive.commands)
        link.flows.set()
        await press(hand, 0.4, seconds=0.5)
        assert commanded(drive, stopped) == {(0.0, 0.0)}
        assert hand.state is not None and hand.state.mode == "locked"
        had = len(drive.commands)
        await hold(hand, 0.0, 0.4, seconds=0.5)
        assert (0.0, 0.4) in commanded(drive, had)
    await until(lambda: last(drive) == (0.0, 0.0))


async def test_one_who_may_only_look_does_not_drive(cloud: RunningCloud, drive: Drive, token: str) -> None:
    admin = await cloud.admin()
    await admin.post("/v1/users", {"id": "lena", "password": ADMIN_PASSWORD})
    owner, lena = RestClient(cloud.url, token), RestClient(cloud.url)
    await owner.put(f"/v1/robots/{ROBOT}/shares/lena", {"role": "look"})
    await lena.login("lena", ADMIN_PASSWORD)
    told: list[PPaaSError] = []
    async with RobotClient(
        cloud.url, robot=f"hanna:{ROBOT}", token=lena.token, role="operator", hold=False, on_status=told.append
    ) as looking:
        hand = Hand(looking)
        asking = asyncio.create_task(hand.begin())
        await until(lambda: told)
        asking.cancel()
    assert "needs the role 'drive'" in str(told[0])


async def test_a_robot_with_move_base_on_board_is_driven_in_the_same_way(drive: Drive) -> None:
    async with managing(drive.robot, ABLE) as manager:
        await manager.ask("move_base", "robot")
        await until(lambda: manager.running == {"move_base"}, 60)
        had = len(drive.commands)
        async with driving_by_hand(drive.operator) as hand:
            await hold(hand, 0.0, 0.3, seconds=1.0)
            assert (0.0, 0.3) in commanded(drive, had)
            await hand.let_go()
            await until(lambda: last(drive) == (0.0, 0.0))
