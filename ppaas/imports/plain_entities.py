"""Plain entities of drawings in DXF: lines, polylines without arcs, and texts, read many times faster than by ezdxf.

Large drawings are made of these. They are taken out of the text of a drawing, and ezdxf reads the rest.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import compress
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_START, _NAME, _HANDLE, _LAYER, _MODEL = 0, 2, 5, 8, 410
_X, _Y, _X_END, _Y_END, _BULGE, _FLAGS = 10, 20, 11, 21, 42, 70
_AXIS = {210: 0.0, 220: 0.0, 230: 1.0}
"""The axis of an extrusion, z up as default."""

_CLOSED = 1
_HIGHEST = 1100
"""Group codes are less."""

_COMMON = {
    _START, _HANDLE, 6, _LAYER, 39, 48, 62, 92, 100, 102, 160, 284, 310, 330, 347, 348, 360, 370, 380, 390, _MODEL,
    420, 430, 440, 999, *_AXIS, *range(1000, 1072),
}  # fmt: skip
"""Group codes of any entity that change no position."""

_LINE, _POLYLINE = "LINE", "LWPOLYLINE"
_CODES = {
    _LINE: _COMMON | {_X, _Y, 30, _X_END, _Y_END, 31},
    _POLYLINE: _COMMON | {_X, _Y, 38, 40, 41, _BULGE, 43, _FLAGS, 90},
    **dict.fromkeys(("TEXT", "MTEXT", "POINT"), set(range(_HIGHEST)) - {67}),
}
"""Group codes that a plain entity of a kind may have; 67 is for entities on a sheet of paper."""

_Mask = NDArray[np.bool_]
_Places = NDArray[np.int64]


class PlainEntity(NamedTuple):
    """Entity without blocks, arcs or axes of its own.

    Parameters
    ----------
    number : int
        Place among the entities of the file.
    kind, layer, handle : str
        As in DXF; the handle is empty if the file has none.
    points : (n, 2) array
        Corners [units of the drawing]; none of a text.
    """

    number: int
    kind: str
    layer: str
    handle: str
    points: NDArray[np.float64]


class SplitDrawing(NamedTuple):
    """Drawing, taken apart.

    Parameters
    ----------
    rest : str
        The drawing without its plain entities.
    plain : list of PlainEntity
        In the order of the file.
    numbers : dict of str to int
        Places of the entities of the rest among the entities of the file, by their handles.
    """

    rest: str
    plain: list[PlainEntity]
    numbers: dict[str, int]


def split_drawing(text: str) -> SplitDrawing:
    """Take the plain entities out of the text of a drawing.

    Parameters
    ----------
    text : str
        Tags in two lines each, which end with ``\\n``.

    Raises
    ------
    ValueError
        The text is no list of tags, or a coordinate is no number.
    """
    lines = text.rstrip("\n\0\x1a ").split("\n")
    codes = np.array(list(map(int, lines[::2])), np.int64)
    values = lines[1::2]
    if len(values) != len(codes) or not len(codes) or codes.min() < 0 or codes.max() >= _HIGHEST:
        raise ValueError("the text has other lines than tags")
    starts = _entities(codes, values)
    if not len(starts):
        return SplitDrawing(text, [], {})
    groups = _Groups(codes, values, starts)
    plain, taken = groups.plain()
    kept = np.ones(len(codes), np.bool_)
    for number in taken.tolist():
        kept[starts[number] : starts[number + 1]] = False
    numbers = {handle: at for at, handle in enumerate(groups.handles) if handle}
    return SplitDrawing("\n".join(compress(lines, np.repeat(kept, 2).tolist())) + "\n", plain, numbers)


def _entities(codes: _Places, values: Sequence[str]) -> _Places:
    """Return where the entities begin that are in no block, and at last where they end; nothing without any."""
    begins = np.flatnonzero(codes == _START)
    names = [values[at].strip() for at in begins.tolist()]
    for number, name in enumerate(names):
        at = int(begins[number])
        if name == "SECTION" and codes[at + 1 : at + 2] == _NAME and values[at + 1].strip() == "ENTITIES":
            end = names.index("ENDSEC", number)
            return begins[number + 1 : end + 1]
    return begins[:0]


class _Groups:
    """Tags of entities.

    Parameters
    ----------
    codes : (n,) int array
    values : sequence of str
        Of the whole drawing.
    starts : (m + 1,) int array
        Tags with which the entities begin; at last the one behind them.
    """

    def __init__(self, codes: _Places, values: Sequence[str], starts: _Places) -> None:
        first, last = int(starts[0]), int(starts[-1])
        self._codes, self._values = codes[first:last], values[first:last]
        self._starts = starts[:-1] - first
        self._of = np.repeat(np.arange(len(self._starts)), np.diff(starts))
        self._kinds = [self._values[at].strip() for at in self._starts.tolist()]
        self.handles = self._firsts(_HANDLE)

    def plain(self) -> tuple[list[PlainEntity], _Places]:
        """Return the plain entities, and their numbers."""
        kinds, whole, tilted = np.array(self._kinds), self._in_model(), self._any(_AXIS)
        chosen = {kind: (kinds == kind) & whole & self._every(codes) for kind, codes in _CODES.items()}
        for code in (_X, _Y, _X_END, _Y_END):
            chosen[_LINE] &= (self._count(code) == 1) & ~tilted
        corners = self._count(_X)
        chosen[_POLYLINE] &= (corners > 1) & (self._count(_Y) == corners) & ~tilted & ~self._any({_BULGE: 0.0})
        points = self._lines(chosen[_LINE]) | self._polylines(chosen[_POLYLINE])
        taken = np.flatnonzero(np.logical_or.reduce(list(chosen.values())))
        layers, none = self._firsts(_LAYER), np.empty((0, 2))
        found = [
            PlainEntity(at, self._kinds[at], layers[at] or "0", self.handles[at], points.get(at, none))
            for at in taken.tolist()
        ]
        return found, taken

    def _count(self, code: int) -> _Places:
        return np.bincount(self._of[self._codes == code], minlength=len(self._starts))

    def _every(self, allowed: Iterable[int]) -> _Mask:
        """Return which entities have only allowed codes."""
        known = np.zeros(_HIGHEST, np.bool_)
        known[list(allowed)] = True
        return np.asarray(np.logical_and.reduceat(known[self._codes], self._starts))

    def _firsts(self, code: int) -> list[str]:
        """Return the first value of a code of each entity; empty without one."""
        found = [""] * len(self._starts)
        tags = np.flatnonzero(self._codes == code)[::-1]
        for entity, tag in zip(self._of[tags].tolist(), tags.tolist(), strict=True):
            found[entity] = self._values[tag].strip()
        return found

    def _in_model(self) -> _Mask:
        """Return which entities are in no layout but the model, and on one layer at most."""
        others = [tag for tag in np.flatnonzero(self._codes == _MODEL).tolist() if self._values[tag].strip() != "Model"]
        inside = self._count(_LAYER) <= 1
        inside[self._of[others]] = False
        return inside

    def _any(self, usual: Mapping[int, float]) -> _Mask:
        """Return which entities have another value than the usual one at any of some codes."""
        found = np.zeros(len(self._starts), np.bool_)
        for code, value in usual.items():
            tags = np.flatnonzero(self._codes == code).tolist()
            found[self._of[[tag for tag in tags if float(self._values[tag]) != value]]] = True
        return found

    def _numbers(self, tags: _Mask) -> NDArray[np.float64]:
        return np.array(list(map(float, compress(self._values, tags.tolist()))), np.float64)

    def _lines(self, chosen: _Mask) -> dict[int, NDArray[np.float64]]:
        inside = chosen[self._of]
        ends = [self._numbers(inside & (self._codes == code)) for code in (_X, _Y, _X_END, _Y_END)]
        return dict(zip(np.flatnonzero(chosen).tolist(), np.stack(ends, axis=1).reshape(-1, 2, 2), strict=True))

    def _polylines(self, chosen: _Mask) -> dict[int, NDArray[np.float64]]:
        inside = chosen[self._of]
        corners = np.stack([self._numbers(inside & (self._codes == code)) for code in (_X, _Y)], axis=1)
        numbers = np.flatnonzero(chosen).tolist()
        flags, counts = self._firsts(_FLAGS), self._count(_X)
        found, end = {}, 0
        for number in numbers:
            begin, end = end, end + int(counts[number])
            part = corners[begin:end]
            is_closed = int(flags[number] or 0) & _CLOSED and (part[0] != part[-1]).any()
            found[number] = np.concatenate((part, part[:1])) if is_closed else part
        return found
