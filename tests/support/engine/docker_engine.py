"""The Docker Engine of tests, started by the command in ``$PPAAS_DOCKER_UP``."""

import functools
import os
import subprocess
import tempfile
from pathlib import Path

import pytest

from tests.support.sources import ROOT

UP = "PPAAS_DOCKER_UP"
UP_TIMEOUT = BUILD_TIMEOUT = 1200.0

ENGINE_IMAGE, TEST_IMAGE = "ppaas-engine", "ppaas-engine-test"
"""The image that users build, and the same with the test entry points."""

TEST_FILES = """\
FROM {image}
COPY tests /opt/tests/tests
COPY hostile_plugin /opt/tests
ENV PYTHONPATH=/opt/tests
"""


def run(*command: str, folder: Path = ROOT, timeout: float = BUILD_TIMEOUT) -> str:
    """Run a command that must succeed, and return what it printed."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=timeout, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}{done.stderr}"[-6000:]
    return done.stdout


@functools.cache
def bring_up() -> None:
    """Make sure that an engine runs; skip the test if the variable is not set, and fail if its command fails."""
    command = os.environ.get(UP)
    if not command:
        pytest.skip(f"no Docker Engine: set {UP}")
    run("bash", "-c", command, timeout=UP_TIMEOUT)


@functools.cache
def engine_image() -> str:
    """Build the image of this checkout, as documented; return its name."""
    bring_up()
    run("docker", "build", "--quiet", "-f", "docker/engine.Dockerfile", "-t", ENGINE_IMAGE, ".")
    return ENGINE_IMAGE


@functools.cache
def image_for_tests() -> str:
    """Build the image with the test entry points and a hostile plug-in; return its name."""
    base = engine_image()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "Dockerfile").write_text(TEST_FILES.format(image=base))
        run("cp", "-r", str(ROOT / "tests" / "support" / "hostile_plugin"), str(folder))
        run("mkdir", "-p", str(folder / "tests"))
        run("cp", "-r", str(ROOT / "tests" / "support"), str(folder / "tests"))
        run("docker", "build", "--quiet", "-t", TEST_IMAGE, str(folder))
    return TEST_IMAGE


def containers(instance: str) -> list[str]:
    """Return the ids of the containers of a cloud, running or not."""
    listed = run("docker", "ps", "--all", "--quiet", "--no-trunc", "--filter", f"label=ppaas.instance={instance}")
    return listed.split()
