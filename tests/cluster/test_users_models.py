"""Models of scripts render on workers that have never seen the scripts: code travels, text not."""

from pathlib import Path
from types import SimpleNamespace

import pytest

import alight
from alight.compiled.scene import compile_scene
from alight.core.errors import OptionError
from alight.core.registration import unregister
from alight.core.registry import FAMILIES_OF_SCENES, Models
from alight.formats import loads
from alight.lab.replicates.spread import Spread
from alight.lab.run import run_study
from alight.lab.study import ArmSpec, ReferenceSpec, SceneSpec, Study
from alight.options.cluster import ClusterOptions
from alight.scene import flatten
from tests.cluster.test_films import assert_same_film
from tests.cluster.workers import two_workers
from tests.extension.models import module_of

#: A model of each family, of which the test makes one of a user.
MODELS = {
    "shapes": "sphere",
    "bsdfs": "diffuse",
    "textures": "checkerboard",
    "lights": "point",
    "cameras": "pinhole",
    "samplers": "independent",
    "filters": "tent",
    "phases": "isotropic",
    "media": "homogeneous",
    "integrators": "volpath",
}

SCENE = """
alight: 1
camera: {type: my_pinhole, fov: 40, transform: {translate: [0, 0, 6]}}
film: {size: [24, 16], filter: my_tent}
sampler: my_independent
integrator: {type: my_volpath, max_depth: 4, guiding: "GUIDING"}
medium: fog
media: {fog: {type: my_homogeneous, sigma_t: 0.1, albedo: 0.8, phase: my_isotropic}}
nodes:
  lamp: {light: {type: my_point, intensity: 30}, transform: {translate: [1, 2, 3]}}
  ball:
    shape: {type: my_sphere, radius: 0.9}
    bsdf: {type: my_diffuse, reflectance: {type: my_checkerboard, color1: 0.8}}
"""


@pytest.fixture(scope="module", autouse=True)
def registered():
    for family, name in MODELS.items():
        text = Path(Models(family)[name].__file__).read_text()
        alight.register(module_of(text.replace(f'"{name}"', f'"my_{name}"'), f"users_{name}"))
    yield
    for family, name in MODELS.items():
        unregister(family, f"my_{name}")


@pytest.fixture(scope="module")
def client():
    with two_workers() as client:
        yield client


def scene(guiding="off"):
    return loads(SCENE.replace("GUIDING", guiding), "users")


def test_models_of_every_family_render_with_the_same_bits(client):
    assert MODELS.keys() == set(FAMILIES_OF_SCENES)
    own = alight.render(scene(), spp=8, threads=1)
    film = alight.render(scene(), spp=8, cluster=client)
    assert own.image.min() > 0.0
    assert_same_film(film, own)
    told = film.stats["cluster"]
    assert (told.get("failed", 0), told.get("done_here", 0), told["refused"]) == (0, 0, {})


def test_a_study_spreads_them_too(client, tmp_path, caplog):
    (tmp_path / "users.yaml").write_text(SCENE.replace("GUIDING", "off"))
    scene = SceneSpec(str(tmp_path / "users.yaml"), reference=ReferenceSpec(spp=8192))
    arms = (ArmSpec("deep", {"max_depth": 4}), ArmSpec("again", {"max_depth": 4}))
    study = Study("users", arms=arms, scenes=[scene], spp=(2,), replicates=4,
                  baseline="deep", equal_time=False)  # fmt: skip
    options = ClusterOptions(cluster=client)
    found = [
        run_study(study, tmp_path / "own"),
        run_study(study, tmp_path / "theirs", cluster=options),
    ]
    errors = [
        [point.mse.value for arm in each.scenes[0].arms for point in arm.samples] for each in found
    ]
    assert errors[0] == errors[1]
    assert not [line for line in caplog.messages if "failed" in line]


def test_guides_are_not_trained_by_workers_that_know_no_scripts(client):
    arm = SimpleNamespace(spec=ArmSpec("guided"), compiled=compile_scene(flatten(scene("on"))))
    with pytest.raises(OptionError, match="do not know the models of scripts"):
        Spread(client, equal_time=False).render([arm], [], 1.0, print)
