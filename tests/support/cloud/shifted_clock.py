"""Environment of a process whose clock is an hour ahead, as on a host without NTP; its monotonic clocks are right.

``libfaketime`` (Debian's package of that name) sets the clock of a process and its children, also for TLS.
"""

from pathlib import Path

LIBRARIES = ("/usr/lib", "/usr/lib64", "/usr/local/lib")
NAME = "libfaketimeMT.so.1"

SETTINGS = {"FAKETIME": "+1h", "FAKETIME_DONT_FAKE_MONOTONIC": "1", "NO_FAKE_STAT": "1"}
"""Neither monotonic clocks nor the times of files, by which compiled kernels are found, are set."""


def an_hour_ahead() -> dict[str, str]:
    """Return the environment; none if the library is not installed, so that the clock is right."""
    found = next((path for folder in LIBRARIES for path in sorted(Path(folder).glob(f"**/faketime/{NAME}"))), None)
    return {} if found is None else {"LD_PRELOAD": str(found), **SETTINGS}
