"""The form that a map is published with, read as it comes: large files go to the disk, hashed on the way.

It is read only after the caller is known: nobody fills the disk without a token.
"""

from collections.abc import AsyncIterator, Iterator
from contextlib import AbstractContextManager, ExitStack, asynccontextmanager, contextmanager
from typing import Any

import msgspec
from fastapi import HTTPException, Request
from starlette.concurrency import run_in_threadpool

from endpoints.rest.maps.body_stream import taken
from endpoints.rest.maps.multipart import FormReader, Writer
from endpoints.rest.schemas import MAX_DESCRIPTION, MAX_READERS
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.maps.formats.map_yaml import MAX_YAML, Rules, with_rules
from storage.names import PATTERN, check_name
from storage.ports import MapStore
from storage.staged_uploads import StagedUpload
from storage.versions import IMAGE, OCTOMAP, YAML

MULTIPART = "multipart/form-data"

OPENAPI: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            MULTIPART: {
                "schema": {
                    "type": "object",
                    "required": ["id"],
                    "properties": {
                        "id": {"type": "string", "pattern": f"^{PATTERN}$"},
                        "yaml": {"type": "string", "format": "binary", "description": "map_server's YAML file"},
                        "image": {"type": "string", "format": "binary", "description": "The image that it names"},
                        "octomap": {
                            "type": "string",
                            "format": "binary",
                            "description": "An octree of OctoMap (.bt or .ot), beside these two or in their place",
                        },
                        "message": {
                            "type": "string",
                            "maxLength": MAX_DESCRIPTION,
                            "description": "Why it is published, for those who look at its versions later",
                        },
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
    """What is said of a map beside its files; ``readers`` and ``description`` are None where nothing is."""

    id: str
    readers: tuple[str, ...] | None
    description: str | None
    message: str


@asynccontextmanager
async def received(request: Request, store: MapStore) -> AsyncIterator[tuple[MapForm, StagedUpload]]:
    """Read the form of a request; its files are in a draft of the store as long as the block lasts.

    Raises
    ------
    InvalidParameter
        A part is missing, too long, a file where text should be or the other way round.
    InvalidInput
        The id or a reader is no name.
    InvalidMap
        The YAML is none, or too long.
    MalformedMessage
        What was sent is no form.
    HTTPException
        415: it is not said to be one.
    Unavailable
        The disk is full.
    """
    content_type = request.headers.get("content-type", "")
    if content_type.partition(";")[0].strip().lower() != MULTIPART:
        raise HTTPException(415, f"send a form with the files: 'Content-Type: {MULTIPART}'")
    with ExitStack() as stack:
        draft = await run_in_threadpool(stack.enter_context, store.stage())
        files = _Files(draft)
        with FormReader(content_type, files.open, MAX_READERS + 8) as reader:
            await taken(request.stream(), reader.write)
            reader.end()
        form = _form(reader)
        await run_in_threadpool(files.complete, _rules(reader))
        yield form, draft


class _Files:
    """The files of a form on their way into a draft; the YAML waits, for rules may be set in it."""

    def __init__(self, draft: StagedUpload) -> None:
        self._draft = draft
        self._yaml: _Short | None = None

    def open(self, name: str) -> AbstractContextManager[Writer]:
        """Return what takes a file."""
        if name == YAML and self._yaml is None:
            return self._take_yaml()
        if name in (IMAGE, OCTOMAP):
            return self._draft.writing(name)
        raise InvalidParameter(f"the form has the file {name[:64]!r} (again): its files are yaml, image and octomap")

    @contextmanager
    def _take_yaml(self) -> Iterator[Writer]:
        self._yaml = _Short()
        yield self._yaml

    def complete(self, rules: Rules | None) -> None:
        """Write the YAML; ``InvalidParameter`` if a file is missing."""
        if (self._yaml is not None) != (IMAGE in self._draft.files):
            missing = YAML if self._yaml is None else IMAGE
            raise InvalidParameter(f"the form must have a file {missing!r} too; send it with a file name")
        if self._yaml is None and OCTOMAP not in self._draft.files:
            raise InvalidParameter("the form must have a file 'yaml' with its 'image', an 'octomap', or both")
        if self._yaml is not None:
            record = bytes(self._yaml.data)
            self._draft.add(YAML, [record if rules is None else with_rules(record, rules)])


class _Short:
    """Takes a file that is short."""

    def __init__(self) -> None:
        self.data = bytearray()

    def write(self, data: memoryview) -> None:
        """Take some bytes; ``InvalidMap`` if they are too many."""
        if len(self.data) + len(data) > MAX_YAML:
            raise InvalidMap(f"the map's YAML is too long; at most {MAX_YAML} bytes are read")
        self.data += data


def _form(reader: FormReader) -> MapForm:
    map_id = check_name("map", _text(reader, "id") or "")
    return MapForm(map_id, _readers(reader), _described(reader, "description"), _described(reader, "message") or "")


def _text(reader: FormReader, key: str) -> str | None:
    values = reader.texts.get(key)
    if values is None and (key == "id" or key in reader.files):
        raise InvalidParameter(f"the form must have a text field {key!r}")
    return None if values is None else values[-1]


def _described(reader: FormReader, key: str) -> str | None:
    text = _text(reader, key)
    if text is not None and len(text) > MAX_DESCRIPTION:
        raise InvalidParameter(f"a {key} has {MAX_DESCRIPTION} characters at most, not {len(text)}")
    return text


def _rules(reader: FormReader) -> Rules | None:
    name = _text(reader, "rules")
    known = [rules.value for rules in Rules]
    if name is not None and name not in known:
        raise InvalidParameter(f"rules are {' or '.join(known)}, not {name!r}")
    return None if name is None else Rules(name)


def _readers(reader: FormReader) -> tuple[str, ...] | None:
    if "readers" not in reader.texts:
        return None
    given = ",".join(reader.texts["readers"])
    names = dict.fromkeys(name.strip() for name in given.split(",") if name.strip())
    if len(names) > MAX_READERS:
        raise InvalidParameter(f"a map has {MAX_READERS} readers at most, not {len(names)}; '*' is everybody")
    return tuple(name if name == "*" else check_name("user", name) for name in names)
