"""Which tests run one after the other where several processes share them (pytest-xdist).

Robots drive in real time, so most of such a test is waiting: the shares below and all other files run side by side.
Within a share a cloud is shared or the machine is strained, so its tests stay together; they go first, since they take
longest.
The browser stays with those that make networks: it drops what it was fetching whenever the computer gets another one.
"""

from functools import cache
from pathlib import PurePath

SHARES: dict[str, tuple[str, ...]] = {  # the first that a file is part of
    "clouds": (
        "tests/e2e/test_two_machines.py",
        "tests/e2e/test_local_nodes.py",
        "tests/e2e/test_come_and_go.py",
        "tests/unit/robots/cli/commands/test_demo.py",
        "tests/unit/robots/cli/commands/test_simulate.py",
    ),
    "documents": ("tests/docs",),
    "restarts": (
        "tests/faults/test_master_restart.py",
        "tests/faults/test_partition.py",
        "tests/e2e/test_dashboard.py",
    ),
    "bridges": (
        "tests/faults/test_ros2_bridge.py",
        "tests/faults/test_recording.py",
        "tests/faults/test_presence.py",
        "tests/faults/test_machine_endpoints.py",
        "tests/faults/test_endpoints.py",
        "tests/faults/test_standby.py",
    ),
    "maps": (
        "tests/e2e/test_zones.py",
        "tests/e2e/test_joint_map.py",
        "tests/e2e/test_scans_alone.py",
        "tests/e2e/test_dashboard_maps.py",
        "tests/e2e/test_dashboard_pages.py",
        "tests/e2e/test_dashboard_axe.py",
        "tests/e2e/test_dashboard_buildings.py",
        "tests/e2e/test_dashboard_fleet.py",
        "tests/e2e/test_dashboard_layout.py",
        "tests/e2e/test_dashboard_traffic.py",
        "tests/e2e/test_dashboard_zones.py",
        "tests/e2e/test_docs_site.py",
    ),
    "deaths": ("tests/faults", "tests/stress", "tests/unit/endpoints/test_server.py"),
    "drives": ("tests/e2e",),
}

LONG = (
    "tests/unit/endpoints/test_app_schemathesis.py",
    "tests/unit/ppaas/planners/field/test_tile_field.py",
    "tests/unit/ppaas/planners/field/test_tile_field_threads.py",
    "tests/unit/benchmarks/engine/test_suite.py",
    "tests/unit/engine/runtimes/memory_tuning/test_cached_kernels.py",
)
"""Files that begin before the rest: whatever is long and last is waited for by all processes but one."""


@cache
def share_of(file: PurePath) -> str:
    """Return the share of a test file, given below the root: one of ``SHARES``, else a share of its own."""
    name = file.as_posix()
    for share, places in SHARES.items():
        if any(name == place or name.startswith(f"{place}/") for place in places):
            return share
    return name


@cache
def place_in_line(file: PurePath) -> int:
    """Return where a file's share stands in line: the longest first."""
    line = [*SHARES, *LONG]
    share = share_of(file)
    return line.index(share) if share in line else len(line)
