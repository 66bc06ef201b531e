"""Media: what they are, and which side of which surface they lie on."""

import numpy as np
import pytest

from alight.compiled.scene import compile_scene
from alight.films import fixed_point
from alight.formats.pbrt.media import COVERED
from alight.integrators.walk import make_settings
from alight.rendering.tiles.tile import make_kernels, render_tile
from alight.rendering.tiles.tile_kernel import Tile
from alight.scene import flatten
from tests.formats.pbrt.reading import HEAD, messages, native, node, read, read_old

FOG = 'MakeNamedMedium "fog" "string type" "homogeneous"'
CLOUD = """MakeNamedMedium "cloud" "string type" "uniformgrid" "integer nx" 2 "integer ny" 1
  "integer nz" 3 "float density" [1 2 3 4 5 6]"""
SPHERE = 'Material "interface"\nShape "sphere"'


def medium(definition, name="fog"):
    """The only medium of a scene whose sphere is full of it."""
    scene = read(f'{definition}\nMediumInterface "{name}" ""\n{SPHERE}')
    assert (node(scene).interior, node(scene).exterior) == (name, "vacuum")
    assert scene.integrator.type == "volpath"
    [found] = scene.media.values()
    return found


MEDIA = {
    FOG: "{type: homogeneous, sigma_a: [0.0011, 0.0024, 0.014], sigma_s: [2.55, 3.21, 3.77]}",
    f'{FOG} "rgb sigma_a" [1 2 3] "rgb sigma_s" [4 5 6] "float scale" 0.5 "float g" -0.3': (
        "{type: homogeneous, sigma_a: [0.5, 1, 1.5], sigma_s: [2, 2.5, 3], "
        "phase: {type: henyey_greenstein, g: -0.3}}"
    ),
    f'{FOG} "float scale" 0': "{type: homogeneous, sigma_a: 0, sigma_s: 0}",
    f'{FOG} "rgb sigma_a" 1 "rgb sigma_s" 1 "rgb Le" [1 2 4] "float Lescale" 0.5'.replace(
        '" 1', '" [1 1 1]'
    ): "{type: homogeneous, sigma_a: 1, sigma_s: 1, emission: [0.5, 1, 2]}",
}


@pytest.mark.parametrize("definition", MEDIA)
def test_coefficients_of_homogeneous_media(definition):
    assert medium(definition) == native("media", MEDIA[definition])


def density(found, point):
    """Density at a point of the world: linear between the centres of cells."""
    rows = np.reshape(found.matrix, (3, 4))
    unit = np.linalg.solve(rows[:, :3], np.asarray(point) - rows[:, 3])
    values = found.values.values[..., 0]
    at = np.clip(unit[::-1] * values.shape - 0.5, 0, np.array(values.shape) - 1)
    low = np.minimum(at.astype(int), np.array(values.shape) - 2)
    total = 0.0
    for corner in np.ndindex(2, 2, 2):
        weight = np.prod(np.where(corner, at - low, 1 - (at - low)))
        total += weight * values[tuple(low + corner)]
    return total


def test_a_grid_has_the_densities_of_the_file_in_the_box_of_the_file():
    where = '"point3 p0" [0 0 0] "point3 p1" [4 2 6] "float g" 0.5 "rgb sigma_s" [2 2 2]'
    found = medium(f"Translate 10 0 0\nScale 2 1 1\n{CLOUD} {where}\nIdentity", "cloud")
    assert (found.sigma_a, found.sigma_s) == ((1, 1, 1), (2, 2, 2))
    assert found.phase.g == 0.5
    # Cells are 2 x 2 x 2 before the scene's Scale; x runs fastest, then y.
    centres = [(12, 1, 1), (16, 1, 1), (12, 1, 3), (16, 1, 3), (12, 1, 5), (16, 1, 5)]
    assert [density(found, p) for p in centres] == pytest.approx([1, 2, 3, 4, 5, 6])
    assert density(found, (14, 1, 2)) == pytest.approx(2.5)
    # It falls to what is outside: to half of it at the faces of the box, a quarter at the edges.
    assert density(found, (10, 1, 1)) == pytest.approx(0.5)
    assert density(found, (18, 2, 5)) == pytest.approx(1.5)


def test_a_grid_shines_cell_by_cell():
    le = '"rgb Le" [2 1 0] '
    assert medium(f"{CLOUD} {le}", "cloud").emission == (2, 1, 0)
    found = medium(f'{CLOUD} {le} "float Lescale" [0 1 2 3 4 5]', "cloud")
    assert found.emission == (0, 0, 0)
    # Around them is the rim of empty cells, as around the densities.
    inner = found.emission_values.values[1:-1, 1:-1, 1:-1]
    np.testing.assert_array_equal(inner, np.arange(6.0).reshape(3, 1, 2, 1) * [2.0, 1.0, 0.0])
    assert found.emission_values.values.shape[:3] == found.values.values.shape[:3]
    assert found.emission_values.values.sum() == inner.sum()


def test_surfaces_are_borders_only_where_their_sides_differ():
    names = 'MediumInterface "fog" "cloud"\n' + SPHERE
    scene = read(f"{FOG}\n{CLOUD}\n{names}")
    assert (node(scene).interior, node(scene).exterior) == ("fog", "cloud")
    for same in ('"fog" "fog"', '"fog"', '""'):
        scene = read(f"{FOG}\n{CLOUD}\nMediumInterface {same}\n{SPHERE}")
        assert (node(scene).interior, node(scene).exterior) == (None, None)


def test_attributes_keep_media_and_names_may_come_late():
    body = f"""AttributeBegin
MediumInterface "" "fog"
{SPHERE}
AttributeEnd
{SPHERE}
{FOG}"""
    first, second = read(body).nodes.values()
    assert (first.interior, first.exterior) == ("vacuum", "fog")
    assert (second.interior, second.exterior) == (None, None)


def test_what_is_outside_at_the_camera_is_around_it_and_stays_in_the_world():
    head = f'{FOG}\nMediumInterface "" "fog"\n{HEAD}'
    scene = read(f'{SPHERE}\nMediumInterface "fog" ""\n{SPHERE}', head)
    assert scene.camera.camera.medium == "fog"
    first, second = scene.nodes.values()
    assert (first.interior, first.exterior) == ("vacuum", "fog")
    assert (second.interior, second.exterior) == ("fog", "vacuum")


def test_integrators_that_do_not_see_media_pass_through():
    body = f'{FOG}\nMediumInterface "fog" ""\n{SPHERE}'
    scene = read(body, HEAD + 'Integrator "path"\n')
    assert scene.integrator.type == "path"
    assert not scene.media
    assert node(scene).interior is None
    assert any("does not see media" in note for note in scene.source.remarks.notes)
    # So does pbrt 3 if nothing is said.
    assert node(read_old(body)).interior is None


def test_a_grid_of_pbrt_3_scatters_like_milk():
    body = CLOUD.replace("uniformgrid", "heterogeneous") + '\nMediumInterface "cloud" ""\n' + SPHERE
    head = 'Camera "perspective"\nFilm "image" "integer xresolution" 8\nIntegrator "volpath"\n'
    [found] = read(body + "\nWorldEnd", head).media.values()
    assert found.type == "grid"
    assert found.sigma_s == (2.55, 3.21, 3.77)


def test_names_of_ours_give_way():
    body = FOG.replace("fog", "vacuum") + '\nMediumInterface "vacuum" ""\n' + SPHERE
    scene = read(body)
    [name] = scene.media
    assert name != "vacuum"
    assert (node(scene).interior, node(scene).exterior) == (name, "vacuum")


def test_a_shining_border_has_its_media_once():
    light = 'AreaLightSource "diffuse" "bool twosided" true\nShape "disk"'
    front, back = read(f'{FOG}\nMediumInterface "fog" ""\n{light}').nodes.values()
    assert (front.interior, front.exterior) == ("fog", "vacuum")
    assert (back.interior, back.exterior) == (None, None)


REFUSED = {
    'MakeNamedMedium "fog" "string type" "nanovdb" "string filename" "x.nvdb"': (
        'medium "nanovdb" is not covered'
    ),
    'MakeNamedMedium "fog"': 'needs "string type"',
    f"{FOG}\n{FOG}": "is given twice",
    f'{FOG} "string preset" "Skin11"': 'unknown medium "Skin11"; did you mean "Skin1"',
    f'{FOG} "rgb Le" [-1 1 1]': "must not shine less than 0",
    CLOUD.replace("cloud", "fog") + ' "float temperature" [1 2 3 4 5 6]': "give Le and Lescale",
    CLOUD.replace("cloud", "fog") + ' "rgb Le" [1 1 1] "float Lescale" [1 2]': "= 6 numbers, got 2",
    CLOUD.replace("cloud", "fog") + ' "float Lescale" [1 2 3 4 5 -6]': "[0, 1e+15], got -6",
    f'{FOG} "float g" 1': "must be in (-1, 1), got 1",
    f'{FOG} "float scale" -1': "must be >= 0, got -1",
    f'{FOG} "rgb sigma_a" [-1 0 0]': "must be >= 0, got -1",
    f'{FOG} "rgb sigma" [1 0 0]': 'unknown parameter "sigma"',
    CLOUD.replace("cloud", "fog") + ' "float densities" 1': 'unknown parameter "densities"',
    CLOUD.replace("cloud", "fog").replace("5 6", "5"): "must hold nx * ny * nz = 2 * 1 * 3",
    CLOUD.replace("cloud", "fog").replace("5 6", "5 -6"): "must be in [0, 1e+15], got -6",
    CLOUD.replace("cloud", "fog") + ' "point3 p1" [0 1 1]': "p0 and p1 must differ",
    'MakeNamedMedium "frog" "string type" "homogeneous"': 'unknown medium "fog"; did you mean',
}


@pytest.mark.parametrize("definition", REFUSED)
def test_media_that_are_refused(definition):
    [found] = messages(f'{definition}\nMediumInterface "fog" ""\n{SPHERE}')
    assert REFUSED[definition] in found


def test_lenient_reading_takes_empty_space_for_other_media():
    body = 'MakeNamedMedium "fog" "string type" "cloud" "float density" 3'
    scene = read(f'{body}\nMediumInterface "fog" ""\n{SPHERE}', lenient=True)
    assert scene.media["fog"] == native("media", "{type: homogeneous, sigma_t: 0}")
    assert any("empty space is taken" in warning for warning in scene.warnings)
    assert "cloud" not in COVERED


@pytest.mark.parametrize(
    "shape",
    [
        f'MediumInterface "fog" ""\n{SPHERE}',
        f'MediumInterface "" "fog"\nReverseOrientation\n{SPHERE}',
        f'MediumInterface "" "fog"\nScale -1 1 1\n{SPHERE}',
    ],
)
def test_light_through_a_ball_is_absorbed_on_the_side_that_was_meant(shape):
    head = 'LookAt 0 0 5  0 0 0  0 1 0\nCamera "perspective" "float fov" .1\n'
    head += 'Film "rgb" "integer xresolution" 8 "integer yresolution" 8\n'
    fog = f'{FOG} "rgb sigma_a" [0.5 0.5 0.5] "rgb sigma_s" [0 0 0]'
    body = f'LightSource "infinite"\n{fog}\n{shape}'
    scene = compile_scene(flatten(read(body, head)), structure="list")
    settings = make_settings(scene.integrator, seed=0, replicates=4)
    kernels = make_kernels(scene, compiled=False)
    samples = np.array([[[0, 16]]], np.int64)
    film, _ = render_tile(kernels, scene, settings, Tile(0, 0, 8, 8), samples)
    fixed_point.carry(film.sums)
    mean = fixed_point.to_float(film.sums)[..., :3].sum(axis=(0, 1, 2)) / film.counts.sum()
    # A ray comes through the diameter with the probability 1/e.
    wanted = np.exp(-1.0)
    error = np.sqrt(wanted * (1.0 - wanted) / film.counts.sum())
    assert np.abs(mean - wanted).max() < 3.0 * error


@pytest.mark.parametrize(
    ("g", "taken"), [(-0.95, -0.95), (0.98, 0.98), (0.999, 0.99), (-0.999, -0.99)]
)
def test_phase_functions_that_are_too_sharp_become_less_so(g, taken):
    fog = f'MakeNamedMedium "fog" "string type" "homogeneous" "float g" {g}'
    scene = read(f'{fog}\nMediumInterface "fog" ""\nMaterial "interface"\nShape "sphere"')
    assert scene.media["fog"].phase.g == pytest.approx(taken)
    assert any("0.99" in line for line in scene.warnings) == (abs(g) > 0.99)
