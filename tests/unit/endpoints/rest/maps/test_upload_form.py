"""Form that publishes a map."""

import httpx
import pytest

from endpoints.services.services import Services
from tests.support.endpoints.problems import problem_of
from tests.unit.endpoints.conftest import LogIn, Publish


@pytest.mark.parametrize("readers", ["bob;carl", "../x", ",".join(f"u{n}" for n in range(257))])
async def test_invalid_reader_names_are_refused(log_in: LogIn, publish: Publish, readers: str) -> None:
    answer = await publish(await log_in("ann"), readers=readers)
    assert answer.status_code in (400, 422)
    problem_of(answer, answer.status_code, answer.json()["type"].rpartition(":")[2])


@pytest.mark.parametrize(
    ("data", "files", "missing"),
    [
        ({}, {"yaml": b"", "image": b""}, "'id'"),
        ({"id": "house"}, {"yaml": b""}, "'image'"),
        ({"id": "house", "yaml": "image: x"}, {"image": b""}, "'yaml'"),
        ({}, {"id": b"house", "yaml": b"", "image": b""}, "'id'"),
    ],
)
async def test_a_missing_form_part_is_named(
    client: httpx.AsyncClient, log_in: LogIn, data: dict[str, str], files: dict[str, bytes], missing: str
) -> None:
    answer = await client.post("/v1/maps", headers=await log_in("ann"), data=data, files=files)
    assert missing in problem_of(answer, 422, "invalid-parameter")["detail"]


@pytest.mark.parametrize(
    ("content_type", "content"),
    [
        ("multipart/form-data", b"x"),
        ("multipart/form-data; boundary=b", b"\x00\xff" * 100),
        ("multipart/form-data; boundary=b", b'--b\r\nContent-Disposition: form-data; name="id"\r\n\r\nhou'),
    ],
)
async def test_a_malformed_form_is_a_problem(
    client: httpx.AsyncClient, log_in: LogIn, content_type: str, content: bytes
) -> None:
    headers = await log_in("ann") | {"Content-Type": content_type}
    answer = await client.post("/v1/maps", headers=headers, content=content)
    assert answer.status_code in (400, 422)
    assert answer.headers["content-type"] == "application/problem+json"


async def test_a_body_of_another_content_type_is_refused(client: httpx.AsyncClient, log_in: LogIn) -> None:
    for headers in ({"Content-Type": "application/json"}, {}):
        answer = await client.post("/v1/maps", headers=await log_in("ann") | headers, content=b"{}")
        assert "multipart/form-data" in problem_of(answer, 415, "unsupported-media-type")["detail"]


async def test_uploads_over_the_limit_are_refused_with_or_without_a_length(
    client: httpx.AsyncClient, log_in: LogIn, publish: Publish, services: Services
) -> None:
    ann = await log_in("ann")
    problem_of(await publish(ann, image=bytes(services.limits.max_upload)), 413, "message-too-large")

    async def endless() -> object:
        yield b'--b\r\nContent-Disposition: form-data; name="image"; filename="x"\r\n\r\n'
        for _ in range(100):
            yield bytes(64 << 10)

    headers = ann | {"Content-Type": "multipart/form-data; boundary=b"}
    problem_of(await client.post("/v1/maps", headers=headers, content=endless()), 413, "message-too-large")
    assert services.map_store.maps() == []
