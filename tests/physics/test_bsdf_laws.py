"""Energy, white furnace and reciprocity of every registered BSDF example."""

from alight.bsdfs.uniform_scatter import UniformScatter
from alight.laws import bsdfs as laws
from tests.sampling.materials import Material, each_example, each_spec


@each_example
def test_no_more_light_leaves_than_arrives(spec, cosine):
    laws.no_energy_is_created(Material(spec), cosine)


@each_spec
def test_white_furnace_of_lossless_models(spec):
    laws.white_furnace(Material(spec))


@each_example
def test_values_are_neither_negative_nor_infinite(spec, cosine):
    laws.values_are_finite(Material(spec), cosine)


@each_spec
def test_reciprocity_is_as_declared(spec):
    laws.reciprocity_is_as_declared(Material(spec))


def test_uniform_scatter_is_the_model_that_is_not_reciprocal():
    assert not Material(UniformScatter()).is_reciprocal()


@each_example
def test_light_goes_back_the_way_it_came(spec, cosine):
    laws.light_goes_back_the_way_it_came(Material(spec), cosine)


@each_example
def test_models_without_a_back_are_black_there(spec, cosine):
    laws.models_without_a_back_are_black(Material(spec), cosine)
