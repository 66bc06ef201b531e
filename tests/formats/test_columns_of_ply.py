"""PLY files: what is not read of them is told."""

import pytest

from alight.formats import mesh_scene

HEAD = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
{vertex}element face 1
property list uchar int vertex_indices
{face}end_header
"""
BODY = "0 0 0{of_vertex}\n1 0 0{of_vertex}\n0 1 0{of_vertex}\n3 0 1 2{of_face}\n"


@pytest.mark.parametrize(
    ("vertex", "face", "warned", "noted"),
    [
        ("", "", 0, 0),
        ("red green blue", "", 0, 0),
        ("red green blue alpha", "", 1, 0),
        ("", "red green blue", 0, 0),
        ("red green blue", "red green blue", 1, 0),
        ("", "red green blue alpha", 1, 0),
        ("nx ny nz quality", "", 0, 1),
        ("", "flags", 0, 1),
    ],
)
def test_columns_that_are_left_out_are_told(vertex, face, warned, noted):
    names = {"vertex": vertex.split(), "face": face.split()}
    declared = {key: "".join(f"property uchar {n}\n" for n in names[key]) for key in names}
    values = {f"of_{key}": " 1" * len(names[key]) for key in names}
    found = mesh_scene.parse_ply(
        (HEAD.format(**declared) + BODY.format(**values)).encode(), "a.ply"
    )
    assert len([w for w in found.warnings if "of element" in w]) == warned
    assert len([n for n in found.notes if "of element" in n]) == noted
    assert all(found.warnings[0].count(name) == 1 for name in names["face"][3:] if warned)
