"""Loop's subdivision and the folded sphere of pbrt's maps, against closed forms."""

import numpy as np
import pytest

from alight.formats.pbrt.octahedral import to_latitude_longitude, to_sphere, to_square
from alight.lights.environment import Environment
from alight.meshes.loop import NotManifoldError, subdivide
from alight.shapes.mesh import Mesh
from tests.formats.pbrt.reading import messages, node, read, read_old

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
FACES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)


def plane(side: int) -> tuple[np.ndarray, np.ndarray]:
    """A flat square of triangles, counter-clockwise seen from +z."""
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], axis=1)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    lower = np.stack([first, first + side, first + side + 1], axis=1)
    return points, np.concatenate([lower, np.stack([first, first + side + 1, first + 1], axis=1)])


def test_limit_does_not_depend_on_the_number_of_levels():
    rng = np.random.default_rng(3)
    shapes = [(OCTAHEDRON + 0.3 * rng.standard_normal((6, 3)), FACES)]
    points, faces = plane(5)
    # With borders, corners of two kinds, and a height that is no plane's.
    shapes.append((points + rng.standard_normal(points.shape) * [0.1, 0.1, 0.5], faces))
    for points, faces in shapes:
        limits = [subdivide(points, faces, levels) for levels in range(4)]
        count = len(points)
        row, column = np.divmod(np.arange(count), 5)
        inside = (row % 4 > 0) & (column % 4 > 0) if len(faces) > 8 else row >= 0
        for levels, (vertices, normals, refined) in enumerate(limits):
            assert len(refined) == len(faces) * 4**levels
            np.testing.assert_allclose(vertices[:count], limits[0][0], atol=1e-12)
            # Normals are those of the limit once no neighbour's neighbour is on a border.
            first, unit = limits[1][1][:count], normals[:count]
            sizes = np.linalg.norm(unit, axis=1) * np.linalg.norm(first, axis=1)
            cosine = (unit * first).sum(axis=1)[inside] / sizes[inside]
            assert levels == 0 or np.abs(cosine - 1.0).max() < 1e-12


def test_limit_of_an_octahedron():
    vertices, normals, faces = subdivide(OCTAHEDRON, FACES, 3)
    # One ring of four: gamma = 1 / (4 + 3 / (8 beta)) = 1/8 with beta = 3/32.
    np.testing.assert_allclose(vertices[0], [0.5, 0, 0], atol=1e-12)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(unit[:6], OCTAHEDRON, atol=1e-12)
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    across = np.cross(b - a, c - a)
    assert ((across * unit[faces[:, 0]]).sum(axis=1) > 0.0).all()
    # The surface is smooth: its normals are those of the fine triangles.
    flat = across / np.linalg.norm(across, axis=1, keepdims=True)
    assert (flat * unit[faces[:, 0]]).sum(axis=1).min() > 0.9


def test_flat_meshes_stay_flat_up_to_their_border():
    points, faces = plane(5)
    for levels in (0, 2):
        vertices, normals, _ = subdivide(points, faces, levels)
        assert np.abs(vertices[:, 2]).max() == 0.0
        unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        np.testing.assert_allclose(unit, np.tile([0, 0, 1.0], (len(unit), 1)), atol=1e-12)


def test_triangles_that_are_no_surface():
    three = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    with pytest.raises(NotManifoldError, match="more than two triangles"):
        subdivide(OCTAHEDRON, three, 1)
    with pytest.raises(NotManifoldError, match="different ways"):
        subdivide(OCTAHEDRON, np.array([[0, 1, 2], [0, 1, 3]]), 1)
    with pytest.raises(NotManifoldError, match="same corner twice"):
        subdivide(OCTAHEDRON, np.array([[0, 0, 2]]), 1)


def test_subdivision_surfaces_in_files():
    points = " ".join(f"{x:g}" for x in OCTAHEDRON.ravel())
    indices = " ".join(map(str, FACES.ravel()))
    body = f'Shape "loopsubdiv" "point3 P" [{points}] "integer indices" [{indices}]'
    mesh = node(read(f'{body} "integer levels" 2')).shape
    assert isinstance(mesh, Mesh)
    assert mesh.faces is not None
    assert len(mesh.faces) == 8 * 16
    assert mesh.flip_normals
    [message] = messages(f'{body} "integer levels" 30')
    assert "levels must be in [0, 12]" in message
    [message] = messages(body.replace("[0 1 2", "[0 1 99"))
    assert "indices must be in [0, 5], got 99" in message


def test_folded_sphere_is_a_bijection_that_keeps_areas():
    rng = np.random.default_rng(1)
    points = rng.random((10_000, 2))
    directions = to_sphere(points)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(to_square(directions), points, atol=1e-7)
    # The middle is +z, the corners are -z, the middles of the sides the four other axes.
    known = {(0.5, 0.5): (0, 0, 1), (0, 0): (0, 0, -1), (1, 0.5): (1, 0, 0), (0.5, 1): (0, 1, 0)}
    for point, direction in known.items():
        np.testing.assert_allclose(to_sphere(np.array(point)), direction, atol=1e-12)
    # Any cap of height h has the share h / 2.
    for axis in np.eye(3):
        assert (directions @ axis > 0.4).mean() == pytest.approx(0.3, abs=0.015)
    # d omega = 4 pi du dv, from finite differences.
    h = 1e-6
    u, v = np.array([h, 0.0]), np.array([0.0, h])
    inner = points[(np.abs(points - 0.5) > 1e-3).all(axis=1)]
    sides = [(to_sphere(inner + d) - to_sphere(inner - d)) / (2 * h) for d in (u, v)]
    density = np.linalg.norm(np.cross(*sides), axis=1)
    assert np.median(np.abs(density / (4 * np.pi) - 1.0)) < 1e-6


def test_resampled_map_shows_what_the_square_does():
    n = 256
    middle = (np.arange(n) + 0.5) / n
    u, v = np.meshgrid(middle, middle)
    directions = to_sphere(np.stack([u, v], axis=-1))
    found = to_latitude_longitude((directions + 1.0).astype(np.float32))
    assert found.shape == (n + 1, 2 * n, 3)
    azimuth, theta = (np.arange(2 * n) + 0.5) * np.pi / n, np.arange(n + 1) * np.pi / n
    sine = np.sin(theta)[:, None]
    # The light's x, y and z of our map's directions.
    x, y = sine * np.sin(azimuth), sine * np.cos(azimuth)
    z = np.broadcast_to(np.cos(theta)[:, None], x.shape)
    assert np.abs(found - 1.0 - np.stack([x, y, z], axis=-1)).max() < 0.0065


def places(light: Environment, matrix: np.ndarray) -> dict[str, np.ndarray]:
    """Radiance of a map along the axes of the world."""
    from alight.textures.images import Image

    assert isinstance(light.pixels, Image)
    texels = light.pixels.texels
    height, width = texels.shape[:2]
    found = {}
    for name, axis in {"x": 0, "y": 1, "z": 2}.items():
        for sign, text in ((1.0, "+"), (-1.0, "-")):
            d = np.linalg.inv(matrix[:3, :3]) @ (sign * np.eye(3)[axis])
            theta = np.arccos(np.clip(d[1], -1, 1))
            turn = np.arctan2(d[0], -d[2]) % (2 * np.pi)
            column = int(turn * width / (2 * np.pi)) % width
            found[text + name] = texels[round(theta * (height - 1) / np.pi), column]
    return found


def test_maps_of_pbrt_4_stand_as_the_file_says(tmp_path):
    n = 64
    middle = (np.arange(n) + 0.5) / n
    directions = to_sphere(np.stack(np.meshgrid(middle, middle), axis=-1))
    np.save(tmp_path / "map.npy", (directions + 1.0).astype(np.float32))
    body = 'LightSource "infinite" "string filename" "map.npy"'
    scene = read(body, folder=tmp_path)
    found = places(node(scene).light, node(scene).transform.matrix)
    for name, sign, axis in (("+x", 1, 0), ("-y", -1, 1), ("+z", 1, 2), ("-z", -1, 2)):
        np.testing.assert_allclose(found[name] - 1.0, sign * np.eye(3)[axis], atol=0.06)
    # Turned by 90 degrees about z, the map's +x looks along +y.
    scene = read(f"Rotate 90 0 0 1 {body}", folder=tmp_path)
    found = places(node(scene).light, node(scene).transform.matrix)
    np.testing.assert_allclose(found["+y"] - 1.0, [1, 0, 0], atol=0.06)
    np.save(tmp_path / "flat.npy", np.ones((4, 9, 3), np.float32))
    [message] = messages(body.replace("map", "flat"), folder=tmp_path)
    assert "must be a square" in message


def test_maps_of_pbrt_3_stand_as_the_file_says(tmp_path):
    n = 64
    phi, theta = (np.arange(2 * n) + 0.5) * np.pi / n, (np.arange(n) + 0.5) * np.pi / n
    sine = np.sin(theta)[:, None]
    z = np.broadcast_to(np.cos(theta)[:, None], (n, 2 * n))
    texels = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)
    np.save(tmp_path / "map.npy", (texels + 1.0).astype(np.float32))
    scene = read_old('LightSource "infinite" "string mapname" "map.npy"', folder=tmp_path)
    light = node(scene).light
    from alight.scene.files import Files
    from alight.scene.images import loaded

    found = places(loaded(light, Files(tmp_path)), node(scene).transform.matrix)
    for name, sign, axis in (("+x", 1, 0), ("-x", -1, 0), ("+y", 1, 1), ("+z", 1, 2)):
        np.testing.assert_allclose(found[name] - 1.0, sign * np.eye(3)[axis], atol=0.06)
