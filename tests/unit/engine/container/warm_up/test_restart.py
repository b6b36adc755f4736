import subprocess
import sys

import pytest

from tests.support.sources import ROOT


def run(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code], check=True, cwd=ROOT, env=environment, capture_output=True, text=True
    )
    return done.stdout


@pytest.mark.parametrize(("begun", "starts"), [({}, "first\nsecond\n"), ({"PPAAS_BEGUN_ANEW": "1"}, "second\n")])
def test_program_is_restarted_once_with_its_environment(begun, starts):
    code = """
import os
from engine.container.warm_up import restart
environment = dict(os.environ)
os.environ["KIND"] = "changed"
print("first" if "PPAAS_BEGUN_ANEW" not in environment else "second", flush=True)
assert environment["KIND"] == "given"
restart.restart_once(environment)
"""
    assert run(code, KIND="given", **begun) == starts
