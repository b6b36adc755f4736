"""Files of robots, page by page."""

import asyncio
import base64

import pytest

from endpoints.resources.robot_files import PosegraphReader, whole_file
from ppaas.errors import Unavailable
from ppaas.messages.slam_toolbox import GetPoseGraphResponse

PAGE = 4


class Clone:
    """Clone that has the pages of its newest file only, as `ppaas.nodes.file_pages.FilePages`."""

    def __init__(self):
        self.file, self.files = b"", 0

    async def map(self, _user, _robot, offset):
        if offset == 0:
            self.files += 1
            self.file = bytes([self.files]) * 10
        await asyncio.sleep(0)
        page = base64.b64encode(self.file[offset : offset + PAGE]).decode()
        return GetPoseGraphResponse(page, len(self.file))


async def test_readers_of_one_map_get_a_file_each():
    reader, clone = PosegraphReader(), Clone()
    files = await asyncio.gather(*(reader.fetch(clone, "ann", "tb1") for _ in range(3)))
    assert [file for file, _ in files] == [bytes([number]) * 10 for number in (1, 2, 3)]


async def test_page_that_is_not_base64_is_an_error_of_the_robot():
    with pytest.raises(Unavailable, match="not base64"):
        await whole_file(GetPoseGraphResponse("é", 9), None, "tb1")
