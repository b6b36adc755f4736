"""Pages of a file, which a client of a service gets one after the other."""

import base64

from ppaas.errors import InvalidInput

PAGE = 3 << 18
"""Size of a page [bytes]; 1 MiB in base64."""


class FilePages:
    """Serves the newest file page by page, and forgets it after its end.

    Parameters
    ----------
    name : str
        Name of the data in the file, in texts.
    """

    def __init__(self, name: str) -> None:
        self._name, self._file = name, b""

    def use(self, file: bytes) -> None:
        """Serve another file."""
        self._file = file

    def forget(self) -> None:
        """Forget the file."""
        self._file = b""

    def page(self, offset: int) -> tuple[str, int]:
        """Return the page at an offset [bytes] in base64, empty at the end of the file, and the size of the file.

        Raises
        ------
        InvalidInput
            The offset is negative or beyond the end of the file.
        """
        size = len(self._file)
        if not 0 <= offset <= size:
            raise InvalidInput(f"the file of the {self._name} has {size} bytes, not {offset}: begin at 0")
        page = self._file[offset : offset + PAGE]
        if offset == size:
            self.forget()
        return base64.b64encode(page).decode(), size
