"""Data that earlier releases wrote (``tests/earlier``)."""

import hashlib
import json
import tarfile
from pathlib import Path
from typing import Any

import cbor2
import httpx
import numpy as np

from robots.client.cloud_url import bearer
from robots.client.rest import RestClient
from tests.support.endpoints.cbor_arrays import array_in
from tests.support.sources import ROOT

EARLIER = sorted(file.parent for file in (ROOT / "tests" / "earlier").glob("*/expected.json"))
ADMIN_PASSWORD = "correct horse battery"
ANN_PASSWORD = "a long walk home"
KEYSPACE = "earlier"


def expected(earlier: Path) -> dict[str, Any]:
    """Return the answers of the earlier release about its data."""
    told: dict[str, Any] = json.loads((earlier / "expected.json").read_text())
    return told


def unpack(earlier: Path, folder: Path) -> Path:
    """Copy the files of the release to a folder, and return it; its data folder is ``data`` there."""
    with tarfile.open(earlier / "data.tar.xz") as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)  # Python 3.11 has it from 3.11.4 on
        archive.extractall(folder)
    return folder


def without_poses(plan: dict[str, Any]) -> dict[str, Any]:
    """Return a plan in the form of the REST interface, with a digest in place of its waypoints."""
    return plan | {"poses": digest(np.array(plan["poses"], "<f8").tobytes())}


def digest(poses: bytes) -> str:
    """Return a digest of waypoints, exact to the bit."""
    return hashlib.sha256(poses).hexdigest()


async def plan_of(url: str, rest: RestClient, plan_id: str) -> dict[str, Any]:
    """Return a stored plan with all digits, in CBOR: the numbers in JSON are rounded."""
    headers = bearer(rest.token or "") | {"Accept": "application/cbor"}
    async with httpx.AsyncClient(base_url=url, headers=headers) as client:
        answer = (await client.get(f"/v1/plans/{plan_id}")).raise_for_status()
    plan: dict[str, Any] = cbor2.loads(answer.content)
    return plan | {"poses": array_in(plan["poses"])}


async def lost(url: str, rest: RestClient, before: dict[str, Any]) -> list[str]:
    """Return the parts of ann's data that a cloud does not report any more."""
    now: dict[str, Any] = {
        "maps": await rest.items("/v1/maps"),
        "versions": await rest.items("/v1/maps/house/versions"),
        "robots": await rest.items("/v1/robots"),
        "evaluation": await rest.get("/v1/maps/house/evaluation"),
        "plans": {plan_id: without_poses(await plan_of(url, rest, plan_id)) for plan_id in before["plans"]},
        "parts": {plan_id: (await rest.get(f"/v1/plans/{plan_id}/parts"))["items"] for plan_id in before["parts"]},
    }
    user = await rest.get("/v1/users/me")
    rights = [name for name in ("id", "role", "limits") if not still_said(before["user"][name], user[name])]
    return rights + [name for name, said in now.items() if not still_said(before[name], said)]


def still_said(before: Any, now: Any) -> bool:
    """Return whether an answer contains the expected one; a later release may report more."""
    if isinstance(before, dict):
        return isinstance(now, dict) and all(name in now and still_said(before[name], now[name]) for name in before)
    if isinstance(before, list):
        return isinstance(now, list) and len(before) == len(now) and all(map(still_said, before, now))
    return bool(before == now)
