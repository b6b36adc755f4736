"""Runs ``ppaas bench plans`` on a real Cassandra: ``python -m benchmarks.stores.cassandra_plans [ARGUMENT ...]``.

The arguments are those of ``ppaas bench plans``. The store is a Cassandra node of ordinary size, started for the bench
and stopped after it.
"""

import sys
import tempfile
from pathlib import Path

from robots.cli.main import main as ppaas
from tests.servers.cassandra_server import ORDINARY, CassandraServer


def main(arguments: list[str]) -> int:
    """Start a node, run the bench, and stop the node; return the status of the command."""
    with tempfile.TemporaryDirectory(prefix="ppaas-cassandra-") as folder:
        server = CassandraServer(Path(folder), ORDINARY)
        try:
            server.start()
            return ppaas(["bench", "plans", "--store", server.url("bench"), *arguments])
        finally:
            server.stop()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
