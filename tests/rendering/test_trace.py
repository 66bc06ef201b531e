"""A trace's sum is what the compiled renderer adds to the film for that very sample."""

import json
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.accel.lists import NOTHING, Accelerator, search_triangles
from alight.cli.main import app
from alight.core.errors import OptionError
from alight.core.registry import specs
from alight.films import fixed_point
from alight.formats import loads
from alight.laws.integrators import ROOM
from alight.rendering.tracing.observation import search_all_triangles
from alight.rendering.tracing.trace_table import _digits_of_places, _triple
from alight.scene.description import FilmSettings
from alight.shapes.hit import Hit
from lanewise.simd import LANES
from lanewise.vec3 import Vec3
from lanewise.view import View
from tests.docs.pages import ROOT
from tests.media.scenes import bodies


def room(size=(24, 24), integrator="path", sampler="independent", filter_type="box"):
    """The room of the laws, with other settings."""
    film = f"film: {{size: {list(size)}, filter: {{type: {filter_type}}}}}"
    text = ROOM.replace("film: {size: [16, 16]}", film)
    text = text.replace("sampler: independent", f"sampler: {sampler}")
    return loads(f"{text}integrator: {integrator}\n", "room.yaml")


#: Scenes: each integrator, several samplers and filters.
RENDERS = {
    "path": lambda: alight.load("cornell-box", ["film.size=[24, 24]"]),
    "path, mirrors and glass": lambda: alight.load(
        "mirror-and-glass", ["film.size=[24, 24]", "film.filter.type=mitchell"]
    ),
    "direct": lambda: room(integrator="direct", sampler="halton"),
    "random_walk": lambda: room(
        integrator="random_walk", sampler="multijittered", filter_type="gaussian"
    ),
    "volpath": lambda: bodies(0.8, g=0.3).replaced(film=FilmSettings(size=(24, 24))),
    "ambient_occlusion": lambda: room(integrator="ambient_occlusion", sampler="stratified"),
}
SAMPLE, SEED = 5, 3
PIXELS = [(1, 1), (4, 20), (8, 14), (11, 9), (13, 17), (16, 13), (19, 21), (23, 5)]


def samples_of(scene):
    """What the film adds for sample number `SAMPLE` of each pixel."""
    film = alight.render(scene, spp=1, first_sample=SAMPLE, seed=SEED)
    sums = film.sums.copy()
    fixed_point.carry(sums)
    return fixed_point.to_float(sums).sum(axis=2)


@pytest.fixture(scope="module", params=RENDERS.values(), ids=RENDERS)
def rendered(request):
    scene = request.param()
    return scene, samples_of(scene)


def test_the_sum_is_the_value_of_the_compiled_renderer(rendered):
    scene, expected = rendered
    lit = 0
    for x, y in PIXELS:
        path = alight.trace(scene, (x, y), sample=SAMPLE, seed=SEED)
        total = np.sum([vertex.contribution for vertex in path.vertices], axis=0)
        np.testing.assert_allclose(total, path.value, rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(path.value, expected[y, x], rtol=5e-4, atol=1e-6)
        lit += np.any(expected[y, x] != 0.0)
        if scene.film.filter.type_name() == "box":
            assert path.weight == 1.0
    assert lit >= 3


def test_numbers_of_a_vertex_explain_what_it_adds():
    """Contribution = beta Le w + beta f cos radiance w / pdf, from the numbers that are shown."""
    found = set()
    paths = [alight.trace("mirror-and-glass", (20 * x, 20 * y), sample=x) for x, y in PIXELS]
    paths += [alight.trace(room(), pixel) for pixel in PIXELS]
    for path in paths:
        for vertex in path.vertices:
            expected, light = np.zeros(3), vertex.light
            if vertex.emission:
                expected += (
                    np.array(vertex.beta) * vertex.emission.radiance * vertex.emission.weight
                )
                found.add("emission")
            if light and light.visible:
                factor = light.weight / light.pdf
                expected += np.array(vertex.beta) * light.f_cos * np.array(light.radiance) * factor
                found.add("light")
            if light and light.visible is False:
                found.add("shadow")
            np.testing.assert_allclose(vertex.contribution, expected, rtol=1e-4, atol=1e-7)
            found.add(vertex.scattering.lobe if vertex.scattering else "none")
    assert {"emission", "light", "shadow", "reflection", "delta reflection"} <= found
    assert "delta transmission" in found


def test_mis_weights_follow_from_the_densities_that_are_shown():
    scene = room((8, 8), "{type: path, heuristic: balance}")
    found, sampled = 0, 0
    for sample in range(20):
        for vertex in alight.trace(scene, (4, 6), sample=sample).vertices:
            met, light = vertex.emission, vertex.light
            if met and met.radiance[0] > 0.0 and not vertex.delta:
                assert met.weight == pytest.approx(
                    vertex.pdf / (vertex.pdf + met.light_pdf), rel=1e-4
                )
                found += 1
            if light and light.visible:
                weight = light.pdf / (light.pdf + light.bsdf_pdf)
                assert light.weight == pytest.approx(weight, rel=1e-4)
                sampled += 1
    assert found > 5 and sampled > 5


@pytest.mark.parametrize("shared", [False, True], ids=["soup", "grid"])
def test_all_triangles_at_once_are_hit_as_one_after_the_other(shared):
    """The trace's own loop over triangles against the kernel that it stands for, to the bit."""
    rng = np.random.default_rng(4)
    corners = rng.uniform(-1, 1, (300, 3, 3)).astype(np.float32)
    if shared:
        # Doubled triangles and coarse corners: ties, edges and corners are met.
        corners = np.repeat(np.rint(2.0 * corners[:150]) / 2.0, 2, axis=0).astype(np.float32)
    ids = np.stack([np.arange(300) // 7, np.arange(300) % 7], axis=1).astype(np.uint32)
    table = View(np.append(corners.ravel(), np.float32(0.0)))
    accel = Accelerator(**dict.fromkeys(Accelerator._fields))
    accel = accel._replace(triangles=table, triangle_ids=View(ids))
    lanes = int(LANES)
    for _ in range(8):
        o = np.rint(8.0 * rng.uniform(-3, 3, (3, lanes))) / 8.0
        d = rng.uniform(-1, 1, (3, lanes)) - o
        o, d = Vec3(*o.astype(np.float32)), Vec3(*d.astype(np.float32))
        t = np.where(np.arange(lanes) % 5, np.float32(np.inf), np.float32(-1.0))
        zero, none = np.zeros(lanes, np.float32), np.zeros(lanes, np.uint32)
        start = Hit(t, zero, zero, none + np.uint32(NOTHING), none)
        with np.errstate(all="ignore"):
            expected = search_triangles(accel, None, o, d, start, True)
            found = search_all_triangles(accel, None, o, d, start, True)
            for a, b in zip(found, expected, strict=True):
                np.testing.assert_array_equal(a, b)
            # At the same distance as a hit of another list, the lower shape counts.
            shapes = rng.integers(0, 40, lanes).astype(np.uint32)
            rival = expected._replace(shape=np.where(expected.t < np.inf, shapes, none + NOTHING))
            for a, b in zip(
                search_all_triangles(accel, None, o, d, rival, True),
                search_triangles(accel, None, o, d, rival, True),
                strict=True,
            ):
                np.testing.assert_array_equal(a, b)
            # Shadow rays that end just before, at and behind the first hit.
            for factor in (0.999, 1.0, 1.5):
                end = np.where(np.isfinite(expected.t), expected.t * np.float32(factor), t)
                shadow = start._replace(t=end)
                np.testing.assert_array_equal(
                    search_all_triangles(accel, None, o, d, shadow, False).t,
                    search_triangles(accel, None, o, d, shadow, False).t,
                )
    assert np.isfinite(expected.t).any()


# ---------------------------------------------------------------- the command line


def test_a_trace_needs_no_compiler():
    code = "import sys, alight; alight.trace('cornell-box', (9, 9)); print('numba' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "False"


def invoke(*words):
    return CliRunner().invoke(app, ["trace", *words])


def test_the_table_fits_100_columns_and_ends_with_the_value():
    done = invoke("cornell-box", "--pixel", "250,400", "--size", "512", "--max-depth", "4")
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert max(map(len, lines)) <= 104
    path = alight.trace(alight.load("cornell-box", ["integrator.max_depth=4"]), (250, 400))
    assert f"value  {path.value[0]:.7g}" in done.output
    assert sum(line[:1].isdigit() for line in lines) == len(path.vertices)


def test_files_of_other_programs_are_traced_as_they_are_rendered(tmp_path):
    """With values of their $names, what is not covered replaced, and any of the cameras."""
    (tmp_path / "a.xml").write_text(
        '<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant">'
        '<rgb name="radiance" value="$light"/></emitter><shape type="hair"/></scene>'
    )
    words = (str(tmp_path / "a.xml"), "--pixel", "3,3")
    assert invoke(*words).exit_code != 0
    done = invoke(*words, "-D", "light=0.25", "--lenient")
    assert done.exit_code == 0 and "value  0.25" in done.output
    (tmp_path / "a.yaml").write_text(
        "alight: 1\ncamera: a\nnodes:\n  a: {camera: {type: pinhole}}\n"
        "  b: {camera: {type: pinhole}, transform: {rotate: {axis: x, angle: -90}}}\n"
        "  lamp: {shape: sphere, light: {type: area}, transform: {translate: [0, 0, -5]}}\n"
    )
    words = (str(tmp_path / "a.yaml"), "--pixel", "300,200", "--size", "600x400")
    assert "value  1 " in invoke(*words).output
    assert "value  0 " in invoke(*words, "--camera", "b").output


def test_json_holds_all_numbers():
    done = invoke("mirror-and-glass", "--pixel", "250,300", "--json", "--sample", "2")
    data = json.loads(done.output)
    path = alight.trace("mirror-and-glass", (250, 300), sample=2)
    assert data == path.to_dict()
    assert data["vertices"][0]["position"] == list(path.vertices[0].position)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ("--pixel", "512,3"),
            "--pixel: must be x,y with x in [0, 511] and y in [0, 511], got 512,3",
        ),
        (("--pixel", "-1,3"), "x in [0, 511] and y in [0, 511], got -1,3"),
        (("--pixel", "twelve"), '--pixel: must be X,Y in pixels, such as 12,7, got "twelve"'),
        (("--pixel", "1,1", "--sample", "-1"), "sample: must be a whole number in [0, 2147483647]"),
        (("--pixel", "1,1", "--seed", "-1"), "seed: must be a whole number in [0, 4294967295]"),
    ],
)
def test_wrong_numbers_get_their_range(words, message):
    done = invoke("cornell-box", *words)
    assert done.exit_code == 2 and message in done.output, done.output


def test_pixels_must_be_whole():
    with pytest.raises(OptionError, match="pixel: must be x,y"):
        alight.trace("cornell-box", (1.5, 2))


def test_every_integrator_is_traced():
    """A new integrator joins RENDERS, so that its trace is compared too."""
    assert {name for name, spec in specs("integrators").items() if not spec.splats} <= set(RENDERS)


def test_places_of_vertices_far_away_are_told_apart():
    near = [(0.0, -0.57, 1.0), (0.5, 0.2, -1.0)]
    far = [tuple(c + 1e6 for c in place) for place in near]
    assert (_digits_of_places(near), _digits_of_places(far), _digits_of_places([])) == (3, 8, 3)
    first, second = (_triple(place, 8) for place in far)
    assert first != second
    assert [float(c) for c in first.split()] == pytest.approx(far[0], abs=0.5)
