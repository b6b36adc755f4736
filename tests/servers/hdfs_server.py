"""A real HDFS of one NameNode and one DataNode on 127.0.0.1."""

import getpass
import shutil
import subprocess
from pathlib import Path
from xml.sax.saxutils import escape

import requests
from hdfs import InsecureClient

from benchmarks.harness.free_ports import free_ports
from tests.servers.jars import HDFS, jars_of, java
from tests.servers.java_server import JavaServer

PACKAGE = "org.apache.hadoop.hdfs.server"
JVM = [
    *("-Xmx128m", "-Xss256k", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1", "-XX:ReservedCodeCacheSize=32m"),
    *("-XX:-UsePerfData", "-Djava.net.preferIPv4Stack=true"),
    "--add-opens=java.base/java.lang=ALL-UNNAMED",  # without it, WebHDFS answers every request with 500
]


class HdfsServer:
    """HDFS with its data in a folder.

    Parameters
    ----------
    folder : Path
        For its data, its settings and its logs.
    version : str, optional
        Version of Hadoop. Default: that of the image.
    """

    def __init__(self, folder: Path, version: str | None = None) -> None:
        self._folder = folder
        jars = jars_of(HDFS) if version is None else jars_of(HDFS, hadoop=version)
        rpc, self.port, *of_datanode = free_ports(6)
        folder.mkdir(parents=True, exist_ok=True)
        settings = _settings(folder, rpc, self.port, of_datanode)
        (folder / "hdfs-site.xml").write_text(_xml(settings))
        (folder / "core-site.xml").write_text(_xml({"fs.defaultFS": f"hdfs://127.0.0.1:{rpc}"}))
        shutil.copy(HDFS.with_name("log4j.properties"), folder)
        for daemon in ("hdfs", "datanode"):
            (folder / "webapps" / daemon).mkdir(
                parents=True
            )  # the daemons require these folders, but serve nothing from them
        self._java = [java(), *JVM, f"-Djava.io.tmpdir={folder}", "-cp", f"{folder}:{jars}/*"]
        name_node = [*self._java, f"{PACKAGE}.namenode.NameNode"]
        data_node = [*self._java, f"{PACKAGE}.datanode.DataNode"]
        self.name_node = JavaServer(name_node, folder, "namenode", self._lists)
        self.data_node = JavaServer(data_node, folder, "datanode", self._writes)

    def start(self) -> None:
        """Start both daemons if they do not run, with an empty file system at first, and wait until it is writable."""
        if not (self._folder / "name").exists():
            command = [*self._java, f"{PACKAGE}.namenode.NameNode", "-format", "-nonInteractive"]
            subprocess.run(command, cwd=self._folder, check=True, capture_output=True)
        for daemon in (self.name_node, self.data_node):
            if not daemon.runs:
                daemon.launch()
        self.name_node.wait_ready()
        self.data_node.wait_ready()

    def stop(self) -> None:
        """Stop both daemons."""
        self.data_node.stop()
        self.name_node.stop()

    def kill(self) -> None:
        """Kill both daemons with SIGKILL."""
        self.data_node.kill()
        self.name_node.kill()

    def url(self, path: str) -> str:
        """Return the URL of a store in a folder."""
        return f"hdfs://127.0.0.1:{self.port}/{path}?user={getpass.getuser()}"

    def version(self) -> str:
        """Return the version of Hadoop that runs."""
        query = {"qry": "Hadoop:service=NameNode,name=NameNodeInfo"}
        answer = requests.get(f"http://127.0.0.1:{self.port}/jmx", params=query, timeout=20).json()
        return str(answer["beans"][0]["SoftwareVersion"])

    def client(self) -> InsecureClient:
        """Return a client with all permissions: the user that started HDFS is its superuser."""
        return InsecureClient(f"http://127.0.0.1:{self.port}", user=getpass.getuser(), timeout=(2, 10))

    def _lists(self) -> bool:
        return self.client().list("/") is not None

    def _writes(self) -> bool:
        self.client().write("/.ready", data=b"ok", overwrite=True)
        with self.client().read("/.ready") as file:
            return bool(file.read() == b"ok")


def _settings(folder: Path, rpc: int, http: int, of_datanode: list[int]) -> dict[str, object]:
    address, web, ipc, proxy = of_datanode
    return {
        "dfs.namenode.name.dir": f"file://{folder}/name",
        "dfs.datanode.data.dir": f"file://{folder}/data",
        "dfs.replication": 1,
        "dfs.namenode.rpc-address": f"127.0.0.1:{rpc}",
        "dfs.namenode.http-address": f"127.0.0.1:{http}",
        "dfs.datanode.hostname": "127.0.0.1",
        "dfs.datanode.address": f"127.0.0.1:{address}",
        "dfs.datanode.http.address": f"127.0.0.1:{web}",
        "dfs.datanode.ipc.address": f"127.0.0.1:{ipc}",
        "dfs.datanode.http.internal-proxy.port": proxy,
        # Safe mode ends when the blocks are reported, and a dead DataNode is detected within 12 s.
        "dfs.namenode.safemode.extension": 0,
        "dfs.heartbeat.interval": 1,
        "dfs.namenode.heartbeat.recheck-interval": 1000,
        # The client that closes a file polls whether it is complete: first after 20 ms, not 400.
        "dfs.client.block.write.locateFollowingBlock.initial.delay.ms": 20,
        "dfs.client.block.write.locateFollowingBlock.retries": 9,
    }


def _xml(settings: dict[str, object]) -> str:
    one = "<property><name>{}</name><value>{}</value></property>"
    entries = (one.format(name, escape(str(value))) for name, value in settings.items())
    return f"<configuration>{''.join(entries)}</configuration>"
