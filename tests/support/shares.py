"""Which tests run one after the other where several processes share them (pytest-xdist).

Robots drive in real time, so most of such a test is waiting: those that kill, those that bring machines and clouds of
their own, those that share one cloud, and all others run side by side. Within the first three a cloud is shared or the
machine is strained, so they stay together; they go first, since they take longest.
"""

from pathlib import PurePath

SHARES: dict[str, tuple[str, ...]] = {  # the first that a file is part of
    "deaths": ("tests/faults", "tests/joints", "tests/endpoints/test_server.py"),
    "clouds": (
        "tests/journeys/test_two_machines.py",
        "tests/journeys/test_local_nodes.py",
        "tests/journeys/test_come_and_go.py",
        "tests/docs",
        "tests/robots/test_demo.py",
        "tests/robots/test_simulate.py",
    ),
    "drives": ("tests/journeys",),
}


def share_of(file: PurePath) -> str:
    """Return the share of a test file, given below the root: one of ``SHARES``, else a share of its own."""
    for share, places in SHARES.items():
        if any(file.is_relative_to(place) for place in places):
            return share
    return file.as_posix()


def place_in_line(file: PurePath) -> int:
    """Return where a file's share stands in line: the longest first."""
    shares = list(SHARES)
    share = share_of(file)
    return shares.index(share) if share in shares else len(shares)
