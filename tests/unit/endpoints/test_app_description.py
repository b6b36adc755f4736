"""The description of the REST service can be had without a cloud."""

import httpx

from endpoints.app import description


async def test_it_is_the_one_that_a_cloud_serves(client: httpx.AsyncClient) -> None:
    assert (await client.get("/openapi.json")).json() == description()
