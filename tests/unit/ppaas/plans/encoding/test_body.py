"""Plan bodies survive encoding, and numbers with few decimals are short."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import Unavailable
from ppaas.plans.encoding.body import NAMES, bodies_near, read_bodies, read_body, write_bodies
from ppaas.plans.encoding.chunks import words_of
from ppaas.plans.encoding.kernels.quaternions import quaternion_near, quaternion_towards
from ppaas.plans.encoding.recipes import numbers_in, read_recipe, recipes_of
from ppaas.plans.passages import joins
from tests.reference.plans import plan_bytes

wild = st.floats(allow_nan=False)
decimal = st.integers(-(10**12), 10**12).map(lambda number: number / 1000.0)
fine = st.integers(-(10**12), 10**12).map(lambda number: number / 1e6 + 0.05)
any_number = wild | decimal | fine | st.just(-0.0)


def bits(numbers) -> bytes:
    return np.array(numbers).tobytes()


def body_of(name: str, numbers, poses, between: bytes | None = None) -> bytes:
    [body], _ = write_bodies([name], [numbers], words_of(np.array(poses)), np.array([len(poses)]), [between])
    return body


poses = st.tuples(*[any_number] * 7)
numbers = st.tuples(*[any_number] * len(NAMES))
names = st.sampled_from(["p1", "0" * 32, "0123456789abcdef" * 2, "A" * 32, "0 " * 16, "x" * 64])


@given(st.lists(st.tuples(names, numbers, st.lists(poses, min_size=1, max_size=6)), min_size=1, max_size=4))
def test_bodies_round_trip(plans) -> None:
    words = words_of(np.array([pose for *_, path in plans for pose in path]))
    stops = np.cumsum([len(path) for *_, path in plans])
    bodies, ends = write_bodies(
        [name for name, *_ in plans], [each for _, each, _ in plans], words, stops, [None] * len(plans)
    )
    for own, (name, expected, path), (x, y, to_x, to_y) in zip(read_bodies(bodies), plans, ends.tolist(), strict=True):
        assert (own.plan_id, own.count, own.shared) == (name, len(path), len(path) > 3)
        assert bits(own.numbers()) == bits(expected)
        assert bits(own.ends()) == bits((path[0][:2], path[-1][:2])) == bits(((x, y), (to_x, to_y)))
        middle = [np.array(path[1:-2])] if len(path) > 3 else []
        assert own.poses(middle).tobytes() == bits(path)


@given(st.lists(st.tuples(*[st.integers(-4, 4)] * 4), min_size=1), st.tuples(*[st.integers(-4, 4)] * 4))
def test_bodies_near_finds_the_plans_with_near_ends(plans, sought) -> None:
    start, goal = sought[:2], sought[2:]
    paths = [[(x, y, 0, 0, 0, 0, 1.0), (to_x, to_y, 0, 0, 0, 0, 1.0)] for x, y, to_x, to_y in plans]
    bodies = [body_of(str(at), (0.5,) * 10, path) for at, path in enumerate(paths)]
    ends = [(plan[:2], plan[2:]) for plan in plans]
    near = [at for at, (first, last) in enumerate(ends) if joins(first, last, start, goal, 5.0)]
    assert [at for at, _ in bodies_near(bodies, start, goal, 5.0)] == near  # at whole metres, some are exactly 5 m away
    assert [own for _, own in bodies_near(bodies, start, goal, 5.0)] == [read_body(bodies[at]) for at in near]


@given(numbers, st.sampled_from([0.0, 1.0, math.nextafter(1.0, 2.0), 1.0 + 1e-12]))
def test_numbers_are_written_like_by_the_twin(numbers, near) -> None:
    created, length, _, *rest = numbers
    cost = length * 1000.0 * near
    numbers = (created, length, cost, *rest)
    fields = plan_bytes.tagged(body_of("0" * 32, numbers, np.ones((1, 7)))[18:], 22)
    expected = [0.0, 0.0, length * 1000.0] + [0.0] * 7
    again = [plan_bytes.number(fields[at], expected[at]) if at in fields else expected[at] for at in range(10)]
    assert bits(again) == bits(numbers)


def test_numbers_with_few_decimals_are_short() -> None:
    numbers = (1.8e9, 12.375, 12375.0, 0.001234, 1.025, 2.0, 1.5708, 3.0, 4.0, -1.5708)
    yaws = [quaternion_near(yaw) for yaw in (1.5708, -1.5708)]
    poses = [(1.025, 2.0, 0, 0, 0, *yaws[0]), (3.0, 4.0, 0, 0, 0, *yaws[1])]
    fields = plan_bytes.tagged(body_of("0" * 32, numbers, poses)[18:], 22)
    sizes = {NAMES[at]: len(data) - 1 for at, data in fields.items() if at < len(NAMES)}
    assert sizes == {
        "created": 6, "length": 2, "seconds": 3, "start_x": 2, "start_y": 2, "start_yaw": 4, "goal_x": 2, "goal_y": 2,
        "goal_yaw": 4,
    }  # fmt: skip
    assert not {10, 11, 12, 13, 14, 15, 16, 17} & fields.keys()


@given(st.lists(st.lists(st.integers(0, 1 << 40)), min_size=1))
def test_recipes_round_trip(lists: list[list[int]]) -> None:
    stops = np.cumsum([len(each) for each in lists])
    recipes = recipes_of([number for each in lists for number in each], stops)
    assert recipes == [plan_bytes.recipe(each) for each in lists]
    numbers, ends = numbers_in(recipes)
    assert numbers.tolist() == [number for each in lists for number in each]
    assert ends.tolist() == stops.tolist()
    assert [read_recipe(recipe) for recipe in recipes] == lists


def test_recipes_of_consecutive_numbers_are_short() -> None:
    [recipe] = recipes_of(range(100_000, 100_050), np.array([50]))
    assert len(recipe) == 52


@given(st.floats(-math.pi, math.pi) | st.sampled_from([0.0, -0.0, 1.5708, 3.1416, math.pi]))
def test_quaternion_near_is_exact_to_the_last_place(yaw: float) -> None:
    found, true = quaternion_near(yaw), plan_bytes.headings(yaw)
    assert max(abs(plan_bytes.bits(abs(a)) - plan_bytes.bits(abs(b))) for a, b in zip(found, true, strict=True)) <= 1


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_quaternion_towards_agrees_with_the_twin(x: float, y: float) -> None:
    if x * x + y * y > 1e-200:
        qz, qw = quaternion_towards(x, y)
        true = plan_bytes.headings(math.atan2(y, x))
        assert (abs(qz), qw) == pytest.approx((abs(true[0]), true[1]), abs=1e-12)


@pytest.mark.parametrize("cut", [0, 1, 2, 5, 20, 40])
def test_damaged_bodies_are_refused(cut: int) -> None:
    pose = (0.1234567891, 0.2, 0.0, 0.0, 0.0, 0.0, 1.0)
    whole = body_of("0" * 32, (0.1,) * 10, [pose] * 9)
    with pytest.raises(Unavailable):
        read_body(whole[:cut])
    with pytest.raises(Unavailable):
        read_body(whole).poses([])
    with pytest.raises(Unavailable, match="format"):
        read_body(b"\x0f" + whole[1:])
    with pytest.raises(Unavailable):
        read_recipe(b"\x80")
