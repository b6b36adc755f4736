"""Files of the dashboard: their headers, and what they must not contain."""

import re

import httpx
import pytest

from endpoints.dashboard.pages import FOLDER, HEADERS, POLICY

FILES = sorted(file.relative_to(FOLDER).as_posix() for file in FOLDER.rglob("*") if file.is_file())
SCRIPTS = [FOLDER / name for name in FILES if name.endswith(".js")]
INDEX = (FOLDER / "index.html").read_text(encoding="utf-8")
MAX_LINES = 250


@pytest.mark.parametrize("name", FILES)
async def test_every_file_is_served_with_what_guards_it(client: httpx.AsyncClient, name: str) -> None:
    answer = await client.get(f"/dashboard/{name}")
    assert answer.status_code == 200
    assert {key: answer.headers[key] for key in HEADERS} == HEADERS
    types = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
    assert answer.headers["content-type"].startswith(types[name.rpartition(".")[2]])


async def test_a_file_that_did_not_change_is_not_sent_again(client: httpx.AsyncClient) -> None:
    first = await client.get("/dashboard/")
    again = await client.get("/dashboard/", headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert again.headers["cache-control"] == "no-cache"


async def test_a_browser_at_the_front_door_is_led_to_the_dashboard(client: httpx.AsyncClient) -> None:
    browser = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    for door in ("/", "/dashboard"):
        answer = await client.get(door, headers=browser, follow_redirects=True)
        assert answer.url.path == "/dashboard/"
        assert "<title>PPaaS dashboard</title>" in answer.text


async def test_a_program_at_the_front_door_is_told_where_to_go(client: httpx.AsyncClient) -> None:
    answer = await client.get("/", headers={"Accept": "application/json"})
    assert answer.status_code == 404
    assert "/v1" in answer.json()["detail"]


@pytest.mark.parametrize("path", ["nothing.js", "../pages.py", "..%2fpages.py", "%2e%2e/pages.py", "js/", "js"])
async def test_nothing_else_is_served(client: httpx.AsyncClient, path: str) -> None:
    answer = await client.get(f"/dashboard/{path}")
    assert answer.status_code == 404
    assert answer.json()["type"] == "urn:ppaas:problem:not-found"


def test_the_policy_allows_nothing_of_others_and_nothing_inline() -> None:
    assert "unsafe" not in POLICY and "http" not in POLICY and "*" not in POLICY
    assert not re.search(r"<script(?![^>]*\bsrc=)", INDEX)
    assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:|https?://", INDEX)


def test_no_script_writes_html_or_evaluates_text() -> None:
    html = r"innerHTML|outerHTML|insertAdjacentHTML|document\.write"
    danger = re.compile(html + r"|\beval\(|new Function|localStorage|console\.")
    assert [file.name for file in SCRIPTS if danger.search(file.read_text(encoding="utf-8"))] == []


def test_every_module_is_asked_for_with_the_page_so_that_none_waits_for_another() -> None:
    asked = set(re.findall(r'(?:src|href)="(js/\w+\.js)"', INDEX))
    assert asked == {name for name in FILES if name.endswith(".js")}


def test_modules_are_small_and_import_what_is_there() -> None:
    for file in SCRIPTS:
        text = file.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= MAX_LINES, file.name
        assert text.startswith("/**"), f"{file.name} does not say what it is for"
        assert [name for name in re.findall(r'from "\./(\w+\.js)"', text) if not (file.parent / name).exists()] == []
