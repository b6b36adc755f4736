import pytest

from ppaas.controllers.base import Velocity
from ppaas.recoveries import create
from tests.support.world.recovering import Run


def test_robot_waits_for_the_given_duration():
    wait = create("wait", wait_duration=1.5)
    for _ in range(2):
        run = Run(wait)
        assert run.to_the_end() == pytest.approx(1.5, abs=0.11)
        assert set(run.velocities) == {Velocity()}
