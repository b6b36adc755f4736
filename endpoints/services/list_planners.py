"""Program that lists the installed planners as JSON on standard output.

Its argument is a JSON array of the permitted third-party plug-ins, as ``group:name``; ``null`` permits all.
"""

import sys

import msgspec

from ppaas.decoding import from_json
from ppaas.plugins import permit_only


def main(allowed: str) -> int:
    """List the planners; return the exit status."""
    names = from_json(allowed, list[str] | None)
    if names is not None:
        permit_only(names)
    from ppaas.planners.catalogue import catalogue  # noqa: PLC0415 - loads plug-ins, after the permissions are set

    sys.stdout.buffer.write(msgspec.json.encode(catalogue()))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
