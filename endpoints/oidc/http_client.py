"""HTTP to an identity provider, within limits: it may be slow, send too much, or not be one at all."""

import ssl
from collections.abc import AsyncIterator

import httpx2

MAX_ANSWER = 1 << 20
"""Largest answer [bytes]."""

TIMEOUT = 5.0
"""Time limit of each part of an exchange [s]."""


class BoundedTransport(httpx2.AsyncBaseTransport):
    """Transport whose answers are limited and not compressed; it follows no redirect and uses no proxy.

    Parameters
    ----------
    context : SSLContext
        Authorities that are trusted.
    """

    def __init__(self, context: ssl.SSLContext) -> None:
        self._inner = httpx2.AsyncHTTPTransport(verify=context)

    async def handle_async_request(self, request: httpx2.Request) -> httpx2.Response:
        """Send a request; ``ReadError`` if the answer is compressed, as its size would not be known."""
        request.headers["Accept-Encoding"] = "identity"
        answer = await self._inner.handle_async_request(request)
        if answer.headers.get("content-encoding", "identity") != "identity":
            await answer.aclose()
            raise httpx2.ReadError("the answer is compressed, which was not asked for", request=request)
        assert isinstance(answer.stream, httpx2.AsyncByteStream)
        return httpx2.Response(
            answer.status_code,
            headers=answer.headers,
            stream=_Bounded(answer.stream, request),
            extensions=answer.extensions,
        )

    async def aclose(self) -> None:
        """Close the connections."""
        await self._inner.aclose()


class _Bounded(httpx2.AsyncByteStream):
    """Body of an answer, up to `MAX_ANSWER`."""

    def __init__(self, inner: httpx2.AsyncByteStream, request: httpx2.Request) -> None:
        self._inner = inner
        self._request = request

    async def __aiter__(self) -> AsyncIterator[bytes]:
        size = 0
        async for part in self._inner:
            size += len(part)
            if size > MAX_ANSWER:
                raise httpx2.ReadError(f"the answer has more than {MAX_ANSWER} bytes", request=self._request)
            yield part

    async def aclose(self) -> None:
        await self._inner.aclose()
