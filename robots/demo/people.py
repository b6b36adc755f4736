"""The demo of people: robots with depth cameras in an office find, count and follow people together."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.formats.map_files import save_map
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from ppaas.messages.people_coordination import FollowOrder, PeopleState, SensorView
from ppaas.nodes.topics import PEOPLE_STATE
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from robots.demo.demonstration import on_interrupt
from robots.demo.exploration import background
from robots.demo.options import CORES, CloudAccess, DemoOptions, Write
from robots.demo.people_patrol import DemoPatrol
from robots.demo.people_score import PeopleDemoReport, PeopleScore
from robots.demo.people_truth import TruthRecorder
from robots.demo.people_world import PeopleWorld, build_world
from robots.onboard.computer import this_computer
from robots.onboard.local_nodes import run_local_nodes
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.driver import Driver
from robots.sim.simulator import Simulator

WIDTH, HEIGHT = 14.0, 11.0
"""Size of the generated office [m]."""
CAMERA = DepthCameraModel(width=320, height=240)
"""Depth camera of the robots."""
DETECTORS = {"camera": "torso_detector", "laser": "leg_detector"}
"""Node that detects people, by the sensor."""
START_TIMEOUT = 120.0
"""Time limit until the coordinator has heard of all robots [s]."""
SILENCE = 30.0
"""Longest time without a state of the coordinator [s]."""


@dataclass(slots=True)
class PeopleStage:
    """World, robots and score of the demo.

    Parameters
    ----------
    map_id : str
    grid : GridMap
    scene : PeopleWorld
    robots : list of str
        Ids of the robots.
    """

    map_id: str
    grid: GridMap
    scene: PeopleWorld
    robots: list[str]
    truth: TruthRecorder = field(init=False)
    state: PeopleState | None = None
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    def __post_init__(self) -> None:
        """Record the truth of the world."""
        self.truth = TruthRecorder(self.scene, self.robots)

    def hear(self, state: PeopleState) -> None:
        """Take a state of the coordinator."""
        self.state = state
        self.changed.set()


def set_stage(options: DemoOptions) -> PeopleStage:
    """Take or generate the map, and place furniture, robots and people.

    Raises
    ------
    PPaaSError
        The map is too small.
    """
    map_id, grid = options.map or ("office", office(options.seed, WIDTH, HEIGHT))
    rng = np.random.default_rng(options.seed)
    scene = build_world(grid, options.robots, options.people, CAMERA if options.sensor == "camera" else None, rng)
    names = [f"turtlebot-{number}" for number in range(1, options.robots + 1)]
    return PeopleStage(map_id, grid, scene, names)


async def follow_people(options: DemoOptions, cloud: CloudAccess) -> PeopleDemoReport:
    """Run the demo in a cloud; return its report.

    Raises
    ------
    PPaaSError
        The map or the options are invalid, the cloud rejects the login, or no coordinator answers.
    """
    async with contextlib.AsyncExitStack() as stack:
        stage = await asyncio.to_thread(set_stage, options)
        rest = RestClient(cloud.url)
        login = await rest.login(cloud.admin, cloud.password)
        await _register(rest, stage, options)
        simulator = Simulator(stage.scene.world, after_step=stage.truth.step)
        await stack.enter_async_context(background(simulator.run()))
        for number, robot in enumerate(stage.robots):
            await _connect(stack, cloud, login.token, stage, number, options=options)
            options.write(f"{robot} is connected")
        return await _score(stage, options)


async def _register(rest: RestClient, stage: PeopleStage, options: DemoOptions) -> None:
    """Publish the map and the areas of the furniture, and register the robots."""
    mask = f"{stage.map_id}-furniture"
    for map_id, grid in ((stage.map_id, stage.grid), (mask, stage.scene.keepout)):
        await rest.upload_map(map_id, *save_map(grid, "map.pgm"))
    parameters: dict[str, Any] = {
        DETECTORS[options.sensor]: {},
        "follow_person": {},
        "keepout_filter": {"filter_mask": mask},
    }
    for robot, body in zip(stage.robots, stage.scene.world.robots, strict=True):
        x, y, yaw = body.base.pose
        file = RobotFile(
            map=stage.map_id,
            initial_pose=(x, y, yaw),
            cores=CORES,
            base_global_planner=options.planner,
            base_local_planner=options.controller,
            parameters=parameters,
        )
        await rest.put_robot(robot, file)


async def _connect(
    stack: contextlib.AsyncExitStack,
    access: CloudAccess,
    token: str,
    stage: PeopleStage,
    number: int,
    *,
    options: DemoOptions,
) -> None:
    """Connect a robot, its local nodes and its operator until the stack is closed."""
    robot, body = stage.robots[number], stage.scene.world.robots[number]
    client = await stack.enter_async_context(RobotClient(access.url, robot=robot, token=token))
    await stack.enter_async_context(background(Driver(body, client).run()))
    if options.on_robot:
        wanted = {DETECTORS[options.sensor]: "robot"}
        computer = await asyncio.to_thread(this_computer)
        await stack.enter_async_context(background(run_local_nodes(client, computer, wanted, options.write)))
    operator = await stack.enter_async_context(RobotClient(access.url, robot=robot, token=token, role="operator"))
    await operator.subscribe(f"{DETECTORS[options.sensor]}/view", SensorView, partial(_note_view, stage, robot))
    if number == 0:
        # All robots of the group hear the same states.
        await operator.subscribe(PEOPLE_STATE.name, PeopleState, stage.hear, queue_size=10)
    patrol = DemoPatrol(robot, operator, stage.scene.ways, lambda: stage.state)
    await stack.enter_async_context(background(patrol.run()))


def _note_view(stage: PeopleStage, robot: str, view: SensorView) -> None:
    stage.truth.views[robot] = [view]


# -- score -------------------------------------------------------------------------------------------------------------


async def _score(stage: PeopleStage, options: DemoOptions) -> PeopleDemoReport:
    """Wait for all robots, then compare the states of the coordinator with the truth."""
    await wait_for_robots(stage)
    options.write("all robots take part; the score begins")
    score, began = PeopleScore(options.people), monotonic()
    stage.truth.begin()
    if options.keep_going:
        scoring = asyncio.create_task(_compare(stage, score, math.inf, options.write))
        with on_interrupt([scoring]):
            await asyncio.wait([scoring])
        if not scoring.cancelled():
            scoring.result()
    else:
        await _compare(stage, score, began + options.seconds, options.write)
    figures = score.figures(stage.truth.contacts())
    return PeopleDemoReport(stage.map_id, round(monotonic() - began, 2), options.robots, options.people, figures)


async def _compare(stage: PeopleStage, score: PeopleScore, until: float, write: Write) -> None:
    """Compare states with the truth until a time [s]."""
    last = stage.state
    while monotonic() < until:
        async with _time_limit(stage, SILENCE):
            state = await _next(stage)
        write_changes(last, state, write)
        last = state
        truth = stage.truth.at(state.header.stamp.seconds())
        if truth is not None:
            score.take(truth, state)


async def wait_for_robots(stage: PeopleStage) -> None:
    """Wait until the coordinator hears all robots, and their detectors run.

    Raises
    ------
    Unavailable
        This took longer than `START_TIMEOUT`.
    """
    async with _time_limit(stage, START_TIMEOUT):
        while stage.state is None or len(stage.state.robots) < len(stage.robots) or not all(stage.truth.views.values()):
            await _next(stage)


async def _next(stage: PeopleStage) -> PeopleState:
    stage.changed.clear()
    await stage.changed.wait()
    assert stage.state is not None
    return stage.state


@contextlib.asynccontextmanager
async def _time_limit(stage: PeopleStage, limit: float) -> AsyncIterator[None]:
    """Raise `Unavailable` if the block takes longer than a time [s]."""
    try:
        async with asyncio.timeout(limit):
            yield
    except TimeoutError as error:
        heard = [robot.robot for robot in stage.state.robots] if stage.state else []
        views = [robot for robot, view in stage.truth.views.items() if view]
        raise Unavailable(
            f"no state of people of all robots within {limit:g} s: the coordinator hears {heard}, and detectors "
            f"run for {views}; see the containers with 'ppaas container list'"
        ) from error


def write_changes(before: PeopleState | None, state: PeopleState, write: Write) -> None:
    """Write what has changed: the number of people, and who follows whom."""
    if before is not None and before.count != state.count:
        write("1 person is seen" if state.count == 1 else f"{state.count} people are seen")
    known = {} if before is None else {(order.robot, order.person): order for order in before.orders}
    for order in state.orders:
        if (order.robot, order.person) not in known:
            write(_sentence(order))


def _sentence(order: FollowOrder) -> str:
    return f"{order.robot} follows person {order.person}: {order.reason}"
