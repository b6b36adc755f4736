"""The newest versions of all packages, on Python 3.12."""

import pytest

from tests.versions import environments
from tests.versions.suite import Suite

pytestmark = pytest.mark.versions


class TestNewest(Suite):
    """Each package in its newest version, as ``pip install`` takes it."""

    VERSIONS = environments.NEWEST_312
