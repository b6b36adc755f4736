"""A real Cassandra node on 127.0.0.1, with authentication, small and quick to start."""

import logging
import subprocess
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml
from cassandra.auth import PlainTextAuthProvider
from cassandra.cluster import EXEC_PROFILE_DEFAULT, Cluster, ExecutionProfile, Session
from cassandra.policies import RoundRobinPolicy

from benchmarks.harness.free_ports import free_ports
from tests.servers.jars import jars_of, java, keytool
from tests.servers.java_server import JavaServer
from tests.support.sources import ROOT

logging.getLogger("cassandra").setLevel(logging.CRITICAL)  # it logs many errors while a server starts

HERE = ROOT / "docker" / "cassandra"
PASSWORD = "cassandra"  # of the default user of a new server, also called cassandra

JVM = [
    *("-XX:-UsePerfData", "-XX:+ExitOnOutOfMemoryError", "-Djava.net.preferIPv4Stack=true"),
    *(f"--add-opens={name}=ALL-UNNAMED" for name in ("java.base/sun.nio.ch", "java.base/jdk.internal.ref")),
    "--add-opens=java.base/java.io=ALL-UNNAMED",
]
SETTINGS = {
    "cassandra-foreground": "yes",
    "cassandra.skip_wait_for_gossip_to_settle": "0",
    "cassandra.ring_delay_ms": "1000",
    "cassandra.shutdown_announce_in_ms": "0",
    "cassandra.superuser_setup_delay_ms": "0",
    "cassandra.auth_bcrypt_gensalt_log2_rounds": "4",
}


@dataclass(frozen=True)
class NodeSize:
    """Size of a node.

    Parameters
    ----------
    jvm : tuple of str
        Options of the Java virtual machine.
    settings : dict
        Settings in addition to those of every node; others have Cassandra's defaults.
    """

    jvm: tuple[str, ...]
    settings: dict[str, Any] = field(default_factory=dict)


SMALL = NodeSize(
    ("-Xms64m", "-Xmx768m", "-Xss512k", "-XX:MaxDirectMemorySize=256m", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1"),
    {
        **{f"{what}_validity": "0ms" for what in ("roles", "permissions", "credentials")},
        "commitlog_segment_size": "8MiB",
        "commitlog_total_space": "128MiB",
        "concurrent_reads": 8,
        "concurrent_writes": 8,
        "concurrent_counter_writes": 4,
        "concurrent_compactors": 1,
        "memtable_heap_space": "64MiB",
        "memtable_offheap_space": "64MiB",
        "file_cache_size": "32MiB",
        "key_cache_size": "4MiB",
        "counter_cache_size": "2MiB",
        "networking_cache_size": "32MiB",
        "native_transport_max_threads": 32,
    },
)
"""A node that leaves memory for tests and starts quickly; it does not cache roles and permissions."""

ORDINARY = NodeSize(("-Xms2g", "-Xmx2g", "-XX:+UseG1GC"))
"""A node of ordinary size."""


class CassandraServer(JavaServer):
    """Cassandra with its data in a folder.

    Acknowledged writes are on the disk (``commitlog_sync: batch``). With Cassandra's default, the last ten seconds may
    be lost with the process.

    Parameters
    ----------
    folder : Path
        Folder of its data and log.
    size : NodeSize
    """

    def __init__(self, folder: Path, size: NodeSize = SMALL) -> None:
        self.port, storage_port = free_ports(2)
        folder.mkdir(parents=True, exist_ok=True)
        config = folder / "cassandra.yaml"
        self.certificate = folder / "node.pem"
        keys = make_certificate(folder / "node.p12", self.certificate)
        settings = configuration(self.port, storage_port) | size.settings | {"client_encryption_options": keys}
        config.write_text(yaml.safe_dump(settings))
        places = {
            "logback.configurationFile": f"file:{HERE / 'logback.xml'}",
            "cassandra.config": f"file:{config}",
            "cassandra.storagedir": str(folder),
            "cassandra.logdir": str(folder),
            "java.io.tmpdir": str(folder),
            "jna.tmpdir": str(folder),
        }
        properties = [f"-D{name}={value}" for name, value in (SETTINGS | places).items()]
        jars = f"{jars_of(HERE / 'pom.xml')}/*"
        command = [java(), *size.jvm, *JVM, *properties, "-cp", jars, "org.apache.cassandra.service.CassandraDaemon"]
        super().__init__(command, folder, "cassandra", self._answers)
        self._session: Session | None = None

    def url(self, keyspace: str, query: str = "") -> str:
        """Return the URL of a store in a keyspace."""
        return f"cassandra://cassandra:{PASSWORD}@127.0.0.1:{self.port}/{keyspace}{query}"

    def empty(self, keyspace: str, *, all_tables: bool = False) -> None:
        """Truncate the non-empty tables of a keyspace, or all: a table with deleted rows alone appears empty."""
        session = self._connected()
        listed = session.execute("SELECT table_name FROM system_schema.tables WHERE keyspace_name = %s", [keyspace])
        tables = [f"{keyspace}.{row.table_name}" for row in listed if row.table_name != "schema_version"]
        if not all_tables:
            queries = [session.execute_async(f"SELECT * FROM {name} LIMIT 1") for name in tables]
            tables = [name for name, query in zip(tables, queries, strict=True) if query.result().one()]
        for truncation in [session.execute_async(f"TRUNCATE {name}") for name in tables]:
            truncation.result()

    def execute(self, keyspace: str, statement: str) -> None:
        """Execute a statement that no store executes."""
        with self._cluster() as cluster:
            cluster.connect(keyspace).execute(statement)

    def stop(self) -> None:
        """Stop the server cleanly, if it runs."""
        self._disconnect()
        super().stop()

    def kill(self) -> None:
        """Kill the server with SIGKILL, so that it writes nothing more."""
        self._disconnect()
        super().kill()

    def _connected(self) -> Session:
        """Return a session that stays open until the server ends, since to connect takes longer than to truncate."""
        if self._session is None:
            self._session = self._cluster().connect()
        return self._session

    def _disconnect(self) -> None:
        if self._session is not None:
            self._session.cluster.shutdown()
            self._session = None

    def _answers(self) -> bool:
        with self._cluster() as cluster:
            return cluster.connect().execute("SELECT release_version FROM system.local").one() is not None

    def _cluster(self) -> Cluster:
        login = PlainTextAuthProvider("cassandra", PASSWORD)
        profile = ExecutionProfile(load_balancing_policy=RoundRobinPolicy())
        return Cluster(
            ["127.0.0.1"],
            port=self.port,
            protocol_version=5,
            auth_provider=login,
            execution_profiles={EXEC_PROFILE_DEFAULT: profile},
            connect_timeout=2,
            schema_metadata_enabled=False,
            token_metadata_enabled=False,
        )


def make_certificate(keys: Path, certificate: Path) -> dict[str, Any]:
    """Create a key and a certificate for 127.0.0.1; return the settings for optional TLS."""
    store = ["-keystore", str(keys), "-storepass", PASSWORD, "-storetype", "PKCS12", "-alias", "node"]
    made = ["-genkeypair", "-keyalg", "EC", "-dname", "CN=ppaas-test", "-ext", "san=ip:127.0.0.1", "-ext", "bc=ca:true"]
    for command in ([*made, *store], ["-exportcert", "-rfc", *store, "-file", str(certificate)]):
        subprocess.run([keytool(), *command], check=True, capture_output=True)
    return {"enabled": True, "optional": True, "keystore": str(keys), "keystore_password": PASSWORD}


def configuration(port: int, storage_port: int) -> dict[str, Any]:
    """Return the settings of the server."""
    seeds = {"class_name": "org.apache.cassandra.locator.SimpleSeedProvider"}
    return {
        "cluster_name": "ppaas-test",
        "num_tokens": 1,
        "initial_token": str(-(2**63)),
        "partitioner": "org.apache.cassandra.dht.Murmur3Partitioner",
        "endpoint_snitch": "SimpleSnitch",
        "listen_address": "127.0.0.1",
        "rpc_address": "127.0.0.1",
        "storage_port": storage_port,
        "start_native_transport": True,
        "native_transport_port": port,
        "seed_provider": [seeds | {"parameters": [{"seeds": f"127.0.0.1:{storage_port}"}]}],
        "authenticator": "PasswordAuthenticator",
        "authorizer": "CassandraAuthorizer",
        "role_manager": "CassandraRoleManager",
        "commitlog_sync": "batch",
        "auto_snapshot": False,
    }
