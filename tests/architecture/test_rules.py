"""Every rule finds violations and accepts allowed code."""

import pytest

from tests.support import rules
from tests.support.sources import ALL_PACKAGES, Source, sources

VIOLATIONS = [
    (rules.io_imports, "import asyncio"),
    (rules.io_imports, "import urllib.request"),
    (rules.io_imports, "def f():\n    from concurrent.futures import ThreadPoolExecutor"),
    (rules.io_imports, "from time import sleep"),
    (rules.private_imports, "from ray._private.state import available_resources_per_node"),
    (rules.private_imports, "def f():\n    from numba.core import _helperlib"),
    (rules.private_imports, "import cyclonedds._clayer"),
    (rules.io_calls, "open('map.yaml')"),
    (rules.io_calls, "print('here')"),
    (rules.io_calls, "Path('map.yaml').write_text('')"),
    (rules.io_calls, "np.load('map.npy')"),
    (rules.long_file, "x = 0\n" * 401),
    (rules.long_functions, "def f():\n" + "    x = 0\n" * 40),
    (rules.long_functions, "class A:\n    async def f(self):\n" + "        x = 0\n" * 40),
    (rules.swallowed_errors, "try:\n    f()\nexcept:\n    pass"),
    (rules.swallowed_errors, "try:\n    f()\nexcept Exception as error:\n    ..."),
    (rules.swallowed_errors, "try:\n    f()\nexcept (OSError, Exception):\n    pass"),
    (rules.swallowed_errors, "with contextlib.suppress(Exception):\n    f()"),
    (rules.working_assertions, "assert queue.popleft() == cell"),
]

ALLOWED = [
    (rules.io_imports, "from ppaas.clock import monotonic\nimport numpy\nfrom . import time"),
    (
        rules.private_imports,
        "from __future__ import annotations\nfrom ppaas.grid import _cells\nfrom . import _a",
    ),
    (rules.private_imports, "import ray.util\nfrom ray import __version__, nodes"),
    (rules.io_calls, "grid.load(); plan.save(); logger.info('x')"),
    (rules.long_file, "x = 0\n" * 400),
    (rules.long_functions, "def f():\n    '''Say\n" + "    much.\n" * 50 + "    '''\n" + "    x = 0\n" * 39),
    (rules.swallowed_errors, "try:\n    f()\nexcept TimeoutError:\n    pass"),
    (rules.swallowed_errors, "try:\n    f()\nexcept Exception:\n    logger.exception('f')"),
    (rules.swallowed_errors, "with contextlib.suppress(ConnectionError):\n    f()"),
    (rules.working_assertions, "assert queue.get() == cell"),
]


@pytest.mark.parametrize(("rule", "text"), VIOLATIONS)
def test_rule_finds_violations(rule, text):
    assert rule(Source.of("ppaas/maps/grid.py", text))


@pytest.mark.parametrize(("rule", "text"), ALLOWED)
def test_rule_accepts_allowed_code(rule, text):
    assert rule(Source.of("ppaas/maps/grid.py", text)) == []


def test_a_listed_state_machine_may_be_twice_as_long():
    [centre, *_] = sorted(rules.CENTRES)
    assert rules.long_file(Source.of(centre, "x = 0\n" * 800)) == []
    assert rules.long_file(Source.of(centre, "x = 0\n" * 801))


def test_every_listed_state_machine_is_long():
    files = {source.path: len(source.text.splitlines()) for source in sources(*ALL_PACKAGES)}
    assert [path for path in sorted(rules.CENTRES) if files.get(path, 0) <= rules.MAX_FILE_LINES] == []


def test_only_the_clock_imports_time():
    assert rules.io_imports(Source.of("ppaas/clock.py", "import time")) == []


def test_only_batch_planning_may_start_threads():
    text = "from concurrent.futures import ThreadPoolExecutor"
    assert rules.io_imports(Source.of("ppaas/planners/batch/workers.py", text)) == []
    assert rules.io_imports(Source.of("ppaas/planners/batch/workers.py", "import threading"))


def test_types_are_described_by_one_module_alone():
    text = "import msgspec\nmsgspec.convert(a, B)\nmsgspec.json.decode(a, type=B)\nmsgspec.msgpack.decode(a)\n"
    assert len(rules.typed_decodes(Source.of("ppaas/plugins.py", text))) == 2
    assert rules.typed_decodes(Source.of("ppaas/decoding.py", text)) == []


def test_kernel_functions_may_be_twice_as_long():
    text = "def f():\n" + "    x = 0\n" * 70
    assert rules.long_functions(Source.of("ppaas/planners/kernels/grid.py", text)) == []
    assert rules.long_functions(Source.of("ppaas/planners/kernels/grid.py", text + "    x = 0\n" * 10))
