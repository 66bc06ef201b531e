"""Every message of a wrong scene, word for word, beside the scene that causes it.

The snapshot is ``messages.txt``; run with ALIGHT_UPDATE_SNAPSHOTS=1 to write it anew, then read the
difference.
"""

import os
import struct
from pathlib import Path

import pytest

from alight.core.errors import AlightError, SceneError
from alight.formats import load, loads
from alight.formats.loading import changed
from alight.scene import Scene

SNAPSHOT = Path(__file__).with_name("messages.txt")
UPDATE = bool(os.environ.get("ALIGHT_UPDATE_SNAPSHOTS"))
CAMERA = "alight: 1\ncamera: {type: pinhole}\nenvironment: constant\n"

SCENES = {
    "misspelt-top-level-key": "alight: 1\ncamra: {type: pinhole}\n",
    "no-version": "camera: pinhole\n",
    "wrong-version": "alight: 2\ncamera: {}\n",
    "not-a-mapping": "[1, 2]\n",
    "empty-file": "",
    "not-yaml": "alight: 1\nnodes: {a: [1, 2}\n",
    "tab": "alight: 1\n\tnodes: {}\n",
    "control-character": "alight: 1\nnodes: \x01\n",
    "anchor": "alight: 1\nbsdfs: {a: &x {type: null}, b: *x}\n",
    "tag": "alight: 1\nbsdfs: {a: !!python/object:os.system {}}\n",
    "two-documents": "alight: 1\n---\nalight: 1\n",
    "too-deep": "alight: 1\nnodes: " + "[" * 80 + "\n",
    "key-is-a-list": "alight: 1\n[1, 2]: 3\n",
    "key-given-twice": CAMERA + "bsdfs:\n  a: {type: mirror}\n  a: {type: mirror}\n",
    "bad-name": CAMERA + "bsdfs: {a/b: {type: mirror}, '': {type: mirror}}\n",
    "misspelt-key": CAMERA + "bsdfs:\n  white: {type: diffuse, reflectence: 0.5}\n",
    "wrong-light": CAMERA + "nodes: {a: {light: {type: spot, cutoff_angle: 200}}}\n",
    "type-for-a-name": CAMERA + "nodes: {a: {shape: sphere, bsdf: diffuse}}\n",
    "misspelt-light": CAMERA + "nodes: {a: {light: {type: spott}}}\n",
    "misspelt-type": CAMERA + "bsdfs:\n  white:\n    type: difuse\n",
    "unlike-any-type": CAMERA + "nodes: {a: {shape: xyzzy}}\n",
    "no-type": CAMERA + "bsdfs: {white: {reflectance: 0.5}}\n",
    "type-is-a-number": CAMERA + "bsdfs: {white: {type: 3}}\n",
    "misspelt-choice": CAMERA + "integrator: {type: path, light_sampling: miss}\n",
    "out-of-range": CAMERA + "bsdfs:\n  white: {type: diffuse, reflectance: [1.2, 0.5, -1]}\n",
    "one-number-out-of-range": CAMERA + "bsdfs:\n  white: {type: diffuse, reflectance: 7}\n",
    "wrong-count": CAMERA + "bsdfs:\n  white: {type: diffuse, reflectance: [1, 0.5]}\n",
    "text-for-number": CAMERA + 'nodes: {a: {shape: {type: sphere, radius: "2"}}}\n',
    "truth-for-number": CAMERA + "nodes: {a: {shape: {type: sphere, radius: true}}}\n",
    "number-for-truth": CAMERA + "nodes: {a: {shape: {type: disk, flip_normals: 1}}}\n",
    "number-for-name": CAMERA + "nodes: {a: {shape: disk, bsdf: 3}}\n",
    "not-finite": CAMERA + "nodes: {a: {shape: {type: sphere, radius: 1e999}}}\n",
    "not-a-number": CAMERA + "nodes: {a: {light: {type: area, radiance: .nan}, shape: sphere}}\n",
    "too-large": CAMERA + "nodes: {a: {shape: {type: sphere, radius: 1e30}}}\n",
    "too-small": CAMERA + "nodes: {a: {shape: {type: sphere, radius: 1e-30}}}\n",
    "not-positive": CAMERA + "nodes: {a: {shape: {type: sphere, radius: 0}}}\n",
    "negative-light": CAMERA + "nodes: {a: {light: {type: point, intensity: -1}}}\n",
    "fraction-for-whole": CAMERA + "integrator: {type: path, max_depth: 2.5}\n",
    "zero-depth": CAMERA + "integrator: {type: path, max_depth: 0}\n",
    "endless-paths": CAMERA + "integrator: {type: path, russian_roulette: none}\n",
    "unknown-medium": CAMERA + "bsdfs: {g: {type: dielectric, int_ior: watr}}\n",
    "grid-without-end": CAMERA + "media: {m: {type: grid, values: [[[1, 2]]], sigma_t: 1e6}}\n",
    "unknown-metal": CAMERA + "bsdfs: {g: {type: conductor, metal: god}}\n",
    "half-a-metal": CAMERA + "bsdfs: {g: {type: conductor, eta: 1}}\n",
    "metal-and-eta": CAMERA + "bsdfs: {g: {type: conductor, metal: gold, eta: 1, k: 1}}\n",
    "body-unseen": CAMERA
    + "integrator: direct\nnodes: {a: {shape: sphere, bsdf: {type: subsurface}}}\n",
    "body-with-holes": CAMERA
    + "bsdfs: {w: {type: subsurface}}\nnodes: {a: {shape: sphere, bsdf: {type: mask, bsdf: w}}}\n",
    "body-that-is-filled": CAMERA
    + "nodes: {a: {shape: sphere, bsdf: {type: subsurface}, interior: {type: homogeneous}}}\n",
    "media-unseen": CAMERA + "medium: {type: homogeneous}\nintegrator: path\n",
    "misspelt-medium": CAMERA
    + "media: {fog: {type: homogeneous}}\nnodes: {a: {shape: sphere, interior: fgo}}\n",
    "medium-without-border": CAMERA + "nodes: {a: {interior: {type: homogeneous}}}\n",
    "medium-named-vacuum": CAMERA + "media: {vacuum: {type: homogeneous}}\n",
    "medium-given-two-ways": CAMERA + "medium: {type: homogeneous, sigma_t: 1, sigma_s: 1}\n",
    "medium-too-forward": CAMERA
    + "medium: {type: homogeneous, phase: {type: henyey_greenstein, g: 1}}\n",
    "grid-without-values": CAMERA + "medium: {type: grid}\n",
    "grid-of-a-missing-file": CAMERA + "medium: {type: grid, file: smoke.npy}\n",
    "grid-of-an-unknown-cloud": CAMERA + 'medium: {type: grid, file: "builtin:clowd"}\n',
    "grid-not-square": CAMERA + "medium: {type: grid, values: [[[1, 2], [3]]]}\n",
    "grid-negative": CAMERA + "medium: {type: grid, values: [[[1, -2]]]}\n",
    "grid-upside-down": CAMERA + "medium: {type: grid, values: [[[1]]], high: [1, -1, 1]}\n",
    "phong-makes-energy": CAMERA + "bsdfs: {p: {type: phong, diffuse: 0.8, specular: 0.3}}\n",
    "phong-makes-energy-by-name": CAMERA
    + "textures: {t: {type: constant, color: 0.9}}\n"
    + "bsdfs: {p: {type: phong, diffuse: t, specular: 0.3}}\n",
    "too-many-levels-by-name": CAMERA
    + "bsdfs:\n  b0: {type: diffuse}\n"
    + "".join(f"  b{i}: {{type: normal_map, bsdf: b{i - 1}}}\n" for i in range(1, 66)),
    "too-many-instances-of-instances": CAMERA
    + "nodes: {a: {instance: p65}}\nprototypes:\n  p0: {shape: sphere}\n"
    + "".join(f"  p{i}: {{instance: p{i - 1}}}\n" for i in range(1, 66)),
    "too-many-surroundings": CAMERA
    + "nodes:\n"
    + "".join(f"  p{i}: {{light: {{type: portal}}}}\n" for i in range(65)),
    "two-sided-glass": CAMERA + "bsdfs: {g: {type: two_sided, bsdf: {type: dielectric}}}\n",
    "two-sided-glass-by-name": CAMERA
    + "bsdfs: {g: {type: dielectric}, t: {type: two_sided, bsdf: g}}\n",
    "two-sided-itself": CAMERA + "bsdfs: {t: {type: two_sided, bsdf: t}}\n",
    "two-sided-glass-in-a-blend": CAMERA
    + "bsdfs: {g: {type: dielectric}, b: {type: blend, bsdfs: [mirror, g]}, mirror: {type: mirror},"
    + " t: {type: two_sided, bsdf: b}, m: {type: two_sided, bsdf: {type: mask, bsdf: b}}}\n",
    "two-sided-holes": CAMERA
    + "bsdfs: {h: {type: mask}, t: {type: two_sided, bsdf: h, back: {type: mirror}},"
    + " u: {type: two_sided, back: {type: mask}}}\n",
    "two-sided-back": CAMERA
    + "bsdfs: {g: {type: dielectric}, t: {type: two_sided, back: g},"
    + " u: {type: two_sided, back: t}, v: {type: two_sided, back: w}}\n",
    "cyclic-bsdfs": CAMERA
    + "bsdfs: {a: {type: mask, bsdf: b}, b: {type: blend, bsdfs: [c, a]}, c: {type: mirror}}\n",
    "too-many-leaves": CAMERA
    + "bsdfs:\n  b0: {type: mirror}\n"
    + "".join(f"  b{i}: {{type: blend, bsdfs: [b{i - 1}, b{i - 1}]}}\n" for i in range(1, 60))
    + "nodes: {a: {shape: disk, bsdf: {type: mask, bsdf: b5}}}\n",
    "null-without-quotes": CAMERA + "nodes: {a: {shape: disk, bsdf: {type: null}}}\n",
    "blend-of-one": CAMERA + "bsdfs: {b: {type: blend, bsdfs: [{type: mirror}]}}\n",
    "blend-of-a-number": CAMERA + "bsdfs: {b: {type: blend, bsdfs: [{type: mirror}, 3]}}\n",
    "blend-of-unknown": CAMERA + "bsdfs: {b: {type: blend, bsdfs: [b1, {type: miror}]}}\n",
    "blend-of-nothing": CAMERA + "bsdfs: {b: {type: blend, weight: 1.5, bsdfs: [null, {}]}}\n",
    "mask-too-opaque": CAMERA + "bsdfs: {m: {type: mask, opacity: 2, bsdf: 5}}\n",
    "plastic-out-of-range": CAMERA
    + "bsdfs: {p: {type: rough_plastic, alpha: 0, int_ior: glas, nonlinear: 1}}\n",
    "unknown-bsdf": CAMERA
    + "bsdfs: {white: {type: mirror}}\nnodes: {a: {shape: cube, bsdf: whit}}\n",
    "unknown-texture": CAMERA + "bsdfs: {white: {type: mirror, reflectance: oak}}\n",
    "unknown-prototype": CAMERA + "prototypes: {tree: {}}\nnodes: {a: {instance: tre}}\n",
    "cyclic-prototypes": CAMERA
    + "prototypes: {a: {instance: b}, b: {children: {c: {instance: a}}}}\n",
    "too-many-instances": CAMERA
    + "prototypes:\n  p0: {shape: cube}\n"
    + "".join(
        f"  p{i}: {{children: {{"
        + ", ".join(f"c{k}: {{instance: p{i - 1}}}" for k in range(10))
        + "}}\n"
        for i in range(1, 9)
    )
    + "nodes: {a: {instance: p8}}\n",
    "camera-in-prototype": CAMERA + "prototypes: {a: {camera: pinhole}}\n",
    "no-camera": "alight: 1\nenvironment: constant\n",
    "unknown-camera-node": "alight: 1\ncamera: rig/hed\nnodes: {rig: {children: {head: "
    "{camera: pinhole}}}}\n",
    "node-without-camera": "alight: 1\ncamera: rig\nnodes: {rig: {}}\n",
    "field-of-view": "alight: 1\ncamera: {type: pinhole, fov: 180}\n",
    "point-light-on-shape": CAMERA + "nodes: {a: {shape: cube, light: point}}\n",
    "area-light-without-shape": CAMERA + "nodes: {a: {light: area}}\n",
    "area-light-on-plane": CAMERA + "nodes: {a: {shape: plane, light: area}}\n",
    "environment-on-shape": "alight: 1\ncamera: {}\nnodes: {a: {shape: cube, light: constant}}\n",
    "environment-in-prototype": CAMERA + "prototypes: {a: {light: constant}}\n",
    "environment-stretched": "alight: 1\ncamera: {}\n"
    "nodes: {a: {light: constant, transform: {scale: [1, 1, 2]}}}\n",
    "environment-without-map": "alight: 1\ncamera: {}\nenvironment: environment\n",
    "environment-of-bad-texels": "alight: 1\ncamera: {}\n"
    "environment: {type: environment, pixels: [[1, -2], [0, 1]], rotate: up, sampling: all}\n",
    "spot-that-fades-inwards": CAMERA
    + "nodes: {a: {light: {type: spot, cutoff_angle: 10, beam_width: 20}}}\n"
    + "prototypes: {p: {light: {type: spot, cutoff_angle: 190}}}\n",
    "light-with-unknown-texture": CAMERA
    + "nodes: {a: {shape: disk, light: {type: area, radiance: lamp}}}\n",
    "point-light-as-environment": "alight: 1\ncamera: {}\nenvironment: point\n",
    "zero-area-light": CAMERA
    + "nodes: {a: {light: area, shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [2, 0, 0]], "
    + "faces: [[0, 1, 2]]}}}\n",
    "singular-matrix": CAMERA + "nodes: {a: {shape: disk, transform: {scale: [1, 1, 0]}}}\n",
    "singular-camera": "alight: 1\ncamera: {type: pinhole, transform: {scale: "
    "0}}\nenvironment: constant\n",
    "too-large-together": CAMERA + "nodes: {a: {transform: {scale: 1e10}, children: {b: {shape: "
    "cube, transform: {scale: 1e10}}}}}\n",
    "look-along-up": "alight: 1\ncamera: {transform: {look_at: {origin: [0, 0, "
    "0], target: [0, 3, 0]}}}\n",
    "look-nowhere": "alight: 1\ncamera: {transform: {look_at: {origin: [1, 0, "
    "0], target: [1, 0, 0]}}}\n",
    "two-steps-in-one": CAMERA + "nodes: {a: {transform: {scale: 1, translate: [0, 0, 0]}}}\n",
    "unknown-step": CAMERA
    + "nodes: {a: {transform: [{scale: 1}, {rotat: {axis: y, angle: 3}}]}}\n",
    "step-without-angle": CAMERA + "nodes: {a: {transform: {rotate: {axis: y}}}}\n",
    "step-is-no-mapping": CAMERA + "nodes: {a: {transform: [3]}}\n",
    "axis-without-length": CAMERA
    + "nodes: {a: {transform: {rotate: {axis: [0, 0, 0], angle: 3}}}}\n",
    "matrix-rows": CAMERA + "nodes: {a: {transform: {matrix: [[1, 0, 0], [0, 1, 0]]}}}\n",
    "matrix-last-row": CAMERA + "nodes: {a: {transform: {matrix: [[1, 0, 0, 0], [0, 1, 0, "
    "0], [0, 0, 1, 0], [0, 0, 1, 1]]}}}\n",
    "node-is-a-number": CAMERA + "nodes: {a: 3}\n",
    "nodes-is-a-list": CAMERA + "nodes: [3]\n",
    "zero-size": CAMERA + "film: {size: [0, 512]}\n",
    "absurd-size": CAMERA + "film: {size: [1000000, 1000000]}\n",
    "crop-outside": CAMERA + "film: {size: [64, 64], crop: [60, 0, 10, 10]}\n",
    "filter-radius": CAMERA + "film: {filter: {type: box, radius: 0}}\n",
    "strata": CAMERA + "sampler: {type: stratified, strata: 0}\n",
    "mesh-without-anything": CAMERA + "nodes: {a: {shape: mesh}}\n",
    "mesh-file-and-arrays": CAMERA + "nodes: {a: {shape: {type: mesh, file: a.ply, uvs: []}}}\n",
    "mesh-file-missing": CAMERA + "nodes: {a: {shape: {type: mesh, file: empt.ply}}}\n",
    "mesh-folder-missing": CAMERA + "nodes: {a: {shape: {type: mesh, file: no/such.ply}}}\n",
    "mesh-file-kind": CAMERA + "nodes: {a: {shape: {type: mesh, file: a.fbx}}}\n",
    "mesh-empty": CAMERA + "nodes: {a: {shape: {type: mesh, vertices: [], faces: []}}}\n",
    "mesh-no-faces": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0, 0]], faces: []}}}\n",
    "mesh-index": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0, 0]], faces: [[0, 0, 1]]}}}\n",
    "mesh-columns": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0]], faces: [[0, 0, 0]]}}}\n",
    "mesh-ragged": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0], [1]], faces: [[0, 0, 0]]}}}\n",
    "mesh-normals-count": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
    + "faces: [[0, 1, 2]], normals: [[0, 0, 1]]}}}\n",
    "mesh-colors": CAMERA
    + "nodes: {a: {shape: {type: mesh, vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
    + "faces: [[0, 1, 2]], colors: [[0, 0, 1], [0, 0, 1], [0, 0, 2]]}}}\n",
    "many-at-once": "alight: 1\ncamera: {type: pinhole, fov: 0}\nbsdfs:\n"
    "  white: {type: diffuse, reflectance: [1.2, 0, 0]}\n  red: {type: difuse}\nnodes:\n"
    "  floor: {shape: plane, bsdf: wite, transform: {scale: 0}}\n  lamp: {light: area}\n",
}

HEADER = (
    b"ply\nformat ascii 1.0\nelement vertex 3\n"
    b"property float x\nproperty float y\nproperty float z\n"
)
FACES = b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
TRIANGLE = b"0 0 0\n1 0 0\n0 1 0\n"

MESHES = {
    "empty.ply": b"",
    "no-header-end.ply": b"ply\nformat ascii 1.0\n",
    "no-format.ply": b"ply\nend_header\n",
    "format.ply": b"ply\nformat ascii_be 1.0\nend_header\n",
    "line.ply": HEADER + b"nonsense here\n" + FACES,
    "type.ply": b"ply\nformat ascii 1.0\nelement vertex 3\nproperty flot x\nend_header\n",
    "claims.ply": b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n",
    "truncated.ply": HEADER + FACES + b"0 0 0\n1 0 0\n",
    "truncated-face.ply": HEADER + FACES + TRIANGLE + b"3 0 1",
    "truncated-binary.ply": HEADER.replace(b"ascii", b"binary_little_endian") + FACES + b"\0" * 30,
    "truncated-binary-face.ply": HEADER.replace(b"ascii", b"binary_little_endian")
    + FACES
    + b"\0" * 36
    + b"\x03\0\0",
    "word.ply": HEADER + FACES + b"0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n",
    "nan.ply": HEADER + FACES + b"0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n",
    "index.ply": HEADER + FACES + TRIANGLE + b"3 0 1 3\n",
    "no-vertices.ply": b"ply\nformat ascii 1.0\nelement face 0\nend_header\n",
    "no-faces.ply": HEADER + b"end_header\n" + TRIANGLE,
    "no-xyz.ply": b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
    "huge.ply": HEADER.replace(b"ascii", b"binary_little_endian")
    + FACES
    + struct.pack("<9f", *[1e30] * 9)
    + struct.pack("<B3i", 3, 0, 1, 2),
    "empty.obj": b"# nothing\n",
    "short.obj": b"v 0 0 0\nv 1 0\n",
    "word.obj": b"v 0 0 zero\n",
    "corner.obj": b"v 0 0 0\nf 1 a 1\n",
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n",
    "zero-index.obj": b"v 0 0 0\nf 0 1 1\n",
    "empty.stl": b"",
    "no.stl": b"\0" * 90,
    "short.stl": b"x" * 80 + struct.pack("<I", 4_000_000_000) + b"\0" * 50,
    "no-facet.stl": b"solid nothing\nendsolid nothing\n",
    "two.stl": b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\n",
    "cut.stl": b"solid\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n",
    "word.stl": b"solid\nfacet\nvertex 0 zero 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n",
    "nan.stl": b"solid\nfacet\nvertex 0 nan 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n",
    "nan.obj": b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n",
}


def read_snapshot():
    """Split the snapshot file into name -> message."""
    if not SNAPSHOT.exists():
        return {}
    blocks = SNAPSHOT.read_text("utf-8").split("=== ")[1:]
    return {
        head.strip(): body.rstrip("\n") for head, _, body in (b.partition("\n") for b in blocks)
    }


def all_messages(folder):
    """Produce every message, by name."""
    messages = {}
    for name, data in MESHES.items():
        (folder / name).write_bytes(data)
        text = CAMERA + f"nodes:\n  a:\n    shape: {{type: mesh, file: {name}}}\n"
        messages[f"file {name}"] = message_of(text, folder)
    for name, text in SCENES.items():
        messages[name] = message_of(text, folder)
    return messages


def message_of(text, folder):
    with pytest.raises(SceneError) as caught:
        loads(text, "scene.yaml", folder)
    return str(caught.value).replace(str(folder), "FOLDER")


@pytest.fixture(scope="module")
def messages(tmp_path_factory):
    found = all_messages(tmp_path_factory.mktemp("meshes"))
    if UPDATE:
        text = "".join(f"=== {name}\n{message}\n\n" for name, message in found.items())
        SNAPSHOT.write_text(text.rstrip("\n") + "\n", "utf-8")
    return found


@pytest.mark.parametrize("name", [*SCENES, *(f"file {name}" for name in MESHES)])
def test_message_is_as_recorded(messages, name):
    assert messages[name] == read_snapshot().get(name)


def test_snapshot_holds_nothing_else():
    assert set(read_snapshot()) == {*SCENES, *(f"file {name}" for name in MESHES)}


@pytest.mark.parametrize("name", sorted(SCENES))
def test_every_issue_has_a_place_and_says_more_than_a_type_name(messages, name):
    for line in messages[name].splitlines():
        assert line.startswith(("scene.yaml:", "  "))
        assert "Error" not in line
        assert "Traceback" not in line


def test_files_that_cannot_be_read(tmp_path):
    cases = {
        "cornel-box": 'did you mean "cornell-box"?',
        str(tmp_path): "is a folder",
        str(tmp_path / "scene.yml"): 'did you mean "',
        str(tmp_path / "scene.blend"): "must be a scene file (.yaml, .yml, .json, .xml, ",
        str(tmp_path / "latin.yaml"): "must be UTF-8 text, got byte 0xe4 at 2",
    }
    (tmp_path / "scenes.yml").write_text("alight: 1")
    (tmp_path / "scene.blend").write_text("alight: 1")
    (tmp_path / "latin.yaml").write_bytes(b"a:\xe4")
    for name, message in cases.items():
        with pytest.raises(SceneError) as caught:
            load(name)
        assert message in str(caught.value)


@pytest.mark.parametrize(
    ("radius", "message"), [(10**400, "must be at most 1e.15"), (-(10**400), "must be at most")]
)
def test_whole_numbers_beyond_all_floats_are_refused(radius, message):
    with pytest.raises(SceneError, match=message):
        load({"nodes": {"ball": {"shape": {"type": "sphere", "radius": radius}}}})


def test_data_that_holds_itself_is_refused():
    node: dict = {}
    node["children"] = {"again": node}
    with pytest.raises(SceneError, match="nested too deeply, or holds itself"):
        load({"nodes": {"node": node}})


@pytest.mark.parametrize("changes", [None, 3, {3: 4}, {b"camera.fov": 3}, [3]])
def test_changes_that_are_none_are_refused(changes):
    with pytest.raises(AlightError, match=r"must (map key paths|be path\.to\.key)|are texts"):
        changed(Scene(), changes)


def test_too_large_files_are_refused_unread(tmp_path):
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.truncate(65 * 2**20)
    with pytest.raises(SceneError, match="at most 64 MB, got 65 MB"):
        load(path)


def test_what_rests_hides_nothing_that_moves():
    moves = "transform: {keyframes: [{time: 0}, {time: 1, translate: [1, 0, 0]}]}"
    nodes = f"{{a: {{shape: sphere}}, m: {{shape: plane, {moves}}}, z: {{shape: sphere}}}}"
    with pytest.raises(SceneError, match="a plane is infinite and cannot move"):
        loads(f"alight: 1\ncamera: {{type: pinhole, shutter: [0, 1]}}\nnodes: {nodes}\n")
