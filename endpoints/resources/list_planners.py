"""Program that lists the installed planners as JSON on standard output.

Its argument is a JSON array of the permitted third-party plug-ins, as ``group:name``; ``null`` permits all. Planners
that cannot be loaded are left out, and named on standard error; the exit status is then ``INCOMPLETE``.
"""

import sys

import msgspec

from ppaas.decoding import from_json
from ppaas.distribution import BrokenPlugin
from ppaas.plugins import permit_only

INCOMPLETE = 3
"""Exit status if a planner was left out."""


def main(allowed: str) -> int:
    """List the planners; return the exit status."""
    names = from_json(allowed, list[str] | None)
    if names is not None:
        permit_only(names)
    from ppaas.planners.catalogue import catalogue  # noqa: PLC0415 - loads plug-ins, after the permissions are set

    broken: list[BrokenPlugin] = []
    sys.stdout.buffer.write(msgspec.json.encode(catalogue(broken.append)))
    sys.stderr.writelines(f"{error}\n" for error in broken)
    return INCOMPLETE if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
