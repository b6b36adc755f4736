import math

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from robots.sim.actors import Actor, LeaveMap, Script, Stay, Walk, come_and_go, sit, talk, wander
from robots.sim.bodies.furniture import chair, furnished
from robots.sim.shortest_paths import ShortestPaths
from robots.sim.world import World
from tests.support.world.rooms import room

GRID = room(8.0, 6.0)


def paths(world: World) -> ShortestPaths:
    return ShortestPaths(furnished(world.grid, world.furniture), 0.35, np.random.default_rng(1))


def play(world: World, seconds: float) -> None:
    for _ in range(round(seconds / world.dt)):
        world.step()


def actor(world: World, at: Pose2D, *script: Walk | Stay | LeaveMap) -> Actor:
    return world.add_actor(paths(world), at, iter(script))


def test_an_actor_walks_to_places_and_stays_after_the_last() -> None:
    world = World(GRID, bodies=True)
    person = actor(world, Pose2D(1.0, 1.0), Walk(Pose2D(5.0, 3.0)), Stay(1.0, facing=math.pi))
    play(world, 12.0)
    assert world.people()[0] == pytest.approx((5.0, 3.0), abs=0.6)
    assert np.hypot(*person.velocity) < 0.01
    assert abs(world.figures[0].heading) == pytest.approx(math.pi)
    before = world.people().copy()
    play(world, 1.0)
    assert world.people() == pytest.approx(before)


def test_someone_who_left_is_out_of_sight_and_comes_back_to_the_same_place() -> None:
    world = World(GRID, bodies=True)
    robot = world.add_robot(Pose2D(4.0, 3.0))
    person = actor(world, Pose2D(2.0, 3.0), LeaveMap(2.0))
    play(world, 1.0)
    assert not person.present
    assert min(value for value in robot.scan().ranges if value is not None) > 2.0
    play(world, 2.0)
    assert person.present
    assert world.people()[0] == pytest.approx((2.0, 3.0))


def test_someone_who_comes_back_waits_until_the_place_is_free() -> None:
    world = World(GRID)
    person = actor(world, Pose2D(2.0, 3.0), LeaveMap(0.5))
    play(world, 0.3)
    actor(world, Pose2D(2.0, 3.2), Stay(2.0), Walk(Pose2D(6.0, 3.0)))
    play(world, 1.0)
    assert not person.present
    play(world, 5.0)
    assert person.present


def test_who_sits_down_sits_on_the_chair_and_gets_up_again() -> None:
    world, seat = World(GRID, bodies=True), Pose2D(5.0, 3.0, 0.5 * math.pi)
    world.add_furniture(chair(seat))
    person = world.add_actor(paths(world), Pose2D(2.0, 2.0), sit(seat, 3.0, iter([Walk(Pose2D(2.0, 2.0))])))
    while not person.sitting and world.time() < 20.0:
        world.step()
    play(world, 1.0)
    assert world.people()[0] == pytest.approx(seat[:2], abs=0.05)
    assert world.figures[0].stance.sitting
    assert world.figures[0].heading == pytest.approx(seat.theta)
    play(world, 15.0)
    assert not person.sitting
    assert world.people()[0] == pytest.approx((2.0, 2.0), abs=0.6)


def test_two_who_talk_face_each_other() -> None:
    world = World(GRID, bodies=True)
    for at, start in ((Pose2D(3.6, 3.0, 0.0), Pose2D(1.0, 1.0)), (Pose2D(4.4, 3.0, math.pi), Pose2D(7.0, 5.0))):
        world.add_actor(paths(world), start, talk(at, 60.0, iter([])))
    play(world, 20.0)
    assert world.people() == pytest.approx(np.array([[3.6, 3.0], [4.4, 3.0]]), abs=0.1)
    assert [abs(figure.heading) for figure in world.figures] == pytest.approx([0.0, math.pi], abs=0.02)


def test_endless_scripts_go_on_and_are_the_same_for_the_same_seed() -> None:
    ends = []
    for _ in range(2):
        world = World(GRID, seed=4, bodies=True)
        rng, ways = np.random.default_rng(3), paths(world)
        scripts: list[Script] = [
            wander(ways, rng, 2.0),
            come_and_go(Pose2D(1.0, 5.0), ways, rng, 5.0),
        ]
        for script in scripts:
            world.add_actor(ways, ways.anywhere(), script)
        play(world, 20.0)
        ends.append(world.people())
    assert (ends[0] == ends[1]).all()
