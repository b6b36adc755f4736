"""Files of the dashboard: their headers, and what they must not contain."""

import re
import subprocess
from pathlib import Path

import httpx
import pytest
from playwright._impl._driver import compute_driver_executable

from endpoints.dashboard.pages import FOLDER, HEADERS, POLICY

FILES = sorted(file.relative_to(FOLDER).as_posix() for file in FOLDER.rglob("*") if file.is_file())
SCRIPTS = [FOLDER / name for name in FILES if name.endswith(".js")]
INDEX = (FOLDER / "index.html").read_text(encoding="utf-8")
MAX_LINES = 250


@pytest.mark.parametrize("name", FILES)
async def test_every_file_is_served_with_security_headers(client: httpx.AsyncClient, name: str) -> None:
    answer = await client.get(f"/dashboard/{name}")
    assert answer.status_code == 200
    assert {key: answer.headers[key] for key in HEADERS} == HEADERS
    types = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
    assert answer.headers["content-type"].startswith(types[name.rpartition(".")[2]])


async def test_an_unchanged_file_is_answered_with_304(client: httpx.AsyncClient) -> None:
    first = await client.get("/dashboard/")
    again = await client.get("/dashboard/", headers={"If-None-Match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert again.headers["cache-control"] == "no-cache"


async def test_browsers_are_redirected_from_the_root_to_the_dashboard(client: httpx.AsyncClient) -> None:
    browser = {"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"}
    for path in ("/", "/dashboard"):
        answer = await client.get(path, headers=browser, follow_redirects=True)
        assert answer.url.path == "/dashboard/"
        assert "<title>PPaaS dashboard</title>" in answer.text


async def test_a_json_client_at_the_root_gets_404_with_a_hint_to_v1(client: httpx.AsyncClient) -> None:
    answer = await client.get("/", headers={"Accept": "application/json"})
    assert answer.status_code == 404
    assert "/v1" in answer.json()["detail"]


@pytest.mark.parametrize("path", ["nothing.js", "../pages.py", "..%2fpages.py", "%2e%2e/pages.py", "js/", "js"])
async def test_unknown_dashboard_paths_are_not_found(client: httpx.AsyncClient, path: str) -> None:
    answer = await client.get(f"/dashboard/{path}")
    assert answer.status_code == 404
    assert answer.json()["type"] == "urn:ppaas:problem:not-found"


def test_content_security_policy_forbids_external_and_inline_code() -> None:
    assert "unsafe" not in POLICY and "http" not in POLICY and "*" not in POLICY
    assert not re.search(r"<script(?![^>]*\bsrc=)", INDEX)
    assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:|https?://", INDEX)


def test_no_script_writes_html_or_evaluates_text() -> None:
    html = r"innerHTML|outerHTML|insertAdjacentHTML|document\.write"
    danger = re.compile(html + r"|\beval\(|new Function|localStorage|console\.")
    assert [file.name for file in SCRIPTS if danger.search(file.read_text(encoding="utf-8"))] == []


def test_the_index_page_loads_every_module_itself() -> None:
    asked = set(re.findall(r'(?:src|href)="(js/[\w/]+\.js)"', INDEX))
    assert asked == {name for name in FILES if name.endswith(".js")}


def test_the_dashboard_begins_once_all_pages_and_parts_are_added() -> None:
    added = [
        file for file in SCRIPTS if re.search(r"^add(Page|CardPart)\(", file.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    names = {file.relative_to(FOLDER).as_posix() for file in added}
    scripts = re.findall(r'<script type="module" src="([^"]+)"></script>', INDEX)
    assert len(names) >= 2
    assert (set(scripts[:-1]), scripts[-1]) == (names, "js/main.js")


def test_modules_are_small_documented_and_import_existing_files() -> None:
    for file in SCRIPTS:
        text = file.read_text(encoding="utf-8")
        assert len(text.splitlines()) <= MAX_LINES, file.name
        assert text.startswith("/**"), f"{file.name} has no comment at its top"
        assert [name for name in re.findall(r'from "(\.[^"]+)"', text) if not (file.parent / name).exists()] == []


def test_no_link_or_request_leaves_the_path_of_a_proxy() -> None:
    absolute = re.compile(r"""["'`]/(?:v1|dashboard|docs|js|css|\?|["'`])""")
    texts = {file.name: file.read_text(encoding="utf-8") for file in [*SCRIPTS, FOLDER / "index.html"]}
    assert [name for name, text in texts.items() if absolute.search(text)] == []


def test_no_script_puts_a_token_into_an_address() -> None:
    texts = [file.read_text(encoding="utf-8") for file in SCRIPTS]
    assert not any(re.search(r"URLSearchParams\([^)]*token", text) for text in texts)


HERE = Path(__file__).parent
TESTS = sorted(HERE.rglob("*.test.js"))


# Pure JavaScript modules of the dashboard, tested by node, which comes with Playwright.


@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.name.removesuffix(".test.js"))
def test_javascript_module_passes_its_tests(file: Path) -> None:
    node, _ = compute_driver_executable()
    command = [node, "--no-warnings", "--test-reporter=spec", str(file)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "tests 0" not in result.stdout
