"""The lowest versions that pyproject.toml allows, on the oldest Python."""

import pytest

from tests.versions import environments
from tests.versions.suite import LongSuite

pytestmark = pytest.mark.versions


class TestLowest(LongSuite):
    """Each package in its lowest version."""

    VERSIONS = environments.LOWEST
