"""Run as a program: lists the planners that are installed, as JSON on standard output.

Its argument is the plug-ins of others that may be loaded, a JSON array of ``group:name``; ``null`` allows all.
"""

import sys

import msgspec

from ppaas.plugins import permit_only


def main(allowed: str) -> int:
    """List the planners; return the exit status."""
    names = msgspec.json.decode(allowed, type=list[str] | None)
    if names is not None:
        permit_only(names)
    from ppaas.planners.catalogue import catalogue  # noqa: PLC0415 - whatever it loads must be permitted

    sys.stdout.buffer.write(msgspec.json.encode(catalogue()))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
