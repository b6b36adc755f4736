"""Steps of priority inheritance are valid, and the robot with the highest priority gets nearer to its goal."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.fleet.kernels.board import NO_GUIDE, UNREACHABLE, Board, Step, step_of
from ppaas.fleet.kernels.pibt import decide, is_possible
from ppaas.fleet.problem import board_of, distances_from
from tests.reference.fleet.searches import has_ring, has_room
from tests.support.fleet.halls import Hall, hall_of, halls, ruled_halls


def board_in(hall: Hall) -> Board:
    goals = np.array(hall.goals, np.int32)
    return board_of(hall.roadmap, distances_from(hall.roadmap, goals), NO_GUIDE, goals)


def step_in(hall: Hall, seed: int) -> Step:
    return step_of(board_in(hall), np.array(hall.starts, np.int32), seed)


def is_valid(hall: Hall, step: Step) -> bool:
    """Return whether a step moves each robot by one cell at most, without any conflict."""
    before, after = tuple(step.at.tolist()), tuple(step.to.tolist())
    beside = all(
        here == there or there in hall.roadmap.neighbours[here] for here, there in zip(before, after, strict=True)
    )
    conflict = len(set(after)) < len(after) or has_ring(before, after) or not has_room(hall.roadmap, before, after)
    return beside and not conflict


@given(halls(most_cells=20, most_robots=12) | ruled_halls(most_cells=20, most_robots=12), st.integers(0, 1000))
def test_steps_are_valid_and_leave_the_scratch_memory_empty(hall: Hall, seed: int) -> None:
    board, step = board_in(hall), step_in(hall, seed)
    order = np.random.default_rng(seed).permutation(len(hall.starts))
    for _ in range(5):
        step.to[:] = -1
        assert decide(board, step, order)
        assert is_valid(hall, step)
        assert (step.here == -1).all() and (step.next == -1).all()
        step.at[:] = step.to


@given(halls(most_cells=20, most_robots=6) | ruled_halls(most_cells=20, most_robots=6), st.integers(0, 1000), st.data())
def test_decisions_that_are_there_are_kept_or_refused(hall: Hall, seed: int, data: st.DataObject) -> None:
    board, step = board_in(hall), step_in(hall, seed)
    for robot, cell in enumerate(hall.starts):
        ways = [-1, cell, *(int(near) for near in hall.roadmap.neighbours[cell] if near >= 0)]
        step.to[robot] = data.draw(st.sampled_from(ways))
    wanted = step.to.copy()
    fixed = [(hall.starts[robot], int(cell)) for robot, cell in enumerate(wanted) if cell >= 0]
    cells = [cell for _, cell in fixed]
    stay = tuple(there if there >= 0 else here for here, there in zip(hall.starts, wanted.tolist(), strict=True))
    possible = len(set(cells)) == len(cells) and not has_ring(tuple(here for here, _ in fixed), tuple(cells))
    possible = possible and has_room(hall.roadmap, tuple(hall.starts), stay)
    assert is_possible(board, step) == possible
    if possible and decide(board, step, np.arange(len(wanted))):
        assert is_valid(hall, step)
        assert (step.to[wanted >= 0] == wanted[wanted >= 0]).all()


def test_a_robot_pushes_others_out_of_its_way() -> None:
    hall = hall_of("""
        aB.A
        ##b#
        """)
    hall = hall._replace(starts=[hall.starts[0], hall.starts[0] + 1])
    board, step = board_in(hall), step_in(hall, 0)
    assert decide(board, step, np.array([0, 1]))
    assert step.to.tolist() == [hall.starts[0] + 1, hall.starts[0] + 2]


def test_goals_without_a_way_do_not_disturb() -> None:
    hall = hall_of("a.#A")
    board, step = board_in(hall), step_in(hall, 0)
    assert board.distances[0, step.at[0]] == UNREACHABLE
    assert decide(board, step, np.array([0]))
