"""A server of S3, S3Proxy, that keeps its objects in a folder."""

import socket
from pathlib import Path

from benchmarks.harness.free_ports import free_ports
from tests.servers.jars import S3, jars_of, java
from tests.servers.java_server import JavaServer

BUCKET = "fleet"
USER, SECRET = "operator", "secret-of-operator"


class S3Server:
    """S3 with one bucket.

    Parameters
    ----------
    folder : Path
        For its data, its settings and its log.
    """

    def __init__(self, folder: Path) -> None:
        [self.port] = free_ports(1)
        (folder / "data" / BUCKET).mkdir(parents=True)
        settings = {
            "s3proxy.endpoint": f"http://127.0.0.1:{self.port}",
            "s3proxy.authorization": "aws-v2-or-v4",
            "s3proxy.identity": USER,
            "s3proxy.credential": SECRET,
            "jclouds.provider": "filesystem-nio2",
            "jclouds.identity": USER,
            "jclouds.credential": SECRET,
            "jclouds.filesystem.basedir": str(folder / "data"),
        }
        file = folder / "s3proxy.conf"
        file.write_text("".join(f"{name}={value}\n" for name, value in settings.items()))
        jvm = [java(), "-Xmx128m", "-XX:+UseSerialGC", "-XX:TieredStopAtLevel=1", "-cp", f"{jars_of(S3)}/*"]
        self._server = JavaServer(
            [*jvm, "org.gaul.s3proxy.Main", "--properties", str(file)], folder, "s3", self._listens
        )

    def start(self) -> None:
        """Start it and wait until it answers."""
        self._server.start()

    def stop(self) -> None:
        """Stop it."""
        self._server.stop()

    def environment(self) -> dict[str, str]:
        """Return the environment variables with which clients of S3 use it."""
        return {
            "AWS_ACCESS_KEY_ID": USER,
            "AWS_SECRET_ACCESS_KEY": SECRET,
            "AWS_ENDPOINT": f"http://127.0.0.1:{self.port}",
            "AWS_ALLOW_HTTP": "true",
            "AWS_REGION": "us-east-1",
        }

    def _listens(self) -> bool:
        with socket.create_connection(("127.0.0.1", self.port), timeout=1.0):
            return True
