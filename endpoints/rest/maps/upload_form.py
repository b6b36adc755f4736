"""Form that publishes a map: its files are written to the disk and hashed while they arrive.

The form is read only after the caller was authenticated, so that nobody fills the disk without a token.
"""

from collections.abc import AsyncIterator
from contextlib import AbstractContextManager, ExitStack, asynccontextmanager, nullcontext
from typing import Any

import msgspec
from fastapi import HTTPException, Request
from starlette.concurrency import run_in_threadpool

from endpoints.rest.maps.multipart import FormReader, Writer, consume
from endpoints.rest.schemas import MAX_DESCRIPTION, MAX_READERS
from endpoints.rest.strict_json import media_type_of
from ppaas.errors import InvalidMap, InvalidParameter, InvalidZones, PPaaSError
from ppaas.maps.formats.map_yaml import MAX_YAML, Rules, with_rules
from ppaas.zones.gate import checked_zones
from ppaas.zones.reading import geojson_of
from ppaas.zones.zone import NO_ZONES
from storage.names import PATTERN, check_name
from storage.ports import MapStore
from storage.staged_uploads import StagedUpload
from storage.versions import IMAGE, OCTOMAP, POSEGRAPH, YAML, ZONES

MULTIPART = "multipart/form-data"

MAX_ZONES = 1 << 20
"""Largest file with zones [bytes]."""

MAX_FIELDS = MAX_READERS + 8
"""Largest number of text fields of a form: the readers may have one each."""

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
                        "image": {"type": "string", "format": "binary", "description": "Image named in the YAML file"},
                        "octomap": {
                            "type": "string",
                            "format": "binary",
                            "description": "Octree of OctoMap (.bt or .ot), with these two files or instead of them",
                        },
                        "posegraph": {
                            "type": "string",
                            "format": "binary",
                            "description": "Pose graph that the grid was made of, from `ppaas map fetch` or a robot "
                            "that maps; with yaml and image only",
                        },
                        "zones": {
                            "type": "string",
                            "format": "binary",
                            "description": "Zones as GeoJSON in metres on the map; with yaml and image only. Default: "
                            "those of the current version; a collection without features removes them.",
                        },
                        "message": {
                            "type": "string",
                            "maxLength": MAX_DESCRIPTION,
                            "description": "Reason of the publication, shown in the list of versions",
                        },
                        "review": {
                            "type": "string",
                            "enum": ["true", "false"],
                            "description": "`true`: the version waits until the owner approves or refuses it. "
                            "Default: `false`.",
                        },
                        "readers": {
                            "type": "string",
                            "description": "User ids, comma-separated; `*` is everybody. Default: unchanged, or none.",
                        },
                        "description": {
                            "type": "string",
                            "maxLength": MAX_DESCRIPTION,
                            "description": "Free text. Default: unchanged, or none.",
                        },
                        "rules": {
                            "type": "string",
                            "enum": [rules.value for rules in Rules],
                            "description": "Rules for free and occupied cells; stored as the key `rules` of the YAML. "
                            "Default: the rules in the YAML, or those of map_server.",
                        },
                    },
                }
            }
        },
    }
}


class MapForm(msgspec.Struct, frozen=True):
    """Text fields of the form; ``readers`` and ``description`` are None if omitted.

    ``review`` is whether the version waits for a review, ``keeps_zones`` whether it has the zones of the current one,
    and ``warnings`` are those on the zones of the form.
    """

    id: str
    readers: tuple[str, ...] | None
    description: str | None
    message: str
    review: bool = False
    keeps_zones: bool = True
    warnings: tuple[str, ...] = ()


@asynccontextmanager
async def read_form(request: Request, store: MapStore) -> AsyncIterator[tuple[MapForm, StagedUpload]]:
    """Read the form of a request; its files are in a staged upload of the store until the block ends.

    Raises
    ------
    InvalidParameter
        A field is missing or too long, or is a file instead of text or text instead of a file.
    InvalidInput
        The id or a reader is not a valid name.
    InvalidMap, InvalidZones
        The YAML or the zones are invalid or too long.
    MalformedMessage
        The body is not a valid form.
    HTTPException
        415: the content type is not a form's.
    Unavailable
        The disk is full.
    """
    if media_type_of(request) != MULTIPART:
        raise HTTPException(415, f"send a form with the header 'Content-Type: {MULTIPART}'")
    with ExitStack() as stack:
        upload = await run_in_threadpool(stack.enter_context, store.stage())
        files = _Files(upload)
        with FormReader(request.headers["content-type"], files.open, MAX_FIELDS) as reader:
            await consume(request.stream(), reader.write)
            reader.end()
        form = _form(reader, keeps_zones=not files.has_zones)
        warnings = await run_in_threadpool(files.complete, _rules(reader))
        yield msgspec.structs.replace(form, warnings=tuple(warnings)), upload


class _Files:
    """Writes the files of a form to a staged upload.

    The YAML and the zones are written last: rules may be set in the YAML, and equal zones have equal files.
    """

    def __init__(self, upload: StagedUpload) -> None:
        self._upload = upload
        self._yaml: _FileBuffer | None = None
        self._zones: _FileBuffer | None = None

    @property
    def has_zones(self) -> bool:
        """True if the form has a file of zones, even one without features."""
        return self._zones is not None

    def open(self, name: str) -> AbstractContextManager[Writer]:
        """Return a context manager of the writer of a file."""
        if name == YAML and self._yaml is None:
            self._yaml = _FileBuffer(InvalidMap(f"the map's YAML is too long: at most {MAX_YAML} bytes"), MAX_YAML)
            return nullcontext(self._yaml)
        if name == ZONES and self._zones is None:
            too_long = InvalidZones(f"the zones are too long: at most {MAX_ZONES} bytes")
            self._zones = _FileBuffer(too_long, MAX_ZONES)
            return nullcontext(self._zones)
        if name in (IMAGE, OCTOMAP, POSEGRAPH):
            return self._upload.writing(name)
        raise InvalidParameter(
            f"unexpected or repeated file {name[:64]!r} in the form: send yaml, image, octomap, posegraph and zones "
            "once each"
        )

    def complete(self, rules: Rules | None) -> list[str]:
        """Write the YAML and the zones; return warnings. Raises ``InvalidParameter`` if a file is missing."""
        if (self._yaml is not None) != (IMAGE in self._upload.files):
            missing = YAML if self._yaml is None else IMAGE
            raise InvalidParameter(f"the form must also have a file {missing!r}, sent with a file name")
        if self._yaml is None and OCTOMAP not in self._upload.files:
            raise InvalidParameter("the form must have a file 'yaml' with its 'image', an 'octomap', or both")
        if self._yaml is None and POSEGRAPH in self._upload.files:
            raise InvalidParameter("a 'posegraph' needs the grid made of it: send 'yaml' and 'image' as well")
        if self._yaml is None and self._zones is not None:
            raise InvalidParameter("'zones' need the grid that they are on: send 'yaml' and 'image' as well")
        if self._yaml is not None:
            record = bytes(self._yaml.data)
            self._upload.add(YAML, [record if rules is None else with_rules(record, rules)])
        if self._zones is None:
            return []
        zones, warnings = checked_zones(bytes(self._zones.data))
        if zones != NO_ZONES:
            self._upload.add(ZONES, [geojson_of(zones)])
        return warnings


class _FileBuffer:
    """Collects a file in memory, up to ``most`` bytes."""

    def __init__(self, too_long: PPaaSError, most: int) -> None:
        self.data = bytearray()
        self._too_long, self._most = too_long, most

    def write(self, data: memoryview) -> None:
        """Append some bytes; raise the error if the file gets too long."""
        if len(self.data) + len(data) > self._most:
            raise self._too_long
        self.data += data


def _form(reader: FormReader, *, keeps_zones: bool) -> MapForm:
    map_id = check_name("map", _text(reader, "id") or "")
    description, message = _limited_text(reader, "description"), _limited_text(reader, "message") or ""
    return MapForm(map_id, _readers(reader), description, message, _review(reader), keeps_zones)


def _review(reader: FormReader) -> bool:
    text = _text(reader, "review") or "false"
    if text not in ("true", "false"):
        raise InvalidParameter(f"review must be true or false, not {text[:64]!r}")
    return text == "true"


def _text(reader: FormReader, key: str) -> str | None:
    values = reader.texts.get(key)
    if values is None and (key == "id" or key in reader.files):
        raise InvalidParameter(f"the form must have a text field {key!r}")
    return None if values is None else values[-1]


def _limited_text(reader: FormReader, key: str) -> str | None:
    text = _text(reader, key)
    if text is not None and len(text) > MAX_DESCRIPTION:
        raise InvalidParameter(f"the {key} must have at most {MAX_DESCRIPTION} characters, not {len(text)}")
    return text


def _rules(reader: FormReader) -> Rules | None:
    name = _text(reader, "rules")
    known = [rules.value for rules in Rules]
    if name is not None and name not in known:
        raise InvalidParameter(f"rules must be {' or '.join(known)}, not {name!r}")
    return None if name is None else Rules(name)


def _readers(reader: FormReader) -> tuple[str, ...] | None:
    if "readers" not in reader.texts:
        return None
    given = ",".join(reader.texts["readers"])
    names = dict.fromkeys(name.strip() for name in given.split(",") if name.strip())
    if len(names) > MAX_READERS:
        raise InvalidParameter(f"a map may have at most {MAX_READERS} readers, not {len(names)}; use '*' for everybody")
    return tuple(name if name == "*" else check_name("user", name) for name in names)
