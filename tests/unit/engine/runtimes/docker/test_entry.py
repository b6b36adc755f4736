"""Main program of a Docker container."""

import subprocess
import sys


def test_numpy_is_left_to_the_preload_which_sets_its_threads() -> None:
    code = "import sys, engine.runtimes.docker.entry; print({'numpy', 'asyncio', 'uvloop'} & sys.modules.keys())"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == "set()"
