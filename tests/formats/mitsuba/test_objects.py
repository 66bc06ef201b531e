"""Every kind of object: what a file says becomes the description that was meant."""

import numpy as np
import pytest

from alight.shapes.mesh import Mesh
from tests.formats.mitsuba.reading import messages, native, node, read, read_bsdf

GREY = "{type: diffuse, reflectance: 0.5}"

PHONG = "{type: phong, diffuse: 0.5, specular: 0.2, exponent: 30}"
BSDFS = {
    'type="diffuse"': ("", GREY),
    'type="conductor"': ("", "{type: mirror}"),
    'type="dielectric"': ("", "{type: dielectric, int_ior: 1.5046, ext_ior: 1.000277}"),
    'type="thindielectric"': (
        '<string name="int_ior" value="diamond"/><float name="ext_ior" value="1"/>',
        "{type: thin_dielectric, int_ior: 2.419, ext_ior: 1}",
    ),
    'type="roughdielectric"': (
        ('<string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>'
        '<string name="int_ior" value="water"/><string name="ext_ior" value="vacuum"/>'),
        "{type: rough_dielectric, distribution: ggx, alpha: 0.3, int_ior: 1.333, ext_ior: 1}",
    ),
    'type="roughconductor"': (
        ('<rgb name="eta" value="1,2,3"/><rgb name="k" value="4,5,6"/>'
        '<float name="alpha_u" value="0.2"/><float name="alpha_v" value="0.4"/>'),
        ("{type: rough_conductor, distribution: beckmann, eta: [1, 2, 3], k: [4, 5, 6], "
        "alpha_u: 0.2, alpha_v: 0.4}"),
    ),
    'type="plastic"': (
        ('<rgb name="diffuse_reflectance" value="0.1,0.2,0.3"/>'
        '<boolean name="nonlinear" value="true"/>'),
        ("{type: plastic, diffuse_reflectance: [0.1, 0.2, 0.3], nonlinear: true, int_ior: 1.49, "
        "ext_ior: 1.000277}"),
    ),
    'type="roughplastic"': (
        '<float name="alpha" value="0.25"/><rgb name="specular_reflectance" value="0.5"/>',
        ("{type: rough_plastic, distribution: beckmann, alpha: 0.25, diffuse_reflectance: 0.5, "
        "specular_reflectance: 0.5, int_ior: 1.49, ext_ior: 1.000277}"),
    ),
    'type="mask"': (
        '<float name="opacity" value="0.25"/><bsdf type="diffuse"/>',
        f"{{type: mask, opacity: 0.25, bsdf: {GREY}}}",
    ),
    'type="blendbsdf"': (
        '<float name="weight" value="0.25"/><bsdf type="diffuse"/><bsdf type="null"/>',
        f"{{type: blend, weight: 0.25, bsdfs: [{GREY}, {{type: 'null'}}]}}",
    ),
    'type="twosided"': ('<bsdf type="diffuse"/>', f"{{type: two_sided, bsdf: {GREY}}}"),
    'type="phong"': (
        '<rgb name="diffuse_reflectance" value="0.3"/><float name="exponent" value="20"/>',
        "{type: phong, diffuse: 0.3, specular: 0.2, exponent: 20}",
    ),
    'type="null"': ("", "{type: 'null'}"),
}  # fmt: skip


def test_the_second_of_two_sides_is_the_back():
    found = read_bsdf('<bsdf type="diffuse"/><bsdf type="phong"/>', 'type="twosided"')
    assert found == native("bsdfs", f"{{type: two_sided, bsdf: {GREY}, back: {PHONG}}}")


@pytest.mark.parametrize("kind", BSDFS)
def test_bsdf(kind):
    body, meant = BSDFS[kind]
    assert read_bsdf(body, kind) == native("bsdfs", meant)


# As Mitsuba 3.9.1 has them in its variant scalar_rgb.
METALS = {
    "Au": ([0.1430, 0.3753, 1.4420], [3.9830, 2.3856, 1.6034]),
    "Al": ([1.6575, 0.8804, 0.5212], [9.2238, 6.2695, 4.8370]),
    "Cu": ([0.2010, 0.9237, 1.1022], [3.9133, 2.4531, 2.1421]),
}


@pytest.mark.parametrize("name", METALS)
def test_metals_by_name(name):
    found = read_bsdf(f'<string name="material" value="{name}"/>', 'type="conductor"')
    np.testing.assert_allclose(found.eta, METALS[name][0], atol=1e-4)
    np.testing.assert_allclose(found.k, METALS[name][1], atol=1e-4)


def test_index_outside_of_a_conductor_is_one_of_old_files():
    body = '<rgb name="eta" value="2"/><rgb name="k" value="3"/><float name="extEta" value="1.6"/>'
    found = read_bsdf(body, 'type="conductor"', "0.6.0")
    assert found.eta == pytest.approx((1.25,) * 3)
    assert found.k == pytest.approx((1.875,) * 3)


# As Mitsuba 3.9.1 reduces them in its variant scalar_rgb.
REFLECTANCES = {
    'value="400:0.1, 500:0.2, 600:0.6, 700:0.5"': (0.66958, 0.36814, 0.12000),
    'value="0.3"': (0.3, 0.3, 0.3),
    'type="uniform"><float name="value" value="0.4"/></spectrum': (0.4, 0.4, 0.4),
}
RADIANCES = {
    'value="400:0, 500:8, 600:15.6, 700:18.4"': (20.71084, 10.85463, 2.77115),
    'value="2"': (2.40959, 1.89658, 1.81783),
    'type="d65"><float name="scale" value="3"/></spectrum': (3.0, 3.0, 3.0),
}


def spectrum(name, text):
    """``<spectrum>`` from the tables above, closed as it needs to be."""
    return f'<spectrum name="{name}" {text}' + (">" if text.endswith("</spectrum") else "/>")


@pytest.mark.parametrize("text", REFLECTANCES)
def test_spectra_of_surfaces(text):
    found = read_bsdf(spectrum("reflectance", text), 'type="diffuse"')
    assert found.reflectance == pytest.approx(REFLECTANCES[text], rel=5e-4)


@pytest.mark.parametrize("text", RADIANCES)
def test_spectra_of_lights(text):
    scene = read(f'<emitter type="constant">{spectrum("radiance", text)}</emitter>')
    assert scene.environment.radiance == pytest.approx(RADIANCES[text], rel=5e-4)


def test_temperatures():
    def radiance(body, version):
        return np.array(
            read(f'<emitter type="constant">{body}</emitter>', version).environment.radiance
        )

    body = '<spectrum type="blackbody" name="radiance"><float name="temperature" value="{}"/>{}'
    hot = radiance(body.format("6504", "</spectrum>"), "3.0.0")
    cold = radiance(body.format("3000", "</spectrum>"), "3.0.0")
    # Planck's law at 555 nm; the colour of 3000 K is orange, that of 6504 K nearly white.
    planck = [1.191043e-16 / 555e-9**5 / np.expm1(1.438777e-2 / (555e-9 * t)) for t in (6504, 3000)]
    luminance = np.array([0.212671, 0.715160, 0.072169])
    assert hot @ luminance / (cold @ luminance) == pytest.approx(planck[0] / planck[1], rel=0.06)
    assert hot.max() / hot.min() < 1.15
    assert cold[0] > 1.5 * cold[1] > 3.0 * cold[2]
    old = '<blackbody name="radiance" temperature="3000K" scale="2"/>'
    np.testing.assert_allclose(radiance(old, "0.6.0"), 2.0 * cold)


TEXTURES = {
    '<string name="filename" value="letters.png"/>': (
        "{type: bitmap, file: letters.png, to_uv: [{scale: [1, -1]}, {translate: [0, 1]}]}"
    ),
    '<string name="filename" value="letters.png"/><boolean name="raw" value="true"/>'
    '<string name="filter_type" value="nearest"/><string name="wrap_mode" value="clamp"/>': (
        "{type: bitmap, file: letters.png, color_space: linear, interpolation: nearest, "
        "wrap: clamp, to_uv: [{scale: [1, -1]}, {translate: [0, 1]}]}"
    ),
}


@pytest.mark.parametrize("body", TEXTURES)
def test_bitmap(body):
    found = read_bsdf(
        f'<texture type="bitmap" name="reflectance">{body}</texture>', 'type="diffuse"'
    )
    assert found.reflectance == native("textures", TEXTURES[body])


def test_checkerboard_has_two_squares_a_unit():
    body = """<texture type="checkerboard" name="reflectance"><rgb name="color0" value="0.1"/>
    <transform name="to_uv"><scale x="3" y="5"/></transform></texture>"""
    found = read_bsdf(body, 'type="diffuse"').reflectance
    meant = "{type: checkerboard, color0: 0.1, color1: 0.2, scale: 2, to_uv: [{scale: [3, 5]}]}"
    assert found == native("textures", meant)


def test_vertex_colors_must_be_there():
    texture = """<texture type="mesh_attribute" name="reflectance">
    <string name="name" value="{}"/></texture>"""
    shape = '<shape type="{}">{}<bsdf type="diffuse">{}</bsdf></shape>'
    tent = '<string name="filename" value="tent.ply"/>'
    found = node(read(shape.format("ply", tent, texture.format("vertex_color"))))
    assert found.bsdf.reflectance == native("textures", "{type: vertex_color}")
    np.testing.assert_allclose(found.shape.colors[0], [0.9, 0.1, 0.1], atol=1e-6)
    square = '<string name="filename" value="square.obj"/>'
    assert (
        "has no vertex colours"
        in messages(shape.format("obj", square, texture.format("vertex_color")))[0]
    )
    assert "vertex_heat" in messages(shape.format("ply", tent, texture.format("vertex_heat")))[0]


# ---------------------------------------------------------------- shapes


def shape(body, kind, **options):
    return node(read(f'<shape type="{kind}">{body}</shape>', **options)).shape


@pytest.mark.parametrize(
    ("kind", "body", "meant"),
    [
        ("rectangle", "", "{type: rectangle}"),
        ("disk", '<boolean name="flip_normals" value="true"/>', "{type: disk, flip_normals: true}"),
        ("cube", "", "{type: cube}"),
        (
            "sphere",
            '<point name="center" x="1" y="2" z="3"/><float name="radius" value="2"/>',
            "{type: sphere, center: [1, 2, 3], radius: 2}",
        ),
        (
            "cylinder",
            '<point name="p1" x="0" y="2" z="0"/><float name="radius" value="0.5"/>',
            "{type: cylinder, p1: [0, 2, 0], radius: 0.5}",
        ),
        # Rendered as a lamp by Mitsuba: a mirror leaves the outer side of a cylinder outside.
        ("cylinder", ('<boolean name="flip_normals" value="true"/>'
         '<transform name="to_world"><scale x="-1"/></transform>'),
         "{type: cylinder, flip_normals: true}"),
        ("cylinder", '<transform name="to_world"><scale value="-1"/></transform>',
         "{type: cylinder}"),
        # A mirror turns a sphere inside out, as it does in Mitsuba.
        ("sphere", '<transform name="to_world"><scale x="-1"/></transform>',
         "{type: sphere, flip_normals: true}"),
    ],
)  # fmt: skip
def test_shapes_with_a_formula(kind, body, meant):
    assert shape(body, kind) == native("nodes", f"{{shape: {meant}}}").shape


def test_meshes_of_all_formats():
    square = shape('<string name="filename" value="square.obj"/>', "obj")
    other = shape('<string name="filename" value="squares.serialized"/>'
                  '<integer name="shape_index" value="1"/>', "serialized")  # fmt: skip
    tent = shape('<string name="filename" value="tent.ply"/>', "ply")
    assert isinstance(square, Mesh)
    np.testing.assert_allclose(other.vertices, square.vertices)
    # OBJ files count v from below, serialized ones from above.
    np.testing.assert_allclose(other.uvs[:, 1], 1.0 - square.uvs[:, 1])
    assert len(tent.faces) == 3
    small = shape('<string name="filename" value="squares.serialized"/>', "serialized")
    np.testing.assert_allclose(small.vertices, 0.5 * square.vertices)
    flat = shape('<string name="filename" value="tent.ply"/>'
                 '<boolean name="face_normals" value="true"/>', "ply")  # fmt: skip
    assert flat.normals is None
    assert tent.normals is not None
    assert (
        "shape_index must be in [0, 1]"
        in messages(
            '<shape type="serialized"><string name="filename" value="squares.serialized"/>'
            '<integer name="shape_index" value="2"/></shape>'
        )[0]
    )


def test_instances_share_a_prototype():
    group = '<shape type="shapegroup" id="g"><shape type="sphere"/></shape>'
    one = """<shape type="instance"><ref id="g"/>
    <transform name="to_world"><translate x="{}"/></transform></shape>"""
    scene = read(group + one.format(1) + one.format(2))
    assert list(scene.prototypes) == ["g"]
    places = [each.transform.matrix[0, 3] for each in scene.nodes.values()]
    assert places == [1.0, 2.0]
    assert {each.instance for each in scene.nodes.values()} == {"g"}
    assert "refer to one shapegroup" in messages('<shape type="instance"/>')[0]


def test_transforms_are_applied_in_the_order_of_the_file():
    body = """<shape type="sphere"><transform name="to_world"><scale value="2"/>
    <rotate z="1" angle="90"/><translate x="1" y="2" z="3"/></transform></shape>"""
    matrix = node(read(body)).transform.matrix
    np.testing.assert_allclose(matrix @ [1, 0, 0, 1], [1, 4, 3, 1], atol=1e-6)
    body = """<shape type="sphere"><transform name="to_world">
    <matrix value="0 -2 0 1  2 0 0 2  0 0 2 3  0 0 0 1"/></transform></shape>"""
    np.testing.assert_allclose(node(read(body)).transform.matrix, matrix, atol=1e-6)


# ---------------------------------------------------------------- emitters


def test_lights():
    found = node(read('<emitter type="point"><point name="position" x="1" y="2" z="3"/></emitter>'))
    assert found.light == native("nodes", "{light: {type: point}}").light
    assert found.transform.matrix[:3, 3].tolist() == [1, 2, 3]
    body = '<emitter type="directional"><vector name="direction" x="0" y="-2" z="0"/></emitter>'
    found = node(read(body))
    # Light travels along +z of its node.
    np.testing.assert_allclose(found.transform.matrix[:3, 2], [0, -1, 0], atol=1e-6)
    body = """<emitter type="spot"><float name="cutoff_angle" value="40"/>
    <transform name="to_world">
    <lookat origin="0,0,0" target="3,0,0" up="0,1,0"/></transform></emitter>"""
    found = node(read(body))
    assert found.light.cutoff_angle == 40.0
    np.testing.assert_allclose(found.transform.matrix[:3, 2], [1, 0, 0], atol=1e-6)
    found = node(read('<shape type="disk"><emitter type="area"/></shape>'))
    assert found.light == native("nodes", "{shape: disk, light: {type: area}}").light
    assert found.bsdf.reflectance == (0.0, 0.0, 0.0)
    body = '<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>'
    assert node(read(body)).light.file == "sky.exr"


def test_emitters_around_the_scene_add_up():
    picture = '<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>'
    sun = '<emitter type="sun"><vector name="sun_direction" x="0" y="1" z="1"/></emitter>'
    scene = read(f'<emitter type="constant"/>{picture}{sun}<emitter type="constant"/>')
    assert scene.environment.type_name() == "constant"
    kinds = [found.light.type_name() for found in scene.nodes.values() if found.light]
    assert kinds == ["environment", "sun", "constant"]


# ---------------------------------------------------------------- cameras, films and the like


def test_cameras():
    look = (
        '<transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>'
    )
    found = read(f'<sensor type="perspective">{look}<float name="fov" value="30"/></sensor>')
    assert found.camera.camera.fov == 30.0
    assert found.camera.camera.fov_axis == "x"
    # Ours look along -z of their node.
    np.testing.assert_allclose(found.camera.transform.matrix[:3, 2], [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(found.camera.transform.matrix[:3, 3], [0, 0, 5])
    lens = '<float name="aperture_radius" value="0.2"/><float name="focus_distance" value="4"/>'
    found = read(f'<sensor type="thinlens">{look}{lens}<float name="fov" value="30"/></sensor>')
    assert found.camera.camera.focus_distance == 4.0
    film = """<film type="hdrfilm"><integer name="width" value="80"/>
    <integer name="height" value="40"/></film>"""
    found = read(f'<sensor type="orthographic">{look}{film}</sensor>')
    # Mitsuba's is 2 wide.
    assert found.camera.camera.height == 1.0
    # 50 mm on the diagonal of a 35 mm film unless a file says otherwise.
    found = read('<sensor type="perspective"/>').camera.camera
    assert (found.fov, found.fov_axis) == (pytest.approx(46.7930), "diagonal")


@pytest.mark.parametrize(
    ("kind", "meant"),
    [
        ('type="box"', {"type": "box"}),
        ('type="tent"', {"type": "tent", "radius": 1.0}),
        ('type="gaussian"', {"type": "gaussian", "stddev": 0.5, "radius": 2.0}),
        ('type="mitchell"', {"type": "mitchell", "b": 1 / 3, "c": 1 / 3}),
        ('type="catmullrom"', {"type": "mitchell", "b": 0.0, "c": 0.5}),
    ],
)
def test_filters(kind, meant):
    body = f'<sensor type="perspective"><film type="hdrfilm"><rfilter {kind}/></film></sensor>'
    found = read(body).film.filter
    assert {key: getattr(found, key) for key in meant} == meant


@pytest.mark.parametrize(
    ("kind", "ours"),
    [
        ("independent", "independent"),
        ("stratified", "stratified"),
        ("multijitter", "multijittered"),
        ("halton", "halton"),
        ("ldsampler", "sobol"),
        ("orthogonal", "sobol"),
    ],
)
def test_samplers(kind, ours):
    body = f"""<sensor type="perspective"><sampler type="{kind}">
    <integer name="sample_count" value="49"/></sampler></sensor>"""
    scene = read(body)
    assert scene.sampler.type == ours
    assert scene.source.remarks.spp == 49
    assert getattr(scene.sampler, "strata", 7) == 7


def test_integrators():
    path = read('<integrator type="path"/>').integrator
    assert (path.type, path.rr_depth) == ("path", 5)
    inner = '<integrator type="path"><integer name="max_depth" value="3"/></integrator>'
    for wrapper in ("moment", "aov"):
        scene = read(f'<integrator type="{wrapper}">{inner}</integrator>')
        assert scene.integrator.max_depth == 3
        assert "is taken off" in scene.source.remarks.notes[0]
    direct = read('<integrator type="direct"><integer name="bsdf_samples" value="0"/></integrator>')
    assert (direct.integrator.type, direct.integrator.light_sampling) == ("direct", "emitter")
    assert "not covered" in messages('<integrator type="vcm"/>')[0]


@pytest.mark.parametrize(
    ("kind", "depth", "is_said"),
    [("volpath", 6, True), ("volpathmis", 6, True), ("volpath", -1, False), ("path", 6, False)],
)
def test_depths_that_panes_use_up_are_told_of(kind, depth, is_said):
    """Mitsuba's volpath passes thindielectric without counting, its path counts."""
    scene = read(f"""
<integrator type="{kind}"><integer name="max_depth" value="{depth}"/></integrator>
<shape type="sphere"><bsdf type="thindielectric"/>
    <medium name="interior" type="homogeneous"><float name="sigma_t" value="1"/></medium>
</shape>""")
    said = [line for line in scene.warnings if "passing thindielectric" in line]
    assert bool(said) == is_said
