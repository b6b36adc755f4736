"""What must work with each set of versions: imports and a drive; with some, also tests of what depends on packages."""

from typing import ClassVar

import pytest

from tests.versions.environments import Missing, Versions, make

SUBJECTS = (
    "tests/contracts/test_plan_stores.py",
    "tests/contracts/test_map_stores.py",
    "tests/unit/endpoints/http/test_tls.py",
    "tests/unit/endpoints/http/test_websocket_protocol.py",
    "tests/unit/ppaas/recording/test_mcap_files.py",
    "tests/unit/ppaas/test_distribution.py",
    "tests/unit/ppaas/wire/binary",
    "tests/unit/ppaas/wire/ros",
    "tests/unit/robots/client/test_robot_client.py",
)
"""Tests that touch each package whose interface or internals have changed: stores, HTTP and WebSockets, codecs."""

IMPORTS = """
import importlib, pkgutil, sys, warnings
warnings.filterwarnings("error", category=DeprecationWarning, module=rf"({'|'.join(sys.argv[1:])})[.]")
for top in sys.argv[1:]:
    for module in pkgutil.walk_packages(importlib.import_module(top).__path__, f"{top}."):
        # Some must be imported before numba, one runs kernels, and one is for MicroPython.
        if not module.name.endswith(
            ("__main__", "warm_up.freeze", "warm_up.preload", "warm_up.run", "micropython.ppaas_robot")
        ):
            importlib.import_module(module.name)
"""
"""Imports all modules. Kernels are not compiled, which would take minutes; the drive compiles those that it calls."""


class Suite:
    """Tests of one set of versions; a subclass names it."""

    VERSIONS: ClassVar[Versions]

    @pytest.fixture(scope="class", autouse=True)
    @classmethod
    def _environment(cls) -> None:
        try:
            make(cls.VERSIONS)
        except Missing as missing:
            pytest.skip(str(missing))

    def test_every_module_is_imported(self) -> None:
        packages = ("ppaas", "storage", "engine", "endpoints", "robots")
        done = self.VERSIONS.run("-c", IMPORTS, *packages, NUMBA_DISABLE_JIT="1", timeout=1500)
        assert done.returncode == 0, done.stderr

    def test_a_robot_drives_to_its_goal(self) -> None:
        drive = ("demo", "--headless", "--robots", "1", "--goals", "1")
        done = self.VERSIONS.run("-m", "robots.cli", *drive, timeout=1500)
        assert done.returncode == 0, done.stdout + done.stderr
        assert "1 of 1 goals reached" in done.stdout


class LongSuite(Suite):
    """The same, and the tests of what depends most on packages."""

    def test_what_depends_on_packages_passes_its_tests(self) -> None:
        done = self.VERSIONS.run("-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *SUBJECTS, timeout=1500)
        assert done.returncode == 0, done.stdout[-5000:]
