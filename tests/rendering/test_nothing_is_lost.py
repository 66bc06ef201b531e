"""What a file that is named as the checkpoint of a new render may hold."""

import numpy as np
import pytest

from alight.core.errors import OutputError
from alight.films import Film, archive
from alight.rendering.checkpoints.checkpoint import check_nothing_is_lost


def film(path):
    Film(8, 8).save(path)


def newer(path):
    archive.write_archive(path, {"x": 1}, {"y": np.zeros(3)})


def damaged(path):
    film(path)
    path.write_bytes(path.read_bytes()[:-1])


def text(path):
    path.write_text("camera: {type: pinhole}", "utf-8")


@pytest.mark.parametrize(
    ("make", "said"),
    [(film, "is a film, not a checkpoint"), (newer, "has format 2"), (damaged, "is damaged"),
     (text, "is not a film or checkpoint")],
)  # fmt: skip
def test_what_is_no_checkpoint_is_kept(tmp_path, monkeypatch, make, said):
    path = tmp_path / "box.alight"
    with monkeypatch.context() as patch:
        if make is newer:
            patch.setattr(archive, "VERSION", archive.VERSION + 1)
        make(path)
    told = ""
    try:
        check_nothing_is_lost(path)
    except OutputError as error:
        told = str(error)
    assert said in told
    assert told.endswith("; remove it first, or choose another name")


def test_nothing_is_lost_where_nothing_is(tmp_path):
    check_nothing_is_lost(tmp_path / "new.alight")
    # As somebody makes it who needs a name that nobody else has.
    (tmp_path / "empty.alight").touch()
    check_nothing_is_lost(tmp_path / "empty.alight")
