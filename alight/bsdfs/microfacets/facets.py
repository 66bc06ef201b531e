"""What the rough models share: their roughness and their distribution of facets.

Scenes whose roughness is the same in all directions do not look tangents up, and only the
distributions in use are compiled.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import model_validator

from alight.core.field_types import SMOOTHEST
from alight.core.fields import Interval, NumberOrTexture, invalid
from alight.core.microfacet import FEATURES, Facets
from alight.core.parameters import Slots, loader, slots_of
from alight.core.spec import Bsdf, Texture
from alight.textures.fetch import Scalar, TexturedScalar
from lanewise.jit import kernel, specialised
from lanewise.simd import maximum

#: What programs call roughness that depends on the direction.
ANISOTROPIC = "anisotropic"

# A number as `Roughness`, or nothing.
Alpha = Annotated[
    float | Texture | str | None,
    NumberOrTexture(Interval(SMOOTHEST, 1.0), other=(str, Texture, type(None))),
]


class Rough(Bsdf):
    """Base class of models with facets.

    Parameters
    ----------
    distribution : {"ggx", "beckmann"}, default "ggx"
        Distribution of the facets' normals; GGX has the longer tail.
    alpha : float in [0.0001, 1] or texture, optional
        Roughness; 0.1 where nothing is given. Of Beckmann's distribution it is the root mean
        square slope.
    alpha_u, alpha_v : float in [0.0001, 1] or texture, optional
        Roughness along the tangent, and at right angles to it, in place of `alpha`.
    """

    distribution: Literal["ggx", "beckmann"] = "ggx"
    alpha: Alpha = None
    alpha_u: Alpha = None
    alpha_v: Alpha = None

    @model_validator(mode="after")
    def _has_one_roughness(self) -> Self:
        if (self.alpha_u is None) != (self.alpha_v is None):
            raise invalid("takes alpha_u and alpha_v together, got only one of them")
        if self.alpha is not None and self.alpha_u is not None:
            raise invalid("takes either alpha or alpha_u and alpha_v, got both")
        return self

    @property
    def roughness(self) -> tuple[float | Texture | str, float | Texture | str]:
        """Along the tangent, and at right angles to it."""
        if self.alpha_u is not None and self.alpha_v is not None:
            return self.alpha_u, self.alpha_v
        alpha = 0.1 if self.alpha is None else self.alpha
        return alpha, alpha


def facet_features(spec: Rough) -> tuple[str, ...]:
    """What must be compiled for the facets of this material."""
    along, across = spec.roughness
    names = (FEATURES[spec.distribution],)
    return names if along == across else (*names, ANISOTROPIC)


def pack_facets(spec: Rough, packer) -> None:
    """Fill the slots of `FacetRow`."""
    along, across = spec.roughness
    packer.scalar("alpha_u", along)
    packer.scalar("alpha_v", across)
    packer.numbers("beckmann", float(spec.distribution == "beckmann"))


class FacetRow(NamedTuple):
    """How facets lie in a row of the table."""

    alpha_u: TexturedScalar
    alpha_v: TexturedScalar
    beckmann: Scalar


class IsotropicRow(NamedTuple):
    """The same where both are alike: the texture of one of them is not looked up."""

    alpha: TexturedScalar
    alpha_v: Scalar
    beckmann: Scalar


_load_facets, _load_isotropic = loader(FacetRow), loader(IsotropicRow)


@specialised
def _facets_at(program):
    """``(scene, slot, surface) -> Facets``, from the slots of a `FacetRow`."""
    if ANISOTROPIC in program.bsdfs:

        @kernel
        def anisotropic(scene, slot, surface):
            row = _load_facets(scene, slot, surface)
            along, across = maximum(row.alpha_u, SMOOTHEST), maximum(row.alpha_v, SMOOTHEST)
            return Facets(along, across, row.beckmann)

        return anisotropic

    @kernel
    def isotropic(scene, slot, surface):
        row = _load_isotropic(scene, slot, surface)
        alpha = maximum(row.alpha, SMOOTHEST)
        return Facets(alpha, alpha, row.beckmann)

    return isotropic


#: Field of a record of parameters.
FacetsOfRow = Annotated[Any, Slots(_facets_at, slots_of(FacetRow))]
