"""Curves, the shapes of pbrt 3, lenses, and lights with a picture."""

import math

import numpy as np
import pytest

from alight.formats.pbrt.lenses import MILLIMETRE, lens_of
from alight.formats.pbrt.octahedral import to_sphere
from alight.formats.pbrt.strands import PIECES, SIDES
from alight.lights.ies import LUMENS
from alight.scene.flatten import flatten
from tests.formats.pbrt.reading import HEAD, messages, node, read, read_old

STRAIGHT = '"point3 P" [0 0 0  0 0 1  0 0 2  0 0 3] "float width0" 0.4 "float width1" 0.2'


def shape_of(body, **options):
    return node(read(body, **options)).shape


def ends_of(curves):
    """Points of a curve, and radii, at the ends of its segments: Bezier's go through them."""
    return curves.points[::3], curves.radii[::3]


def test_a_straight_curve_has_its_widths():
    curves = shape_of(f'Shape "curve" {STRAIGHT}')
    assert curves.basis == "bezier"
    np.testing.assert_allclose(curves.points[:, 2], [0.0, 1.0, 2.0, 3.0])
    np.testing.assert_allclose(curves.radii, 0.5 * (0.4 - 0.2 * np.arange(4) / 3.0), rtol=1e-6)


def test_a_curve_that_moves_is_a_cone_of_triangles_with_its_widths():
    body = f'ActiveTransform EndTime Translate 1 0 0 ActiveTransform All Shape "curve" {STRAIGHT}'
    mesh = shape_of(body)
    assert len(mesh.faces) == 2 * SIDES * PIECES
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(np.hypot(x, y), 0.5 * (0.4 - 0.2 * z / 3.0), atol=1e-6)
    np.testing.assert_allclose(mesh.normals[:, 2], 0.0, atol=1e-6)
    # Normals and corners point outwards.
    assert ((mesh.normals[:, :2] * mesh.vertices[:, :2]).sum(axis=1) > 0.0).all()
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    across, middle = np.cross(b - a, c - a), (a + b + c) / 3.0
    assert ((across * middle)[:, :2].sum(axis=1) > 0.0).all()
    assert not mesh.flip_normals


def test_curves_shine_from_their_one_side_with_their_area():
    lamp = 'AreaLightSource "diffuse" "float power" 3 "bool twosided" true'
    scene = read(f'{lamp} Shape "curve" {STRAIGHT}')
    # A cone of 3 m whose radius is 0.15 m in the middle.
    radiance = node(scene).light.radiance
    cylinder = 'Shape "cylinder" "float radius" 0.15 "float zmin" 0 "float zmax" 3'
    same = read(f"{lamp} {cylinder}").nodes
    assert len(same) == 2
    for other in same.values():
        wider = np.array(radiance) * math.hypot(1.0, 0.1 / 3.0)
        np.testing.assert_allclose(wider, other.light.radiance, rtol=1e-4)


def test_curves_in_an_object_that_moves_stand_still():
    moving = "ActiveTransform EndTime Translate 1 0 0 ActiveTransform All"
    inner = f'ObjectBegin "a" Shape "curve" {STRAIGHT} ObjectEnd'
    outer = 'ObjectBegin "b" ObjectInstance "a" ObjectEnd'
    scene = read(f'{inner} {outer} {moving} ObjectInstance "b"')
    flatten(scene)
    assert any("moves: it stands where it is" in text for text in scene.warnings)


def test_curves_bound_no_media():
    medium = 'MakeNamedMedium "fog" "string type" "homogeneous"'
    head = f'Integrator "volpath"\n{HEAD}'
    scene = read(f'{medium} MediumInterface "" "fog" Shape "curve" {STRAIGHT}', head)
    assert node(scene).interior is None
    assert node(scene).exterior is None
    assert any("plays no part at curves" in text for text in scene.warnings)


def test_bases_and_degrees_are_the_same_cubic():
    # A parabola: as a quadratic, as the cubic of the same shape, and as a B-spline.
    quadratic = '"integer degree" 2 "point3 P" [0 0 0  1 2 0  2 0 0]'
    cubic = f'"point3 P" [0 0 0  {2 / 3} {4 / 3} 0  {4 / 3} {4 / 3} 0  2 0 0]'
    spline = '"integer degree" 2 "string basis" "bspline" "point3 P" [-1 -2 0  1 2 0  3 -2 0]'
    found = [shape_of(f'Shape "curve" "float width" 0.01 {p}') for p in (quadratic, cubic, spline)]
    for curves in found:
        np.testing.assert_allclose(curves.points, found[1].points, atol=1e-6)
        np.testing.assert_allclose(curves.radii, 0.005)


def test_cubic_splines_are_the_cubics_that_their_points_blossom_to():
    # Marsden: uniform B-splines with the coefficients k^3 - k add up to x^3, those with k to x.
    points = " ".join(f"{k} {k**3 - k} 0" for k in range(-1, 4))
    curves = shape_of(
        f'Shape "curve" "float width" 1e-3 "string basis" "bspline" "point3 P" [{points}]'
    )
    middle, _ = ends_of(curves)
    np.testing.assert_allclose(middle[:, 0], [0.0, 1.0, 2.0], atol=1e-6)
    np.testing.assert_allclose(middle[:, 1], [0.0, 1.0, 8.0], atol=1e-6)


def test_ribbons_face_as_their_normals_say():
    body = f'Shape "curve" "string type" "ribbon" {STRAIGHT} "normal N" [0 1 0  0 1 0]'
    mesh = shape_of(body)
    np.testing.assert_allclose(mesh.vertices[:, 1], 0.0, atol=1e-7)
    np.testing.assert_allclose(mesh.normals, np.tile([0, 1, 0], (len(mesh.vertices), 1)))
    np.testing.assert_allclose(np.abs(mesh.vertices[:2, 0]), 0.2, rtol=1e-6)
    # Their triangles face there, too.
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    assert (np.cross(b - a, c - a)[:, 1] > 0.0).all()
    assert "needs 2 normals" in messages(body.replace("0 1 0  0 1 0", "0 1 0"))[0]


def test_curves_of_one_material_are_one_shape():
    curve = f'Shape "curve" {STRAIGHT}'
    body = f'{curve}\n{curve}\nMaterial "diffuse"\nShape "sphere"\n{curve}\nTranslate 1 0 0 {curve}'
    scene = read(body)
    strands = [n.shape for n in scene.nodes.values() if n.shape.type_name() == "curves"]
    assert sorted(len(shape.points) for shape in strands) == [4, 4, 8]
    assert [4, 4] in [shape.counts.tolist() for shape in strands]
    body = f'ObjectBegin "o"\n{curve}\nObjectEnd\nObjectInstance "o"\n{curve}'
    scene = read(body)
    assert len(scene.prototypes["o"].children) == 1
    assert len([n for n in scene.nodes.values() if n.shape is not None]) == 1
    points = messages('Shape "curve" "point3 P" [0 0 0 1 1 1]')
    assert "needs other numbers of points" in points[0]


def outwards(mesh, inner):
    """Whether all normals turn away from points inside."""
    return bool(((mesh.vertices - inner(mesh.vertices)) * mesh.normals).sum(axis=1).min() > 0.0)


def test_surfaces_of_pbrt_3_are_where_their_formulas_are():
    cone = node(read_old('Shape "cone" "float radius" 2 "float height" 3')).shape
    x, y, z = cone.vertices.T
    np.testing.assert_allclose(np.hypot(x, y), 2.0 * (1.0 - z / 3.0), atol=1e-5)
    np.testing.assert_allclose(cone.normals[:, 2], 2.0 / math.hypot(2.0, 3.0), atol=1e-4)
    bowl = node(read_old('Shape "paraboloid" "float radius" 2 "float zmax" 4')).shape
    x, y, z = bowl.vertices.T
    np.testing.assert_allclose(x * x + y * y, z, atol=1e-5)
    assert outwards(bowl, lambda p: p * [0, 0, 1] + [0, 0, 1e-3])
    waist = '"point p1" [1 0 -1] "point p2" [1 1 1]'
    body = node(read_old(f'Shape "hyperboloid" {waist}')).shape
    x, y, z = body.vertices.T
    t = 0.5 * (z + 1.0)
    np.testing.assert_allclose(x * x + y * y, 1.0 + t * t, atol=1e-5)


def test_height_fields_are_exact():
    heights = "0 1 2  3 4 5"
    body = f'Shape "heightfield" "integer nu" 3 "integer nv" 2 "float Pz" [{heights}]'
    mesh = node(read_old(body)).shape
    assert mesh.vertices[1].tolist() == [0.5, 0.0, 1.0]
    assert mesh.vertices[5].tolist() == [1.0, 1.0, 5.0]
    assert len(mesh.faces) == 4
    assert mesh.normals is None
    [message] = messages(body.replace("4 5", "4"))
    assert "nu * nv = 6 heights, got 5" in message


def test_nurbs_show_what_their_control_points_say():
    # A quarter of a circle is a rational curve of order 3; drawn out along z.
    root = math.sqrt(0.5)
    low = f"1 0 0 1  {root} {root} 0 {root}  0 1 0 1"
    net = f"{low}  1 0 2 1  {root} {root} {2 * root} {root}  0 1 2 1"
    body = (
        'Shape "nurbs" "integer nu" 3 "integer uorder" 3 "float uknots" [0 0 0 1 1 1]\n'
        f'"integer nv" 2 "integer vorder" 2 "float vknots" [0 0 1 1] "float Pw" [{net}]'
    )
    mesh = node(read_old(body)).shape
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(np.hypot(x, y), 1.0, atol=1e-6)
    assert (z.min(), z.max()) == (0.0, 2.0)
    np.testing.assert_allclose(
        np.abs((mesh.normals * mesh.vertices)[:, :2].sum(axis=1)), 1.0, atol=1e-4
    )
    assert "uknots" in messages(body.replace("[0 0 0 1 1 1]", "[0 0 1 1 1]"))[0]


# ---------------------------------------------------------------- lenses


def test_lenses_have_the_focal_length_of_their_formulas():
    # One thick lens: the lensmaker's equation.
    n, r1, r2, d = 1.5, 40.0, -60.0, 10.0
    surfaces = np.array([[r1, d, n, 30.0], [r2, 50.0, 1.0, 30.0]])
    meant = 1.0 / ((n - 1.0) * (1.0 / r1 - 1.0 / r2 + (n - 1.0) * d / (n * r1 * r2)))
    lens = lens_of(surfaces, 8.0)
    assert lens.focal_length == pytest.approx(MILLIMETRE * meant)
    # A stop in front of everything is seen as it is.
    stopped = np.vstack([[0.0, 5.0, 0.0, 30.0], surfaces])
    assert lens_of(stopped, 8.0).radius == pytest.approx(MILLIMETRE * 4.0)
    # Behind a thin lens, at a quarter of its focal length, it looks larger by 4/3.
    thin = np.array([[50.0, 0.0, 1.5, 0.0], [-50.0, 12.5, 1.0, 0.0], [0.0, 40.0, 0.0, 30.0]])
    assert lens_of(thin, 8.0).radius == pytest.approx(MILLIMETRE * 4.0 * 4.0 / 3.0)
    with pytest.raises(ValueError, match="bring light together"):
        lens_of(surfaces * [-1.0, 1.0, 1.0, 1.0], 8.0)


def test_realistic_cameras_see_and_expose_as_their_lens(tmp_path):
    (tmp_path / "lens.dat").write_text("# thin, f = 50 mm\n50 0 1.5 30\n-50 50 1 30 # behind\n")
    camera = (
        'Camera "realistic" "string lensfile" "lens.dat" "float aperturediameter" 10\n'
        '"float focusdistance" 2\nFilm "rgb" "integer xresolution" 40 "integer yresolution" 30'
    )
    scene = read('LightSource "point" "rgb I" [1 1 1]', f"{camera}\n", tmp_path)
    lens = scene.camera.camera
    image = 0.05 * 2.0 / (2.0 - 0.05)
    height = 0.035 * 30 / 50
    assert lens.type_name() == "thin_lens"
    assert lens.fov == pytest.approx(math.degrees(2.0 * math.atan(0.5 * height / image)))
    assert (lens.aperture_radius, lens.focus_distance) == (pytest.approx(0.005), 2.0)
    exposure = math.pi * (0.005 / image) ** 2
    np.testing.assert_allclose(node_with_light(scene).intensity, exposure, rtol=1e-6)
    assert any("one thin lens of 50 mm" in text for text in scene.warnings)
    for content, meant in (("1 2 3", "4 numbers"), ("a b c d", "must hold numbers")):
        (tmp_path / "lens.dat").write_text(content)
        assert meant in messages("", f"{camera}\n", folder=tmp_path)[0]


def node_with_light(scene):
    [light] = [node.light for node in scene.nodes.values() if node.light is not None]
    return light


# ---------------------------------------------------------------- lights with a picture


def test_projections_stand_upright_and_have_their_power(tmp_path):
    texels = np.zeros((2, 4, 3), np.float32)
    texels[0, 0] = 1.0, 0.5, 0.25
    np.save(tmp_path / "slide.npy", texels)
    body = 'LightSource "projection" "string filename" "slide.npy" "float fov" 60'
    light = node(read(body, folder=tmp_path)).light
    # The upper left texel, towards -x and +y of the light: our left edge is towards +x.
    np.testing.assert_array_equal(light.pixels.texels[0, 3], [1.0, 0.5, 0.25])
    assert math.tan(math.radians(0.5 * light.fov)) == pytest.approx(
        2.0 * math.tan(math.radians(30.0))
    )
    assert light.evenness == "intensity"
    # All that it shines with, counted in another way: over a fine grid of directions.
    np.save(tmp_path / "slide.npy", np.ones((64, 128, 3), np.float32))
    lit = read(f'{body} "float power" 5', folder=tmp_path)
    light = node(lit).light
    t = math.tan(math.radians(30.0))
    solid_angle = 4.0 * math.asin(2.0 * t * t / math.sqrt((1 + 4 * t * t) * (1 + t * t)))
    np.testing.assert_allclose(light.scale, 5.0 / solid_angle, rtol=1e-3)
    assert "needs" in messages('LightSource "projection"')[0]


def test_goniometric_lights_shine_as_their_map(tmp_path):
    n = 256
    middle = (np.arange(n) + 0.5) / n
    directions = to_sphere(np.stack(np.meshgrid(middle, middle), axis=-1))
    # In the map z is up; the light's up is y.
    np.save(tmp_path / "map.npy", (1.5 + directions[..., 2]).astype(np.float32))
    body = 'LightSource "goniometric" "string filename" "map.npy" "rgb I" [2 2 2]'
    light = node(read(body, folder=tmp_path)).light
    candela, vertical = np.array(light.candela), np.radians(light.vertical_angles)
    phi = np.radians(light.horizontal_angles)[:, None]
    up = np.sin(vertical) * np.sin(phi)
    np.testing.assert_allclose(candela / LUMENS, 1.5 + up, atol=0.01)
    np.testing.assert_allclose(light.scale, 2.0, rtol=1e-6)
    power = node(read(f'{body} "float power" 3', folder=tmp_path)).light
    np.testing.assert_allclose(power.scale, 2.0 * 3.0 / (4.0 * math.pi * 1.5), rtol=1e-3)
    # Latitude and longitude in pbrt 3.
    rows = np.cos((np.arange(n) + 0.5) * np.pi / n)[:, None] * np.ones(2 * n)
    np.save(tmp_path / "map.npy", (1.5 + rows).astype(np.float32))
    old = 'LightSource "goniometric" "string mapname" "map.npy"'
    light = node(read_old(old, folder=tmp_path)).light
    np.testing.assert_allclose(np.array(light.candela) / LUMENS, 1.5 + up, atol=0.01)
