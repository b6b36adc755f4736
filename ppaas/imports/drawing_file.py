"""Drawings in DXF, read by ezdxf, and the metres of their units."""

import io
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable
from ppaas.imports.plain_entities import PlainEntity, SplitDrawing, split_drawing

UNITS = {
    1: 0.0254,
    2: 0.3048,
    3: 1609.344,
    4: 0.001,
    5: 0.01,
    6: 1.0,
    7: 1000.0,
    8: 0.0254e-6,
    9: 0.0254e-3,
    10: 0.9144,
    14: 0.1,
    21: 1200 / 3937,
}
"""Metres of the units of ``$INSUNITS``."""

_BINARY = b"AutoCAD Binary DXF"

_FAULTS = (OSError, ValueError, TypeError, LookupError, AttributeError, StopIteration, struct.error)
"""What ezdxf raises for files that are no drawings, beside its own errors."""


class ReadDrawing(NamedTuple):
    """Drawing that was read.

    Parameters
    ----------
    document : ezdxf.document.Drawing
        All but the plain entities.
    faults : int
        Number of faults that ezdxf has mended or left out.
    plain : sequence of PlainEntity
    numbers : mapping of str to int
        Places of entities among all of the file, by their handles.
    """

    document: Any
    faults: int = 0
    plain: Sequence[PlainEntity] = ()
    numbers: Mapping[str, int] = {}

    def entities(self) -> Iterator[Any]:
        """Yield the entities of the model in the order of the file: those of ezdxf, and plain ones."""
        done = 0
        for entity in self.document.modelspace():
            number = self.numbers.get(entity.dxf.handle, -1)
            while done < len(self.plain) and self.plain[done].number < number:
                yield self.plain[done]
                done += 1
            yield entity
        yield from self.plain[done:]


def read_drawing(content: bytes, source: str, extra: str) -> ReadDrawing:
    """Return a drawing.

    Parameters
    ----------
    content : bytes
    source : str
        Name of the file, for people.
    extra : str
        Extra that installs ezdxf with what else the import needs.

    Raises
    ------
    InvalidInput
        It is no drawing.
    Unavailable
        ezdxf is not installed.
    """
    try:
        from ezdxf import recover  # noqa: PLC0415 - only drawings need it
        from ezdxf.lldxf.const import DXFError  # noqa: PLC0415
    except ImportError as error:
        raise Unavailable(f"drawings need ezdxf: {install_hint(extra)}") from error
    found = _faultless(content)
    if found is not None:
        return found
    try:
        document, auditor = recover.read(io.BytesIO(content))
    except (DXFError, *_FAULTS) as error:
        raise InvalidInput(f"{source} is no drawing of DXF: {error!s:.200}") from error
    return ReadDrawing(document, len(auditor.errors))


def _faultless(content: bytes) -> ReadDrawing | None:
    """Return a drawing without faults, which is read in a third of the time or less; None if it is another."""
    from ezdxf.document import Drawing  # noqa: PLC0415 - only drawings need it
    from ezdxf.filemanagement import dxf_stream_info, read  # noqa: PLC0415
    from ezdxf.lldxf.const import DXFError  # noqa: PLC0415
    from ezdxf.lldxf.tagger import binary_tags_loader  # noqa: PLC0415

    try:
        if content.startswith(_BINARY):
            return ReadDrawing(Drawing.load(binary_tags_loader(content)))
        encoding = dxf_stream_info(io.StringIO(content.decode("latin-1"))).encoding
        split = _split(content.decode(encoding, "surrogateescape").replace("\r\n", "\n"))
        return ReadDrawing(read(io.StringIO(split.rest)), 0, split.plain, split.numbers)
    except (DXFError, *_FAULTS):
        return None


def _split(text: str) -> SplitDrawing:
    """Return a drawing without its plain entities; with them if they cannot be told from the rest."""
    try:
        return split_drawing(text)
    except ValueError:
        return SplitDrawing(text, [], {})


def unit_code(document: Any) -> int:
    """Return ``$INSUNITS`` of a drawing, a key of `UNITS` if its unit is known; 0 for none."""
    return int(document.header.get("$INSUNITS", 0))
