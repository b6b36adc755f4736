"""Transfer of a map's cells; their values are tested in ppaas.maps."""

import httpx

from tests.unit.endpoints.conftest import LogIn, Publish


async def test_cells_are_gzipped_for_clients_that_accept_gzip(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish
) -> None:
    ann = await log_in("ann")
    await publish(ann)
    plain = await client.get("/v1/maps/house/cells", headers=ann | {"Accept-Encoding": "identity"})
    packed = await client.get("/v1/maps/house/cells", headers=ann | {"Accept-Encoding": "gzip"})
    assert "content-encoding" not in plain.headers
    assert (packed.headers["content-encoding"], packed.headers["vary"]) == ("gzip", "Accept-Encoding")
    assert packed.content == plain.content
    described = (await client.get("/v1/maps/house", headers=ann)).json()
    assert len(plain.content) == described["width"] * described["height"]


async def test_cells_require_read_access_to_the_map(client: httpx.AsyncClient, log_in: LogIn, publish: Publish) -> None:
    await publish(await log_in("ann"))
    assert (await client.get("/v1/maps/house/cells")).status_code == 401
    assert (await client.get("/v1/maps/house/cells", headers=await log_in("bob"))).status_code == 404
