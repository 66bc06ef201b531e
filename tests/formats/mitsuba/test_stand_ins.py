"""What Mitsuba has and alight lacks: what takes its place, and that it is said."""

import base64
import math

import numpy as np
import pytest

from alight.bsdfs.fibres.hair import Hair
from alight.bsdfs.measured.examples import satin
from alight.core.errors import SceneError
from alight.formats import load
from alight.scene import flatten
from tests.formats.mitsuba.reading import issues, messages, node, read, read_bsdf

PICTURE = '<string name="filename" value="letters.png"/>'


def test_coats_over_matte_and_metal():
    inner = '<float name="intIOR" value="1.7"/><float name="extIOR" value="1"/>'
    red = '<bsdf type="diffuse"><rgb name="reflectance" value="0.8 0.4 0.2"/></bsdf>'
    tint = '<rgb name="sigmaA" value="0.1 0.2 0"/><float name="thickness" value="2"/>'
    coat = read_bsdf(f"{inner}{tint}{red}", 'type="coating"', "0.5.0")
    assert (coat.type_name(), coat.int_ior, coat.nonlinear) == ("plastic", 1.7, True)
    # In and out again through the layer.
    meant = np.array([0.8, 0.4, 0.2]) * np.exp([-0.4, -0.8, 0.0])
    np.testing.assert_allclose(coat.diffuse_reflectance, meant)
    alpha = '<float name="alpha" value="0.3"/>'
    coat = read_bsdf(f"{inner}{alpha}{red}", 'type="roughcoating"', "0.5.0")
    assert (coat.type_name(), coat.alpha) == ("rough_plastic", 0.3)
    metal = '<string name="material" value="Au"/><float name="alpha" value="0.25"/>'
    gold = f'<bsdf type="twosided"><bsdf type="roughconductor">{metal}</bsdf></bsdf>'
    grey = '<rgb name="sigmaA" value="0.1 0.1 0.1"/><float name="thickness" value="2"/>'
    coat = read_bsdf(f"{inner}{grey}{gold}", 'type="coating"', "0.5.0")
    assert (coat.type_name(), coat.alpha, coat.int_ior) == ("coated_conductor", 0.25, 1.7)
    assert (coat.bounces, coat.thickness) == (1, pytest.approx(0.2))
    # The metal reflects in the coat what it would in air.
    air = read_bsdf(metal, 'type="roughconductor"', "0.5.0")
    np.testing.assert_allclose(coat.eta, 1.7 * np.array(air.eta))
    np.testing.assert_allclose(coat.k, 1.7 * np.array(air.k))
    coat = read_bsdf(f"{inner}{alpha}{gold}", 'type="roughcoating"', "0.5.0")
    assert coat.coat_alpha == 0.3
    coat = read_bsdf(f"{inner}{tint}{gold}", 'type="coating"', "0.5.0")
    assert (coat.type_name(), coat.metallic, coat.clearcoat) == ("principled", 1.0, 1.0)
    assert coat.roughness == pytest.approx(0.5)
    red_part, _, blue = coat.base_color
    assert red_part > 0.6 > blue
    glass = read_bsdf('<bsdf type="dielectric"/>', 'type="coating"', "0.5.0")
    assert (glass.type_name(), glass.opacity) == ("mask", 1.0)


def test_mixtures_keep_their_weights():
    parts = "".join(
        f'<bsdf type="diffuse"><spectrum name="reflectance" value="{r}"/></bsdf>'
        for r in (0.1, 0.5, 0.9)
    )
    found = read_bsdf(
        f'<string name="weights" value=".5, .3, .1"/>{parts}', 'type="mixturebsdf"', "0.5.0"
    )

    def mean(bsdf):
        if bsdf.type_name() == "blend":
            low, high = map(mean, bsdf.bsdfs)
            return low + bsdf.weight * (high - low)
        return bsdf.reflectance[1]

    assert mean(found) == pytest.approx(0.5 * 0.1 + 0.3 * 0.5 + 0.1 * 0.9)
    wrong = f'<bsdf type="mixturebsdf"><string name="weights" value=".5"/>{parts}</bsdf>'
    assert "got 1 for 3" in messages(wrong, "0.5.0")[0]


def test_parts_of_no_weight_are_left_out_of_mixtures():
    parts = "".join(f'<bsdf type="{kind}"/>' for kind in ("plastic", "diffuse", "diffuse"))
    weights = '<string name="weights" value="{}"/>'
    for text in ("1 0 0", "1, 0, 0"):
        found = read_bsdf(weights.format(text) + parts, 'type="mixturebsdf"', "0.5.0")
        assert (found.opacity, found.bsdf.type_name()) == (1.0, "plastic")
    found = read_bsdf(weights.format("0 .25 .75") + parts, 'type="mixturebsdf"', "0.5.0")
    assert [part.type_name() for part in found.bsdfs] == ["diffuse", "diffuse"]
    assert found.weight == 0.75


def test_materials_of_06_that_have_a_counterpart():
    rough = read_bsdf('<float name="alpha" value="0.5"/>', 'type="roughdiffuse"', "0.5.0")
    assert rough.type_name() == "oren_nayar"
    assert rough.sigma == pytest.approx(math.degrees(0.5 / math.sqrt(2.0)))
    leaf = read_bsdf('<rgb name="transmittance" value="0 .5 0"/>', 'type="difftrans"', "0.5.0")
    assert (leaf.transmittance, leaf.reflectance) == ((0.0, 0.5, 0.0), (0.0, 0.0, 0.0))
    ward = read_bsdf('<float name="alphaU" value="0.05"/>', 'type="ward"', "0.5.0")
    assert (ward.type_name(), ward.exponent) == ("phong", pytest.approx(0.5 / (0.05 * 0.1)))
    shape = '<shape type="sphere"><subsurface type="dipole">{}</subsurface></shape>'
    named = '<string name="material" value="skimmilk"/>'
    milk = node(read(shape.format(named), "0.5.0")).bsdf.bsdf
    given = (
        '<rgb name="sigmaS" value="0.7 1.22 1.9"/><rgb name="sigmaA" value=".0014 .0025 .0142"/>'
    )
    same = node(read(shape.format(given), "0.5.0")).bsdf.bsdf
    assert milk == same
    # Jensen et al., figure 5.
    np.testing.assert_allclose(milk.diffuse_reflectance, [0.81, 0.81, 0.69], atol=0.01)


REPLACED = {
    "measured_polarized": ('<float name="alpha_sample" value="0.1"/>', "rough_plastic"),
    "pplastic": ('<float name="alpha" value="0.2"/>', "rough_plastic"),
    "polarizer": ("", "mask"),
    "circular": ("", "mask"),
    "retarder": ("", "null"),
    "itu-radio-material": ('<string name="type" value="concrete"/>', "diffuse"),
}


@pytest.mark.parametrize("kind", REPLACED)
def test_what_takes_their_place_is_said(kind):
    content, native = REPLACED[kind]
    scene = read(f'<bsdf id="it" type="{kind}">{content}</bsdf>')
    assert scene.bsdfs["it"].type_name() == native
    assert any(f'type="{kind}"' in text for text in scene.warnings)
    if kind == "polarizer":
        assert scene.bsdfs["it"].opacity == 0.5


def test_measured_materials_are_read(tmp_path):
    (tmp_path / "it.bsdf").write_bytes(base64.b64decode(satin().plain()))
    text = (
        '<scene version="3.0.0"><emitter type="constant"/><shape type="sphere">'
        '<bsdf type="measured"><string name="filename" value="{}.bsdf"/></bsdf></shape></scene>'
    )
    (tmp_path / "a.xml").write_text(text.format("it"))
    (found,) = flatten(load(tmp_path / "a.xml")).bsdfs
    assert found.data == satin()
    (tmp_path / "a.xml").write_text(text.format("other"))
    with pytest.raises(SceneError, match=r"other\.bsdf"):
        load(tmp_path / "a.xml")
    scene = load(tmp_path / "a.xml", lenient=True)
    assert any("grey plastic is taken" in text for text in scene.warnings)


def test_textures_times_a_factor():
    scaled = (
        '<texture type="scale" name="{}"><float name="scale" value="{}"/>'
        f'<texture type="bitmap">{PICTURE}</texture></texture>'
    )
    found = read_bsdf(scaled.format("reflectance", 0.5), 'type="diffuse"', "0.5.0").reflectance
    assert (found.type_name(), found.a.type_name(), found.b) == (
        "multiply",
        "bitmap",
        (0.5, 0.5, 0.5),
    )
    # Lamps may be brighter than their pictures.
    lamp = f'<emitter type="area">{scaled.format("radiance", 15)}</emitter>'
    found = node(read(f'<shape type="rectangle">{lamp}</shape>', "0.5.0")).light.radiance
    assert found.b == (15.0, 15.0, 15.0)


def test_masks_by_a_channel():
    channel = f'<texture type="bitmap" name="opacity">{PICTURE}<string name="channel" value="a"/>'
    mask = read_bsdf(f'{channel}</texture><bsdf type="diffuse"/>', 'type="mask"', "0.5.0")
    assert (mask.opacity.type_name(), mask.opacity.channel) == ("channel", "a")


def test_integrators_that_become_others():
    depth = '<integer name="max_depth" value="3"/>'
    for kind in ("ptracer", "bdpt", "photonmapper"):
        scene = read(f'<integrator type="{kind}">{depth}</integrator>')
        assert (scene.integrator.type, scene.integrator.max_depth) == ("path", 3)
        assert any("finds no caustics" in text for text in scene.warnings)
    assert read('<integrator type="prb"/>').integrator.type == "path"
    alone = read('<integrator type="aov"><string name="aovs" value="nn:sh_normal"/></integrator>')
    assert alone.integrator.type == "path"
    assert any("layers alone" in text for text in alone.warnings)
    strict = '<integrator type="path"><boolean name="strictNormals" value="true"/></integrator>'
    assert any("strict_normals" in text for text in read(strict, "0.5.0").warnings)
    fog = '<medium type="homogeneous" name="interior"/><bsdf type="null"/>'
    body = f'<integrator type="volpath_simple"/><shape type="sphere">{fog}</shape>'
    assert read(body, "0.5.0").integrator.type == "volpath"


def test_lamps_by_reference():
    lamp = '<emitter type="area" id="lamp"><rgb name="radiance" value="1 2 3"/></emitter>'
    dark = '<bsdf type="diffuse" id="dark"/>'
    body = f'{dark}<shape type="sphere"><ref id="dark"/><ref id="lamp"/></shape>{lamp}'
    found = node(read(body))
    assert found.light.radiance == (1.0, 2.0, 3.0)
    assert found.bsdf == "dark"


def test_templates_turn_by_nothing_about_nothing():
    turn = '<transform name="to_world"><rotate x="0" y="0" z="0" angle="{}"/></transform>'
    body = f'<shape type="sphere">{turn}</shape>'
    assert node(read(body.format(0))).transform.apply_point((1, 2, 3)).tolist() == [1, 2, 3]
    assert "axis must not have length 0" in messages(body.format(90))[0]


def test_animations_by_their_other_name():
    frames = "".join(f'<transform time="{t}"><translate x="{t}"/></transform>' for t in (0.0, 1.0))
    shape = '<shape type="sphere"><animation name="{}">{}</animation></shape>'
    found = [node(read(shape.format(name, frames))) for name in ("to_world", "animation")]
    assert found[0].transform == found[1].transform


def test_sensors_with_parameters_of_later_versions():
    sensor = (
        '<sensor type="perspective"><boolean name="jitter" value="false"/>'
        '<float name="cone_scale" value="2"/></sensor>'
    )
    notes = read(sensor).source.remarks.notes
    assert len([note for note in notes if "jitter" in note or "cone_scale" in note]) == 2


def test_files_of_shapes_alone_are_framed():
    from alight.formats import loads

    ball = (
        '<shape type="sphere"><transform name="to_world"><scale value="3"/>'
        '<translate x="5"/></transform></shape>'
    )
    scene = loads(f'<scene version="3.0.0">{ball}</scene>', "scene.xml")
    origin = scene.camera.transform.apply_point((0, 0, 0))
    view = scene.camera.transform.apply_vector((0, 0, -1))
    to_ball = np.array([5.0, 0.0, 0.0]) - origin
    distance = np.linalg.norm(to_ball)
    assert to_ball @ view / distance / np.linalg.norm(view) > 0.99
    assert distance > 3.0 / math.tan(math.radians(20.0))
    assert scene.environment is not None
    assert any("no camera" in text for text in scene.warnings)
    # With a lamp of its own there is no studio.
    lamp = '<emitter type="constant"/>'
    lit = loads(f'<scene version="3.0.0">{ball}{lamp}</scene>', "scene.xml")
    assert not any("no light" in text for text in lit.warnings)


def test_grids_in_their_own_box(tmp_path):
    head = b"VOL\x03" + np.array([1, 2, 1, 1, 3], "<i4").tobytes()
    box = np.array([-1, -2, -3, 1, 2, 3], "<f4").tobytes()
    (tmp_path / "a.vol").write_bytes(head + box + np.arange(6, dtype="<f4").tobytes())
    body = (
        '<integrator type="volpath"/><shape type="cube"><bsdf type="null"/>'
        '<medium name="interior" type="heterogeneous"><volume name="sigma_t" type="gridvolume">'
        '<string name="filename" value="a.vol"/><boolean name="use_grid_bbox" value="true"/>'
        '</volume><phase type="blendphase"><float name="weight" value="0.25"/>'
        '<phase type="hg"><float name="g" value="0.8"/></phase><phase type="isotropic"/></phase>'
        "</medium></shape>"
    )
    scene = read(body, folder=tmp_path)
    medium = node(scene).interior
    assert medium.matrix == (2.0, 0.0, 0.0, -1.0, 0.0, 4.0, 0.0, -2.0, 0.0, 0.0, 6.0, -3.0)
    # The mean of three channels.
    np.testing.assert_allclose(medium.values.values[0, 0, :, 0], [1.0, 4.0])
    assert medium.phase.g == pytest.approx(0.6)
    assert len([text for text in scene.warnings if "scene.xml" in text]) == 2


def test_what_stands_in_takes_no_unknown_parameters():
    [issue] = issues('<bsdf type="ward" id="a"><float name="wobble" value="1"/></bsdf>', "0.5.0")
    assert "unknown parameter" in issue.message


def test_hair_is_hair():
    """Mitsuba's defaults are 1.3 and 0.2 of the pigments; its air has an index of its own."""
    usual = read_bsdf("", 'type="hair"')
    assert isinstance(usual, Hair)
    assert (usual.eumelanin, usual.pheomelanin) == (1.3, 0.2)
    assert usual.ior == pytest.approx(1.55 / 1.000277)
    given = (
        '<rgb name="sigma_a" value="0.1 0.2 0.3"/><float name="scale_tilt" value="3"/>'
        '<float name="longitudinal_roughness" value="0"/>'
        '<float name="azimuthal_roughness" value="0.6"/>'
    )
    found = read_bsdf(given, 'type="hair"')
    np.testing.assert_allclose(found.sigma_a, (0.1, 0.2, 0.3))
    assert (found.beta_m, found.beta_n, found.alpha) == (0.05, 0.6, 3.0)


@pytest.mark.parametrize(
    ("name", "value", "range_"),
    [
        ("eumelanin", "-3", "[0, 1000]"),
        ("pheomelanin", "1e9", "[0, 1000]"),
        ("azimuthal_roughness", "1.5", "[0, 1]"),
        ("azimuthal_roughness", "-0.1", "[0, 1]"),
        ("longitudinal_roughness", "2", "[0, 1]"),
    ],
)
def test_numbers_of_hair_have_their_range(name, value, range_):
    text = f'<bsdf type="hair"><float name="{name}" value="{value}"/></bsdf>'
    assert f"must be in {range_}, got {float(value):g}" in messages(text)[0]
    text = '<bsdf type="hair"><rgb name="sigma_a" value="0 0 -1"/></bsdf>'
    assert "must be >= 0" in messages(text)[0]


def test_coats_say_what_becomes_of_their_facets():
    """Over a matte base they stay; coated metal has those of GGX; what varies is told."""
    rough = '<string name="distribution" value="beckmann"/><float name="alpha" value="0.3"/>'
    varied = '<texture name="alpha" type="checkerboard"/>'
    coat = 'type="roughcoating"'
    found = read_bsdf(f'{rough}<bsdf type="diffuse"/>', coat, "0.5.0")
    assert (found.distribution, found.alpha) == ("beckmann", 0.3)

    def said(body):
        scene = read(f'<shape type="sphere"><bsdf {coat}>{body}</bsdf></shape>', "0.5.0")
        return "\n".join(scene.warnings)

    assert "is not a number: 0.1 is taken" in said(f'{varied}<bsdf type="diffuse"/>')
    metal = '<bsdf type="{}conductor"><string name="material" value="Au"/>{}</bsdf>'
    assert "has facets of GGX" in said(rough + metal.format("", ""))
    assert "has facets of GGX" in said(metal.format("rough", ""))
    ggx = '<string name="distribution" value="ggx"/>'
    assert "has facets of GGX" not in said(ggx + metal.format("rough", ggx))
    assert "loses the texture of its metal's alpha" in said(ggx + metal.format("rough", varied))
    uneven = '<float name="alphaU" value="0.1"/><float name="alphaV" value="0.3"/>'
    assert "alike in all directions, by alpha_u" in said(ggx + metal.format("rough", uneven))
    tint = '<texture name="specularReflectance" type="checkerboard"/>'
    assert "loses the texture of what its metal reflects" in said(metal.format("", tint))


BORDER = (
    '<integrator type="volpath"/><shape type="cube">%s<medium name="interior" type="homogeneous">'
    "</medium></shape>"
)


@pytest.mark.parametrize(
    ("version", "inner", "bsdf"),
    [
        ("0.5.0", "", "null"),
        ("3.0.0", "", None),
        ("0.5.0", '<bsdf type="diffuse"/>', "diffuse"),
        ("0.5.0", '<emitter type="area"/>', "diffuse"),
    ],
)
def test_the_border_of_an_old_medium_is_not_seen_unless_it_says_of_what_it_is(version, inner, bsdf):
    found = node(read(BORDER % inner, version)).bsdf
    assert (found and found.type) == bsdf


#: What renderers derived from Mitsuba ask for, at its place in a file.
COUNT = '<integer name="sampleCount" value="4"/>'
HIDE = '<boolean name="hide" value="true"/>'
MODE = '<string name="mode" value="x"/>'
OF_OTHERS = (
    f'<integrator type="path_guiding">{COUNT}{MODE}</integrator>',
    f'<integrator type="sppm"><float name="alpha" value="0.7"/>{COUNT}</integrator>',
    f'<integrator type="path">{COUNT}</integrator>',
    f'<shape type="sphere">{MODE}{HIDE}</shape>',
    '<bsdf type="dielectric" id="a"><float name="ext_eta" value="1"/></bsdf>',
    f'<sensor type="perspective">{COUNT}<sampler type="independent">{MODE}</sampler></sensor>',
    f'<sensor type="perspective"><film type="hdrfilm">{MODE}</film></sensor>',
    f'<emitter type="point">{HIDE}</emitter>',
)


@pytest.mark.parametrize("version", ["0.6.0", "3.0.0"])
@pytest.mark.parametrize("body", OF_OTHERS)
def test_parameters_of_other_renderers_are_listed_and_left_out(body, version):
    scene = read(body, version, lenient=True)
    words = ("ignored", "is taken", "becomes path")
    assert any(word in text for text in scene.warnings for word in words)


def test_a_metal_of_negative_alpha_is_smooth_under_a_coat():
    metal = '<bsdf type="roughconductor"><float name="alpha" value="-0.4"/></bsdf>'
    tint = '<rgb name="sigma_a" value="0.1 0.2 0.3"/>'
    assert read_bsdf(tint + metal, 'type="coating"').roughness == 0.0


def test_a_film_without_columns_is_refused_before_parallel_rays_of_it():
    film = '<film type="hdrfilm"><integer name="width" value="0"/></film>'
    [text] = messages(f'<sensor type="orthographic">{film}</sensor>')
    assert text.startswith("must be in [1, ") and text.endswith("got 0")
