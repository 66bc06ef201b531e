"""Files that are packed or not: as large as they may be, and no larger."""

import gzip

import pytest

from alight.formats.reading.packed import content_of, text_of
from alight.formats.reading.reach import UnreadableError

MOST = 2**20


@pytest.mark.parametrize("name", ["a.txt", "a.txt.gz"])
@pytest.mark.parametrize("size", [0, MOST - 1, MOST, MOST + 1, 3 * MOST])
def test_files_may_have_so_many_bytes_once_they_are_unpacked(name, size, tmp_path):
    data = bytes(65 + i % 26 for i in range(26)) * (size // 26 + 1)
    data, path = data[:size], tmp_path / name
    path.write_bytes(gzip.compress(data) if name.endswith("gz") else data)
    try:
        found = content_of(path, MOST)
    except UnreadableError as error:
        assert size > MOST
        assert "must be at most 1 MB" in str(error)
    else:
        assert size <= MOST
        assert found == data
        assert text_of(path, MOST) == data.decode()
