"""State of a cloud that is starting, in words and as a refusal."""

import pytest

from engine.protocols.refusals import error_of, refusal_of
from engine.specs.start_state import READY, KernelProgress, StartState, explained, short_name
from ppaas.errors import NotFound, Starting, Unavailable

SOME = KernelProgress(12, 107, ("lattice/hybrid_astar",))


def test_a_module_is_named_by_its_room_and_its_file() -> None:
    assert short_name("ppaas.planners.lattice.kernels.hybrid_astar") == "lattice/hybrid_astar"
    assert short_name("ppaas.fleet.kernels.lacam") == "fleet/lacam"
    assert short_name("ppaas.planners.kernels.smoothing") == "planners/smoothing"


def test_progress_says_what_is_compiled_and_how_much_of_all() -> None:
    assert str(SOME) == "compiling kernels, 12 of 107 (now lattice/hybrid_astar)"
    assert not SOME.is_complete and KernelProgress(107, 107).is_complete


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (READY, ""),
        (StartState(ready=False, machines={"m1": None}), "the cloud is starting: its machine is starting"),
        (StartState(ready=False, machines={"m1": SOME}), f"the cloud is starting: {SOME}"),
        (StartState(machines={"m1": SOME}), f"the cloud: {SOME}"),
        (StartState(machines={"m1": SOME, "m2": KernelProgress(13, 107)}), "the cloud: compiling kernels, 13 of 107"),
    ],
)
def test_the_reason_names_the_machine_that_is_furthest(state: StartState, text: str) -> None:
    assert state.text == text


def test_a_refusal_says_when_to_try_again_also_in_another_process() -> None:
    assert READY.refusal() is None
    refusal = StartState(ready=False, machines={"m1": SOME}).refusal()
    assert refusal is not None and "12 of 107" in str(refusal)
    arrived = error_of(refusal_of(refusal))
    assert isinstance(arrived, Starting)
    assert (str(arrived), arrived.retry_after) == (str(refusal), refusal.retry_after)
    assert refusal.retry_after is not None


def test_what_is_unavailable_before_the_start_is_explained_by_it() -> None:
    with pytest.raises(Starting, match="12 of 107"), explained(lambda: StartState(ready=False, machines={"m1": SOME})):
        raise Unavailable("no machine has room")


@pytest.mark.parametrize(
    ("state", "error"),
    [
        (StartState(ready=False, machines={"m1": SOME}), NotFound("map", "hall")),
        (StartState(machines={"m1": SOME}), Unavailable("no machine has room")),
        (READY, Unavailable("no machine has room")),
    ],
)
def test_other_errors_stay(state: StartState, error: Exception) -> None:
    with pytest.raises(type(error)) as raised, explained(lambda: state):
        raise error
    assert raised.value is error
