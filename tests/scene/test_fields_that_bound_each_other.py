"""Fields whose bounds are other fields: right up to the border, wrong beyond it."""

import itertools
from contextlib import nullcontext

import pytest

from alight.bsdfs.conductors.rough_conductor import RoughConductor
from alight.bsdfs.dielectrics.rough_dielectric import RoughDielectric
from alight.core.errors import SceneError
from alight.lights.projector import Projector
from alight.lights.spot import Spot
from alight.scene.description import FilmSettings

WHITE = (((1.0, 1.0, 1.0),),)


def is_taken(make, **keys):
    try:
        make(**keys)
    except SceneError as error:
        assert "must" in str(error)
        return False
    return True


def test_a_crop_lies_inside_of_its_picture():
    edges = (0, 3, 4, 5, 9, 10)
    size = (10, 5)
    for x, y, w, h in itertools.product(edges, repeat=4):
        inside = 1 <= w <= 10 - x and 1 <= h <= 5 - y
        assert is_taken(FilmSettings, size=size, crop=(x, y, w, h)) == inside, (x, y, w, h)


@pytest.mark.parametrize("cutoff", [None, 30.0])
@pytest.mark.parametrize("beam", [0.0, 20.0, 30.0, 31.0])
def test_no_beam_is_wider_than_its_cone(cutoff, beam):
    within = beam <= (0.0 if cutoff is None else cutoff)
    assert is_taken(Projector, pixels=WHITE, cutoff_angle=cutoff, beam_width=beam) == within
    if cutoff is not None:
        assert is_taken(Spot, cutoff_angle=cutoff, beam_width=beam) == within


@pytest.mark.parametrize("kind", [RoughConductor, RoughDielectric])
def test_two_roughnesses_come_together_and_without_a_third(kind):
    for alpha, u, v in itertools.product((None, 0.2), repeat=3):
        keys = {"alpha": alpha, "alpha_u": u, "alpha_v": v}
        fits = (u is None) == (v is None) and (alpha is None or u is None)
        with nullcontext() if fits else pytest.raises(SceneError, match="takes"):
            kind(**keys)
