"""Robot models over REST."""

import httpx

from ppaas.robot_model.known_models import model_names, robot_model
from tests.unit.endpoints.conftest import LogIn


async def test_every_model_is_listed_with_its_radius(client: httpx.AsyncClient, log_in: LogIn) -> None:
    answer = await client.get("/v1/models?limit=500", headers=await log_in("ann"))
    listed = answer.json()
    assert listed["next"] is None
    assert {model["name"]: model["robot_radius"] for model in listed["items"]} == {
        name: robot_model(name).robot_radius for name in model_names()
    }


async def test_listing_models_requires_a_login(client: httpx.AsyncClient) -> None:
    assert (await client.get("/v1/models")).status_code == 401
