"""Files of kept code."""

from lanewise.kept_files import lost, write_kept


def test_what_cannot_be_kept_leaves_nothing_behind(tmp_path):
    lost()
    (tmp_path / "here").mkdir()
    write_kept(tmp_path / "here", {}, b"code")
    assert isinstance(lost(), OSError)
    assert [path.name for path in tmp_path.iterdir()] == ["here"]
