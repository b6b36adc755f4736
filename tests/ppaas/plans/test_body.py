"""What is a plan's own comes back from bytes as it was, and numbers that people give are short."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import Unavailable
from ppaas.plans.body import read_body, write_body
from ppaas.plans.headings import quaternion_near, quaternion_towards
from ppaas.plans.numbers import read_tokens, value_of, write_numbers
from ppaas.plans.recipes import read_recipe, write_recipe

wild = st.floats(allow_nan=False)
decimal = st.integers(-(10**12), 10**12).map(lambda number: number / 1000.0)
fine = st.integers(-(10**12), 10**12).map(lambda number: number / 1e6 + 0.05)
values = st.lists(wild | decimal | fine | st.just(-0.0), min_size=1, max_size=9)


def bits(numbers) -> bytes:
    return np.array(numbers).tobytes()


@settings(max_examples=40, deadline=None)
@given(values, st.data())
def test_numbers_come_back(numbers: list[float], data: st.DataObject) -> None:
    expected = [data.draw(st.sampled_from([0.0, number, math.nextafter(number, 0.0)])) for number in numbers]
    written = write_numbers(numbers, expected)
    tokens, end = read_tokens(b"x" + written + b"y", len(numbers), 1)
    assert end == len(written) + 1
    assert bits([value_of(*each) for each in zip(tokens, expected, strict=True)]) == bits(numbers)


def test_numbers_of_few_places_are_short() -> None:
    assert len(write_numbers([0.0, 12.375, 1.5708, 1.8e9], [0.0] * 4)) == 2 + 0 + 2 + 4 + 6
    assert len(write_numbers([math.pi], [math.pi])) == 1


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 1 << 40)))
def test_recipes_come_back(numbers: list[int]) -> None:
    assert read_recipe(write_recipe(numbers)) == numbers


def test_recipes_of_neighbours_are_short() -> None:
    assert len(write_recipe(range(100_000, 100_050))) == 52


@settings(max_examples=40, deadline=None)
@given(st.floats(-math.pi, math.pi))
def test_quaternions_are_foreseen(yaw: float) -> None:
    assert quaternion_near(yaw) == pytest.approx((math.sin(yaw / 2), math.cos(yaw / 2)), abs=1e-15)


@settings(max_examples=40, deadline=None)
@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
def test_headings_are_foreseen(x: float, y: float) -> None:
    if x * x + y * y > 1e-200:
        yaw = math.atan2(y, x)
        qz, qw = quaternion_towards(x, y)
        assert (abs(qz), qw) == pytest.approx((abs(math.sin(yaw / 2)), math.cos(yaw / 2)), abs=1e-12)


poses = st.tuples(*[wild | decimal] * 7)
numbers = st.tuples(*[wild | decimal] * 10)
names = st.sampled_from(["p1", "0" * 32, "0123456789abcdef" * 2, "A" * 32, "x" * 64])


@settings(max_examples=40, deadline=None)
@given(names, st.integers(4, 1 << 20), numbers, poses, poses, poses)
def test_bodies_come_back(name, count, numbers, first, before, last) -> None:
    own = read_body(write_body(name, count, numbers, (first, before, last), None))
    assert (own.plan_id, own.count, own.shared) == (name, count, True)
    assert bits(own.numbers()) == bits(numbers)
    assert bits(own.ends()) == bits((first[:2], last[:2]))
    middle = np.zeros((count - 3, 7))
    assert own.poses([middle]).tobytes() == bits([first]) + middle.tobytes() + bits([before, last])


@pytest.mark.parametrize("cut", [0, 1, 5, 20, 40])
def test_damaged_bodies_are_told(cut: int) -> None:
    pose = (0.1234567891, 0.2, 0.0, 0.0, 0.0, 0.0, 1.0)
    whole = write_body("0" * 32, 9, (0.1,) * 10, (pose, pose, pose), None)
    with pytest.raises(Unavailable):
        read_body(whole[:cut])
    with pytest.raises(Unavailable):
        read_body(whole).poses([])
    with pytest.raises(Unavailable, match="format"):
        read_body(b"\x0f" + whole[1:])
    with pytest.raises(Unavailable):
        read_recipe(b"\x80")
