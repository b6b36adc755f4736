"""Media types of request bodies."""

from starlette.requests import Request


def media_type_of(request: Request) -> str:
    """Return the media type of a body in lower case, without its parameters; empty if it is not declared."""
    return request.headers.get("content-type", "").partition(";")[0].strip().lower()


def is_format(media_type: str, name: str) -> bool:
    """Return whether a media type is a format such as ``json``, or is based on it (RFC 6838, 4.2.8)."""
    return media_type == f"application/{name}" or (
        media_type.startswith("application/") and media_type.endswith(f"+{name}")
    )
