"""Keycloak, an identity provider, with one realm of people and clients, in memory."""

import contextlib
import os
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import httpx

from benchmarks.harness.free_ports import free_ports
from tests.servers.jars import KEYCLOAK, jars_of, java
from tests.servers.java_server import JavaServer

REALM = Path(__file__).with_name("keycloak_realm.json")
ADMIN, PASSWORD = "root", "password of root"
OF_BUILD = ("--db=dev-mem", "--cache=local")
BUILD_TIMEOUT = 300.0
HEAP = "-Xms64m -Xmx384m -XX:TieredStopAtLevel=1"


class KeycloakServer:
    """Keycloak that sends people back to one cloud.

    Parameters
    ----------
    folder : Path
        For its files and its log.
    """

    def __init__(self, folder: Path) -> None:
        java()
        [archive] = jars_of(KEYCLOAK).glob("*.zip")
        self.port, self.cloud_port = free_ports(2)
        self.cloud_url = f"http://127.0.0.1:{self.cloud_port}"
        self.issuer = f"http://127.0.0.1:{self.port}/realms/lab"
        home = folder / "keycloak"
        shutil.copytree(_built(archive), home, copy_function=os.link)
        (home / "data" / "import").mkdir(parents=True)
        realm = REALM.read_text().replace("@CLOUD@", self.cloud_url)
        (home / "data" / "import" / "lab.json").write_text(realm)
        variables = {"KC_BOOTSTRAP_ADMIN_USERNAME": ADMIN, "KC_BOOTSTRAP_ADMIN_PASSWORD": PASSWORD}
        command = [
            "env", f"JAVA_OPTS_KC_HEAP={HEAP}", *(f"{name}={value}" for name, value in variables.items()),
            str(home / "bin" / "kc.sh"), "start", "--optimized", "--import-realm", "--http-enabled=true",
            "--hostname-strict=false", "--http-host=127.0.0.1", f"--http-port={self.port}",
        ]  # fmt: skip
        self._server = JavaServer(command, folder, "keycloak", self._serves)

    def start(self) -> None:
        """Start it and wait until it has the realm."""
        self._server.start()

    def stop(self) -> None:
        """Stop it."""
        self._server.stop()

    def access_token(self) -> str:
        """Return an access token of the program ``fleet`` for the cloud (client credentials)."""
        return self._token(
            self.issuer, grant_type="client_credentials", client_id="fleet", client_secret="secret of fleet"
        )

    def rotate_keys(self) -> None:
        """Sign with a new key from now on."""
        key = {
            "name": "newer", "providerId": "rsa-generated", "providerType": "org.keycloak.keys.KeyProvider",
            "config": {"priority": ["200"], "algorithm": ["RS256"], "keySize": ["2048"]},
        }  # fmt: skip
        with self._administration() as realm:
            realm.post("/components", json=key).raise_for_status()

    def log_out(self, user: str) -> None:
        """End the sessions of a person, as an administrator of the provider does."""
        with self._administration() as realm:
            [found] = realm.get("/users", params={"username": user, "exact": True}).json()
            realm.post(f"/users/{found['id']}/logout").raise_for_status()

    def _administration(self) -> httpx.Client:
        """Return a client of the realm for administrators."""
        host = f"http://127.0.0.1:{self.port}"
        token = self._token(
            f"{host}/realms/master", grant_type="password", client_id="admin-cli", username=ADMIN, password=PASSWORD
        )
        header = {"Authorization": f"Bearer {token}"}
        return httpx.Client(base_url=f"{host}/admin/realms/lab", headers=header, timeout=30.0)

    def _token(self, issuer: str, **form: str) -> str:
        answer = httpx.post(f"{issuer}/protocol/openid-connect/token", data=form, timeout=30.0).raise_for_status()
        found: dict[str, Any] = answer.json()
        return str(found["access_token"])

    def _serves(self) -> bool:
        return httpx.get(f"{self.issuer}/.well-known/openid-configuration", timeout=5.0).status_code == 200


def _built(archive: Path) -> Path:
    """Return the folder of Keycloak with its settings of the build compiled in, which halves each start."""
    home = archive.parent / "built"
    if not home.is_dir():
        with tempfile.TemporaryDirectory(prefix=".building-", dir=archive.parent) as aside:
            with zipfile.ZipFile(archive) as opened:
                opened.extractall(aside)
            [unpacked] = Path(aside).glob("keycloak-*")
            program = unpacked / "bin" / "kc.sh"
            program.chmod(0o755)
            subprocess.run([program, "build", *OF_BUILD], check=True, capture_output=True, timeout=BUILD_TIMEOUT)
            with contextlib.suppress(OSError):  # another process may have been faster
                unpacked.rename(home)
    return home
