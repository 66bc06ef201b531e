"""Laws of dispersion: what Abbe's number means, the index that kernels use, and who is asked."""

import json
import re
from collections import namedtuple
from types import SimpleNamespace

import numpy as np
import pytest

from alight.bsdfs.dielectrics.dielectric import Dielectric
from alight.bsdfs.dielectrics.dispersion import (
    SUBSTANCES,
    Dispersive,
    index_at,
    indices,
    pack_spread,
)
from alight.bsdfs.model import BSDFS
from alight.core.errors import SceneError
from alight.core.registry import specs
from alight.core.spec import Integrator
from alight.core.wavelengths import DISPERSIVE, LINE_C, LINE_D, LINE_F, LONGEST, SHORTEST
from alight.formats import loads
from lanewise.jit import instantiate
from lanewise.view import View

RNG = np.random.default_rng(5)
Program = namedtuple("Program", "bsdfs")
KINDS = [*SUBSTANCES, 30.0, (1.5046, 0.0042)]


def test_abbes_number_compares_the_lines_f_and_c():
    for number, n_d in zip(RNG.uniform(20.0, 90.0, 20), RNG.uniform(1.4, 2.0, 20), strict=True):
        d, f, c = indices(number, 1e-3 * np.array([LINE_D, LINE_F, LINE_C]), n_d)
        assert d == pytest.approx(n_d, rel=1e-12)
        # Blue light, that of F, is refracted more than red light.
        assert (n_d - 1.0) / (f - c) == pytest.approx(number, rel=1e-9)


@pytest.mark.parametrize("dispersion", KINDS)
@pytest.mark.parametrize("outside", [1.0, 1.33])
def test_kernels_have_the_index_over_that_outside(dispersion, outside):
    n_d = Dielectric(dispersion=dispersion).int_ior
    row = [n_d / outside]
    pack_spread(SimpleNamespace(numbers=lambda _, *n: row.extend(n)), dispersion, n_d, outside)
    at = np.linspace(SHORTEST, LONGEST, 35, dtype=np.float32)
    scene = SimpleNamespace(materials=SimpleNamespace(data=View(np.array(row, np.float32))))
    ask = instantiate(index_at, Program((DISPERSIVE,)), compiled=False)
    found = ask(scene, np.zeros(len(at), np.uint32), SimpleNamespace(wavelength=at))
    wanted = indices(dispersion, 1e-3 * at.astype(float), n_d) / outside
    np.testing.assert_allclose(found, wanted, rtol=6e-5)


GLASS = {"type": "dielectric", "dispersion": 30.0}
HALF = {"type": "blend", "bsdfs": [{"type": "diffuse"}, "glass"]}
#: Where a material may stand: what is added to a scene.
PLACES = {
    "in its node": {"nodes": {"a": {"shape": "sphere", "bsdf": GLASS}}},
    "by name": {"nodes": {"a": {"shape": "sphere", "bsdf": "glass"}}},
    "as a part": {"nodes": {"a": {"shape": "sphere", "bsdf": HALF}}},
    "as a part of what has a name": {"nodes": {"a": {"shape": "sphere", "bsdf": "half"}}},
    "below a node": {"nodes": {"b": {"children": {"a": {"shape": "sphere", "bsdf": "glass"}}}}},
    "in a prototype": {
        "prototypes": {"p": {"shape": "sphere", "bsdf": HALF}}, "nodes": {"b": {"instance": "p"}},
    },
}  # fmt: skip


def scene_with(place, integrator):
    bsdfs = {"glass": GLASS, "half": HALF}
    lamp = {"light": {"type": "point", "intensity": 1.0}}
    data = {"alight": 1, "camera": {}, "integrator": integrator, "bsdfs": bsdfs, **PLACES[place]}
    return loads(json.dumps(data | {"nodes": {**data["nodes"], "lamp": lamp}}))


def refusal(place, integrator):
    """What is said against it, if it is about dispersion."""
    try:
        scene_with(place, integrator)
    except SceneError as error:
        # It is the integrator that is to be another one.
        assert [issue.path for issue in error.issues] == ["integrator"]
        return re.search("does not see that materials disperse light", str(error))[0]
    return ""


@pytest.mark.parametrize("place", PLACES)
def test_integrators_that_see_no_wavelengths_refuse_them_wherever_they_stand(place):
    for name, spec in specs("integrators").items():
        assert issubclass(spec, Integrator)
        sees = spec.sees_dispersion or not spec().needs_light
        assert refusal(place, name) == (
            "" if sees else "does not see that materials disperse light"
        )


def test_every_material_that_may_disperse_light_says_so_to_its_program():
    glass = {"transmission": 1.0}
    found = {name for name, spec in specs("bsdfs").items() if issubclass(spec, Dispersive)}
    assert found
    for name in found:
        spec = specs("bsdfs")[name]
        made = spec(dispersion=30.0, **{k: v for k, v in glass.items() if k in spec.model_fields})
        assert DISPERSIVE in BSDFS[name].features(made)
        assert DISPERSIVE not in BSDFS[name].features(made.replaced(dispersion=0.0))
