"""The multipart form that a map is published with.

It is read only after the caller is known: nobody fills the disk without a token.
"""

import tempfile
from pathlib import Path
from typing import Annotated, Any

import msgspec
from fastapi import Depends, HTTPException, Request
from starlette.datastructures import FormData, UploadFile

from endpoints.rest.dependencies import Caller
from endpoints.rest.schemas import MAX_DESCRIPTION, MAX_READERS
from ppaas.errors import InvalidParameter
from ppaas.maps.record import Rules
from storage.failures import disk_errors
from storage.names import PATTERN, check_name

MULTIPART = "multipart/form-data"

OPENAPI: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            MULTIPART: {
                "schema": {
                    "type": "object",
                    "required": ["id", "yaml", "image"],
                    "properties": {
                        "id": {"type": "string", "pattern": f"^{PATTERN}$"},
                        "yaml": {"type": "string", "format": "binary", "description": "map_server's YAML file"},
                        "image": {"type": "string", "format": "binary", "description": "The image that it names"},
                        "readers": {
                            "type": "string",
                            "description": "User ids, comma-separated; `*` is everybody. Left out: as before, or none.",
                        },
                        "description": {
                            "type": "string",
                            "maxLength": MAX_DESCRIPTION,
                            "description": "For people. Left out: as before, or none.",
                        },
                        "rules": {
                            "type": "string",
                            "enum": [rules.value for rules in Rules],
                            "description": "Whose rules tell free from occupied; kept as the key `rules` of the YAML. "
                            "Left out: what the YAML says, or map_server's.",
                        },
                    },
                }
            }
        },
    }
}


class MapForm(msgspec.Struct, frozen=True):
    """What was sent; ``readers``, ``description`` and ``rules`` are None where nothing was said of them."""

    id: str
    yaml: bytes
    image: bytes
    readers: tuple[str, ...] | None
    description: str | None
    rules: Rules | None


async def read_map_form(request: Request, _user: Caller) -> MapForm:
    """Return the form of a request.

    Raises
    ------
    InvalidParameter
        A part is missing, a file where text should be or the other way round.
    InvalidInput
        The id or a reader is no name.
    HTTPException
        415: what was sent is no form.
    Unavailable
        The disk that large forms wait on is full.
    """
    if request.headers.get("content-type", "").partition(";")[0].strip().lower() != MULTIPART:
        raise HTTPException(415, f"send a form with the files: 'Content-Type: {MULTIPART}'")
    with disk_errors(Path(tempfile.gettempdir())):
        async with request.form(max_files=2, max_fields=MAX_READERS + 3) as form:
            map_id = check_name("map", _text(form, "id"))
            files = await _file(form, "yaml"), await _file(form, "image")
            return MapForm(map_id, *files, _readers(form), _description(form), _rules(form))


PublishedMap = Annotated[MapForm, Depends(read_map_form)]


def _text(form: FormData, key: str) -> str:
    value = form.get(key)
    if not isinstance(value, str):
        raise InvalidParameter(f"the form must have a text field {key!r}")
    return value


async def _file(form: FormData, key: str) -> bytes:
    value = form.get(key)
    if not isinstance(value, UploadFile):
        raise InvalidParameter(f"the form must have a file {key!r}; send it as multipart/form-data with a file name")
    return await value.read()


def _description(form: FormData) -> str | None:
    if "description" not in form:
        return None
    text = _text(form, "description")
    if len(text) > MAX_DESCRIPTION:
        raise InvalidParameter(f"a description has {MAX_DESCRIPTION} characters at most, not {len(text)}")
    return text


def _rules(form: FormData) -> Rules | None:
    if "rules" not in form:
        return None
    name = _text(form, "rules")
    known = [rules.value for rules in Rules]
    if name not in known:
        raise InvalidParameter(f"rules are {' or '.join(known)}, not {name!r}")
    return Rules(name)


def _readers(form: FormData) -> tuple[str, ...] | None:
    if "readers" not in form:
        return None
    given = ",".join(value for value in form.getlist("readers") if isinstance(value, str))
    names = dict.fromkeys(name.strip() for name in given.split(",") if name.strip())
    if len(names) > MAX_READERS:
        raise InvalidParameter(f"a map has {MAX_READERS} readers at most, not {len(names)}; '*' is everybody")
    return tuple(name if name == "*" else check_name("user", name) for name in names)
