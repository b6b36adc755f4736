import asyncio
import contextlib
import math

import pytest

from engine.control.buildings.building_runner import BuildingHooks, BuildingRunner
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.doors import controller
from ppaas.buildings.doors.states import Pass
from ppaas.buildings.faults import FaultChange, PartName
from ppaas.buildings.lifts.states import Alight, Board, Refuse, RemoveRide, StoreRide
from ppaas.clock import epoch
from ppaas.errors import Unavailable
from tests.support.buildings import LiftServer, layout
from tests.support.endpoints.serving import serve
from tests.support.waiting import until

HOSTS = DeviceHosts(["127.0.0.1"])


class Master:
    """What the runner needs of the master: robots that obey at once, and a store that may fail."""

    def __init__(self):
        self.rides = {}
        self.orders = []
        self.alerts = []
        self.store_is_down = False

    def runner(self, lift="sim:", door="sim:", hosts=HOSTS):
        hooks = BuildingHooks(self.obey, self.store, lambda: {"r"}, self.alerts.append)
        return BuildingRunner("cloud/b", layout(lift, door), hooks, hosts, rides=self.rides.values())

    def obey(self, order):
        if isinstance(order, Board | Alight):
            assert self.rides[order.robot].is_in_doorway, "its record is stored before it moves"
        self.orders.append(order)

    async def store(self, order):
        if self.store_is_down:
            raise Unavailable("no store")
        if isinstance(order, StoreRide):
            self.rides[order.ride.robot] = order.ride
        else:
            assert isinstance(order, RemoveRide)
            del self.rides[order.robot]


@contextlib.asynccontextmanager
async def running(runner):
    task = asyncio.create_task(runner.run())
    try:
        yield runner
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def ride(master, runner):
    runner.request("r", "A", "L1", "L3")
    await until(lambda: Board("r", "A", "L1") in master.orders)
    runner.entered("r")
    await until(lambda: Alight("r", "A", "L3") in master.orders)
    runner.left("r")
    await until(lambda: not master.rides)


async def test_a_robot_rides_in_a_simulated_lift():
    master = Master()
    async with running(master.runner()) as runner:
        await ride(master, runner)
        await until(lambda: runner.view().lifts[0].session == "")
        assert 0.0 < runner.waits()["A", "L1"] < 10.0


async def test_a_robot_rides_in_a_lift_behind_http_and_the_view_shows_it():
    master, server = Master(), LiftServer()
    async with serve(server) as port:
        url = f"http://127.0.0.1:{port}/lift?floors=L1:1,L2:2,L3:3&poll=0.1"
        async with running(master.runner(lift=url)) as runner:
            runner.request("r", "A", "L2", "L3")
            await until(lambda: Board("r", "A", "L2") in master.orders)
            view = runner.view().lifts[0]
            assert (view.fault, view.floor, view.target, view.door, view.mode) == ("", "L2", "L2", "open", "agv")
            assert [(each.robot, each.phase) for each in view.rides] == [("r", "boarding")]
            runner.entered("r")
            await until(lambda: Alight("r", "A", "L3") in master.orders)


async def test_a_door_is_opened_and_let_close():
    master = Master()
    async with running(master.runner()) as runner:
        runner.approach("r", "L1", "main")
        await until(lambda: Pass("r", "L1", "main") in master.orders)
        assert runner.view().doors[0].robots == ["r"]
        runner.passed("r", "L1", "main")
        await until(lambda: runner.view().doors[0].mode == "closed")


async def test_a_lift_out_of_order_and_its_repair_are_reported(monkeypatch):
    monkeypatch.setattr("ppaas.buildings.faults.PATIENCE", 0.1)
    master, server, lift = Master(), LiftServer(), PartName("lift", "A")
    async with serve(server) as port:
        url = f"http://127.0.0.1:{port}/lift?floors=L1:1,L2:2,L3:3&poll=0.1"
        async with running(master.runner(lift=url, door=f"http://127.0.0.1:{port}/door?poll=0.1")) as runner:
            await until(lambda: runner.has_heard_all)
            server.lift.set_mode("fire", epoch())
            await until(lambda: FaultChange(lift, "lift 'A' is in the mode 'fire'") in master.alerts)
            assert all(math.isinf(wait) for wait in runner.waits().values())
            assert runner.view().lifts[0].fault == "lift 'A' is in the mode 'fire'"
            server.lift.set_mode("agv", epoch())
            await until(lambda: FaultChange(lift, "") in master.alerts)
    ends = {"session": "ppaas/cloud/b/A", "end": True}
    assert all(order == ends for order in server.orders), "the door was only looked at, and no session is left"


async def test_a_runner_that_ends_lets_go_of_a_lift_that_is_called():
    master, server = Master(), LiftServer()
    async with serve(server) as port:
        url = f"http://127.0.0.1:{port}/lift?floors=L1:1,L2:2,L3:3&poll=0.1"
        async with running(master.runner(lift=url)) as runner:
            runner.request("r", "A", "L3", "L1")
            await until(lambda: server.orders and "floor" in server.orders[-1])
    assert server.orders[-1] == {"session": "ppaas/cloud/b/A", "end": True}


async def test_a_runner_that_is_killed_goes_on_from_the_stored_rides():
    master, server = Master(), LiftServer()
    async with serve(server) as port:
        url = f"http://127.0.0.1:{port}/lift?floors=L1:1,L2:2,L3:3&poll=0.1"
        async with running(master.runner(lift=url)) as runner:
            runner.request("r", "A", "L1", "L3")
            await until(lambda: Board("r", "A", "L1") in master.orders)
            runner.entered("r")
            await until(lambda: master.rides["r"].phase == "inside")
        master.orders.clear()
        async with running(master.runner(lift=url)) as runner:
            await until(lambda: Alight("r", "A", "L3") in master.orders)
            runner.left("r")
            await until(lambda: not master.rides)


async def test_no_robot_moves_on_a_ride_that_is_not_stored():
    master = Master()
    async with running(master.runner()) as runner:
        master.store_is_down = True
        runner.request("r", "A", "L1", "L3")
        await until(lambda: runner.view().lifts[0].door == "open")
        assert not any(isinstance(order, Board) for order in master.orders)
        master.store_is_down = False
        await until(lambda: Board("r", "A", "L1") in master.orders)


async def test_people_are_called_to_a_door_that_does_not_open(monkeypatch, caplog):
    monkeypatch.setattr(controller, "NO_OPENING", 0.2)
    master, server = Master(), LiftServer()
    server.door.set_fault("jammed", 0.0)
    async with serve(server) as port, running(master.runner(door=f"http://127.0.0.1:{port}/door?poll=0.1")) as runner:
        runner.approach("r", "L1", "main")
        await until(lambda: master.alerts)
    assert master.alerts[0].text == "door 'main' of floor 'L1' does not open"
    assert master.alerts[0].text in caplog.messages


@pytest.mark.parametrize("url", ["", "ftp://h"])
async def test_a_lift_without_a_device_that_opens_is_refused(url):
    master = Master()
    async with running(master.runner(lift=url)) as runner:
        runner.request("r", "A", "L1", "L3")
        await until(lambda: any(isinstance(order, Refuse) for order in master.orders))
        assert len(runner.view().faults) == (1 if url else 0)
        assert runner.view().lifts == []
