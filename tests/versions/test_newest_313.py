"""The newest versions of all packages, on Python 3.13."""

import pytest

from tests.versions import environments
from tests.versions.suite import LongSuite

pytestmark = pytest.mark.versions


class TestNewest(LongSuite):
    """Each package in its newest version, as ``pip install`` takes it."""

    VERSIONS = environments.NEWEST_313
