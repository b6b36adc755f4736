"""The newest versions of all packages, on Python 3.12, with plug-ins of strangers."""

import pytest

from tests.docs import test_plugin_examples as plugins
from tests.versions import environments
from tests.versions.suite import Suite

pytestmark = pytest.mark.versions


class TestNewest(Suite):
    """Each package in its newest version, as ``pip install`` takes it."""

    VERSIONS = environments.NEWEST_312

    def test_plugins_installed_by_pip_drive_a_robot(self) -> None:
        environments.add(self.VERSIONS, *(plugins.EXAMPLES / name for name in plugins.NAMES))
        command = ("-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", plugins.__file__)
        done = self.VERSIONS.run(*command, timeout=1500)
        assert done.returncode == 0, done.stdout[-5000:]
        assert "skipped" not in done.stdout
