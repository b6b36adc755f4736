"""Measure plans in a real Cassandra of ordinary size: ``python -m benchmarks.stores.cassandra_plans [ARGUMENT ...]``.

The arguments are those of ``ppaas bench plans``, whose store is a node that is started for it and ended after it.
"""

import sys
import tempfile
from pathlib import Path

from robots.cli.main import main as ppaas
from tests.servers.cassandra_server import ORDINARY, CassandraServer


def main(arguments: list[str]) -> int:
    """Start a node, measure, and end it; return the status of the command."""
    with tempfile.TemporaryDirectory(prefix="ppaas-cassandra-") as folder:
        server = CassandraServer(Path(folder), ORDINARY)
        try:
            server.start()
            return ppaas(["bench", "plans", "--store", server.url("bench"), *arguments])
        finally:
            server.stop()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
