"""Checks of problem responses."""

from typing import Any

import httpx


def problem_of(response: httpx.Response, status: int, slug: str) -> dict[str, Any]:
    """Return the body of a response, which must be this problem."""
    assert (response.status_code, response.headers["content-type"]) == (status, "application/problem+json"), (
        response.text
    )
    body: dict[str, Any] = response.json()
    assert (body["type"], body["status"]) == (f"urn:ppaas:problem:{slug}", status)
    assert body["title"]
    assert body["detail"]
    return body
