"""REST client against a real HTTP server; its forms are read by the web framework's parser."""

import json
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any, ClassVar

import pytest
from starlette.datastructures import Headers, UploadFile
from starlette.formparsers import MultiPartParser

from ppaas.errors import InvalidInput, InvalidMap, NotAuthenticated, PPaaSError, Starting, Unavailable
from robots.client import rest
from robots.client.rest import Login, RestClient
from robots.client.robot_file import RobotFile


class Handler(BaseHTTPRequestHandler):
    answers: ClassVar[list[tuple[int, bytes]]] = []
    requests: ClassVar[list[dict[str, Any]]] = []
    seconds: ClassVar[float] = 0.0
    """Time before the answer [s]."""

    def answer(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.requests.append({"line": self.requestline, "headers": dict(self.headers), "body": body})
        time.sleep(self.seconds)
        status, data = self.answers.pop(0)
        self.send_response(status)
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)

    do_GET = do_PATCH = do_POST = do_PUT = answer  # noqa: N815

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Log nothing."""


@contextmanager
def serving(*answers: tuple[int, bytes]) -> Iterator[str]:
    Handler.answers, Handler.requests, Handler.seconds = list(answers), [], 0.0
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


async def test_requests_after_a_login_carry_its_token() -> None:
    with serving((201, b'{"token": "abc", "expires": 5.5}'), (200, b"{}")) as url:
        client = RestClient(url)
        assert await client.login("ann", "pass word") == Login("abc", 5.5)
        await client.put_robot("tb/1 ü", RobotFile(map="depot", initial_pose=(1.0, 2.0, 3.0)))
    login, put = Handler.requests
    assert login["line"].startswith("POST /v1/tokens ")
    assert json.loads(login["body"]) == {"user": "ann", "password": "pass word"}
    assert put["line"].startswith("PUT /v1/robots/tb%2F1%20%C3%BC ")
    assert put["headers"]["Authorization"] == "Bearer abc"
    assert put["headers"]["Content-Type"] == "application/json"
    assert json.loads(put["body"])["initial_pose"] == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("path", ["/ppaas", "/ppaas/", "/a/b", "/", ""])
async def test_the_path_of_the_url_is_kept(path: str) -> None:
    with serving((200, b"{}")) as url:
        await RestClient(url + path, "t").get("/v1/maps")
    assert Handler.requests[0]["line"].split()[1] == f"{path.rstrip('/')}/v1/maps"


async def test_a_redirect_is_reported_instead_of_followed() -> None:
    with serving((301, b"<html>")) as url, pytest.raises(InvalidInput, match="redirects: give the URL of the cloud"):
        await RestClient(url, "t").get("/v1/maps")


async def test_a_map_is_uploaded_as_a_form_with_unchanged_files() -> None:
    yaml, image = b"image: map.pgm\r\n", bytes(range(256)) * 4 + b"\r\n--\r\n"
    with serving((201, b"{}")) as url:
        await RestClient(url, "t").upload_map("depot", yaml, image, ("ann", "*"))
    [request] = Handler.requests

    async def body() -> Any:
        yield request["body"]

    form = await MultiPartParser(Headers({"content-type": request["headers"]["Content-Type"]}), body()).parse()
    assert form["id"] == "depot"
    assert form.getlist("readers") == ["ann", "*"]
    for name, content in (("yaml", yaml), ("image", image)):
        upload = form[name]
        assert isinstance(upload, UploadFile)
        assert await upload.read() == content


async def test_a_problem_response_raises_its_error() -> None:
    refusal = b'{"type": "urn:ppaas:problem:invalid-map", "detail": "the image is cut off"}'
    with serving((422, refusal), (401, b"")) as url:
        client = RestClient(url)
        with pytest.raises(InvalidMap, match="the image is cut off"):
            await client.upload_map("depot", b"", b"")
        with pytest.raises(NotAuthenticated):
            await client.login("ann", "wrong")
        assert client.token is None


async def test_a_response_of_another_server_is_reported() -> None:
    with serving((200, b"<html>")) as url, pytest.raises(PPaaSError, match="did not answer like a PPaaS cloud"):
        await RestClient(url).login("ann", "pass")


async def test_an_unreachable_server_is_unavailable() -> None:
    with serving() as url:
        pass
    with pytest.raises(Unavailable, match="cannot reach 127"):
        await RestClient(url).login("ann", "pass")


async def test_a_silent_server_is_unavailable_after_the_time_limit() -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        client = RestClient(f"http://127.0.0.1:{silent.getsockname()[1]}", timeout=0.1)
        with pytest.raises(Unavailable, match=r"no answer from 127\.0\.0\.1:\d+ within 0\.1 s"):
            await client.get("/v1/maps")


async def test_an_upload_waits_for_the_check_of_its_files() -> None:
    with serving((201, b"{}")) as url:
        Handler.seconds = 0.5
        assert await RestClient(url, "t", timeout=0.1).upload_map("depot", b"", b"") == {}


@pytest.mark.parametrize("url", ["ftp://host", "host:80", "http://"])
def test_an_invalid_url_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput, match="http://host:port"):
        RestClient(url)


async def test_a_list_is_fetched_page_by_page_to_its_end() -> None:
    pages = (200, b'{"items": [1, 2], "next": "a+b"}'), (200, b'{"items": [3], "next": null}')
    with serving(*pages) as url:
        assert await RestClient(url, "abc").items("/v1/robots") == [1, 2, 3]
    assert [asked["line"].split()[1] for asked in Handler.requests] == [
        "/v1/robots?limit=500",
        "/v1/robots?limit=500&cursor=a%2Bb",
    ]


async def test_a_limited_list_fetches_no_more_than_requested() -> None:
    pages = (200, b'{"items": [1, 2], "next": "c"}'), (200, b'{"items": [3], "next": "d"}')
    with serving(*pages) as url:
        assert await RestClient(url, "abc").items("/v1/robots", 3) == [1, 2, 3]
    assert [asked["line"].split()[1] for asked in Handler.requests] == [
        "/v1/robots?limit=3",
        "/v1/robots?limit=1&cursor=c",
    ]


@pytest.mark.parametrize("answer", [b"[]", b"null", b'{"items": []}', b"{"])
async def test_a_malformed_page_is_refused(answer: bytes) -> None:
    with serving((200, answer)) as url, pytest.raises(PPaaSError, match=r"did not answer with a list|not JSON"):
        await RestClient(url, "abc").items("/v1/robots")


async def test_a_change_is_a_merge_patch() -> None:
    with serving((200, b'{"cores": 0.5}')) as url:
        assert await RestClient(url, "abc").patch("/v1/robots/tb1", {"cores": 0.5, "map": None}) == {"cores": 0.5}
    [asked] = Handler.requests
    assert asked["line"].startswith("PATCH /v1/robots/tb1 ")
    assert asked["headers"]["Content-Type"] == "application/merge-patch+json"
    assert json.loads(asked["body"]) == {"cores": 0.5, "map": None}


STARTING = (503, b'{"type": "urn:ppaas:problem:starting", "detail": "compiling kernels, 12 of 107"}')


async def test_a_request_waits_while_the_cloud_compiles_kernels(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(rest, "RETRY", 0.0)
    with serving(STARTING, STARTING, (201, b'{"cost": 5.0}')) as url:
        assert await RestClient(url).plan("depot", (1, 2), (3, 4), planner="lattice") == {"cost": 5.0}
        bodies = {request["body"] for request in Handler.requests}
        assert (len(Handler.requests), len(bodies)) == (3, 1)
    assert caplog.text.count("12 of 107") == 1


async def test_a_request_does_not_wait_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rest, "START_PATIENCE", -1.0)
    with serving(STARTING) as url, pytest.raises(Starting, match="12 of 107"):
        await RestClient(url).get("/v1/maps")
