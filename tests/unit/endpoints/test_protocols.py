"""Protocols on ports of their own: each is loaded if its port is given, and not by a plain cloud."""

import json
import subprocess
import sys

import pytest

from endpoints.protocols import MAX_FRAME, PROTOCOLS

LOADED_IF_ASKED = {"ray", "endpoints.rapyuta", "ppaas.wire.rapyuta", "endpoints.foxglove"}
PROCESSES = (
    "endpoints.cloud_processes.server",
    "endpoints.cloud_processes.endpoint_process",
    "engine.agent.agent",
    "engine.container.entry",
)


@pytest.mark.parametrize("process", PROCESSES)
def test_a_process_of_a_plain_cloud_loads_neither_ray_nor_other_protocols(process: str) -> None:
    code = f"import json, sys, {process}; print(json.dumps(sorted(sys.modules)))"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not LOADED_IF_ASKED & set(json.loads(ended.stdout))


def test_protocols_are_named_as_their_options() -> None:
    assert PROTOCOLS.names() == ("foxglove", "rapyuta")
    assert PROTOCOLS.load("foxglove").max_frame < PROTOCOLS.load("rapyuta").max_frame == MAX_FRAME
