"""Validated, immutable descriptions: the base class of all models, and one of each family.

A description is data only. It is checked when it is made, so kernels never check anything. What
others must know of a model, its class says by members that the base class of its family declares.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, field_validator, model_validator

from alight.core.errors import Issue, SceneError, join_path
from alight.core.field_errors import translate
from alight.core.fields import Interval, Model, Numbers, Truth, invalid


class Spec(BaseModel):
    """Base class of all model descriptions: immutable, unknown keys refused.

    Attributes
    ----------
    family : str
        Package that holds the models of this kind, for instance ``bsdfs``.
    kind : str
        Singular of the family, used in messages.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    family: ClassVar[str] = ""
    kind: ClassVar[str] = ""

    def __init__(self, /, **data: Any) -> None:
        """Make a description from its fields.

        Raises
        ------
        SceneError
            With one issue for each field that is wrong.
        """
        try:
            self.__pydantic_validator__.validate_python(data, self_instance=self)
        except ValidationError as error:
            raise SceneError(
                [issue.under(self.type_name()) for issue in translate(type(self), error)]
            ) from None

    # pydantic then skips this constructor when it validates, as for its own base class.
    __init__.__pydantic_base_init__ = True  # pyright: ignore[reportFunctionMemberAccess]

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse changes of fields, and say how they are made."""
        if name not in type(self).model_fields:
            return super().__setattr__(name, value)
        text = f"never changes; make another one: .replaced({name}=...)"
        way = 'for a whole scene: alight.changed(scene, {"path.to.key": value})'
        raise SceneError([Issue(join_path(self.type_name(), name), f"{text}, or {way}")])

    @field_validator("file", mode="before", check_fields=False)
    @classmethod
    def _as_text(cls, file: object) -> object:
        return os.fspath(file) if isinstance(file, os.PathLike) else file

    @classmethod
    def type_name(cls) -> str:
        """Name in scene files, or the class name where there is no choice of type."""
        field = cls.model_fields.get("type")
        return field.default if field else cls.__name__.lower()

    def replaced(self, **changes: Any) -> Self:
        """Make a checked copy with some fields changed."""
        return type(self)(**{**dict(self), **changes})


class Bsdf(Spec):
    """Base class of scattering models.

    Attributes
    ----------
    transmissive : bool
        Light may come from the other side.
    shares : tuple of str
        Reflectances that are together at most 1.
    one_sided : bool
        Other than by delta lobes, only light from the viewer's side of the shading normal reaches
        it. What is made of other materials leaves that to them.
    unseen : bool
        Light passes it as if nothing was there.
    matte : bool
        What it reflects about the mirrored direction is next to nothing, or little beside the rest.
    """

    family: ClassVar[str] = "bsdfs"
    kind: ClassVar[str] = "bsdf"
    transmissive: ClassVar[bool] = False
    shares: ClassVar[tuple[str, ...]] = ()
    one_sided: ClassVar[bool] = False
    unseen: ClassVar[bool] = False
    matte: ClassVar[bool] = False

    def largest_weight(self) -> float | None:
        """Bound of f cos / pdf of sampled directions; None if none is known."""
        return None

    def read(self, files: Any) -> Self:
        """Take numbers from the file that it names, by `files.read`; pictures are for others.

        Raises
        ------
        SceneError
            If the file is missing or broken; its path is ``file``.
        """
        return self


def largest_of(values: Iterable[float | None]) -> float | None:
    """The largest of all, at least 0; None if one is unknown."""
    found = list(values)
    return None if None in found else max([0.0, *filter(None, found)])


def largest_channel(value: Any) -> float | None:
    """Bound of a colour, a number or a texture; None for names."""
    if isinstance(value, Texture):
        value = value.maximum()
    return None if isinstance(value, str) else float(np.max(value))


def _is_color(marker: object) -> bool:
    """Whether the metadata of a field say that it holds an amount of light in three channels."""
    return isinstance(marker, Numbers) and marker.count == 3 and marker.interval.low == 0.0


def _is_dark(color: tuple[float, float, float] | Texture | str) -> bool:
    """Whether a colour is 0; what names and unread files hold is not known yet."""
    if isinstance(color, Texture):
        return getattr(color, "file", None) is None and color.maximum() == (0.0, 0.0, 0.0)
    return color == (0.0, 0.0, 0.0)


class Light(Spec):
    """Base class of lights.

    Attributes
    ----------
    placement : {"node", "shape", "environment"}
        Where a scene may place one.
    has_place : bool
        Around the scene, and yet at a place: a rectangle through which the others are seen.
    """

    family: ClassVar[str] = "lights"
    kind: ClassVar[str] = "light"
    placement: ClassVar[Literal["node", "shape", "environment"]] = "node"
    has_place: ClassVar[bool] = False

    @property
    def is_black(self) -> bool:
        """Whether it emits nothing: all of its colours are 0, as far as textures are known."""
        fields = type(self).model_fields
        colors = [value for name, value in self if any(map(_is_color, fields[name].metadata))]
        return bool(colors) and all(map(_is_dark, colors))

    def largest_radiance(self) -> float | None:
        """Bound of the radiance that it emits; None if none is known."""
        return None

    def read(self, files: Any) -> Self:
        """Take numbers from the file that it names, by `files.read`; pictures are for others.

        Raises
        ------
        SceneError
            If the file is missing or broken; its path is ``file``.
        """
        return self


class Texture(Spec):
    """Base class of textures: colours over a surface, which most of them let vary there."""

    family: ClassVar[str] = "textures"
    kind: ClassVar[str] = "texture"
    varies: ClassVar[bool] = True

    @property
    def mean_is_exact(self) -> bool:
        """Whether `mean` is that over the plane of (u, v), and no estimate."""
        return not self.varies

    def maximum(self) -> tuple[float, float, float]:
        """Largest value of each channel."""
        return (1.0, 1.0, 1.0)

    def mean(self) -> tuple[float, float, float]:
        """Mean of each channel over the square of (u, v); above 0 where any value is."""
        return self.maximum()

    def set_of_coordinates(self) -> int | None:
        """The set of texture coordinates that it is looked up in; None if in none."""
        return None

    def lookup(self) -> np.ndarray | None:
        """From (u, v) of its set to where it is looked up, (2, 3) float64; None if in none."""
        return None


class Shape(Spec):
    """Base class of shapes; `finite` ones can be lights, `closed` ones have an inside."""

    family: ClassVar[str] = "shapes"
    kind: ClassVar[str] = "shape"
    finite: ClassVar[bool] = True
    closed: ClassVar[bool] = False
    flip_normals: Truth = False

    def parts(self) -> tuple[tuple[Shape, np.ndarray], ...]:
        """The shapes that it is made of, each with its (4, 4) matrix; none for most."""
        return ()

    def edges(self) -> np.ndarray:
        """Points (n, 3) on the edges of an open surface, in its own space; none by default."""
        return np.zeros((0, 3))


class PhaseFunction(Spec):
    """Base class of phase functions: where light goes that a medium scatters."""

    family: ClassVar[str] = "phases"
    kind: ClassVar[str] = "phase function"


class Medium(Spec):
    """What fills the space between surfaces; with `has_place` it does not move with shapes."""

    family: ClassVar[str] = "media"
    kind: ClassVar[str] = "medium"
    has_place: ClassVar[bool] = False

    def problem(self) -> str | None:
        """Say why it cannot be rendered, now that its files are read."""
        return None


class Camera(Spec):
    """Base class of cameras.

    Parameters
    ----------
    medium : Medium or str, optional
        What surrounds the camera, if not the scene's own.
    shutter : (float, float), default (0, 1)
        Times at which it opens and closes, in the unit of the keyframes of what moves.
    """

    family: ClassVar[str] = "cameras"
    kind: ClassVar[str] = "camera"
    medium: Annotated[Medium | str, Model("medium", "media", named=True)] | None = None
    shutter: Annotated[tuple[float, float], Numbers(2, Interval())] = (0.0, 1.0)

    @model_validator(mode="after")
    def _closes_after_opening(self) -> Self:
        begin, end = self.shutter
        if end < begin:
            text = "shutter [open, close] must not close before it opens"
            raise invalid(f"{text}, got [{begin:g}, {end:g}]")
        return self


class Sampler(Spec):
    """Base class of samplers.

    Attributes
    ----------
    block : int
        It is made for so many samples, doubled any number of times.
    independent : bool
        Samples know nothing of each other.
    """

    family: ClassVar[str] = "samplers"
    kind: ClassVar[str] = "sampler"
    block: ClassVar[int] = 1
    independent: ClassVar[bool] = False

    def with_block(self, samples: int) -> Self:
        """The same with blocks of at most so many samples, if it has blocks."""
        return self


class Filter(Spec):
    """Base class of pixel filters; `largest_weight` of their samples, None if none is known."""

    family: ClassVar[str] = "filters"
    kind: ClassVar[str] = "filter"
    largest_weight: ClassVar[float | None] = None


class ToneCurve(Spec):
    """Base class of tone curves: how a display shows light that is brighter than it."""

    family: ClassVar[str] = "tone_curves"
    kind: ClassVar[str] = "tone curve"


class Integrator(Spec):
    """Base class of integrators.

    Attributes
    ----------
    needs_light : bool
        A dark scene gives a black picture.
    sees_media, walks_inside, sees_dispersion : bool
        Media, bodies that scatter inside, and materials that disperse light play their part; those
        that follow light must say so.
    transports : bool
        Its picture is the light of all paths of at most `longest_path` edges, as of all its kind.
    splats : bool
        Paths start at lights and find their own pixels.
    """

    family: ClassVar[str] = "integrators"
    kind: ClassVar[str] = "integrator"
    needs_light: ClassVar[bool] = True
    sees_media: ClassVar[bool] = False
    walks_inside: ClassVar[bool] = False
    sees_dispersion: ClassVar[bool] = False
    transports: ClassVar[bool] = False
    splats: ClassVar[bool] = False

    @property
    def longest_path(self) -> int | None:
        """Edges of the longest path; None without a limit."""
        return None

    @property
    def choice_of_lights(self) -> str:
        """How light sampling chooses a light, see `alight.integrators.options.LightSampling`."""
        return "auto"

    @property
    def combines(self) -> bool:
        """Whether light sampling and BSDF sampling share the work by weights."""
        return False

    @property
    def finds_light_by_chance(self) -> bool:
        """Whether no path is led to a light."""
        return False

    @property
    def wants_guide(self) -> bool:
        """Whether a guide is trained before the picture is rendered."""
        return False

    @property
    def way_of_guiding(self) -> str:
        """How, see `alight.integrators.options.PathTracing`."""
        return "off"

    @property
    def aims_at_lamps(self) -> bool:
        """Whether paths look for whole lamps, see `alight.lights.targets`."""
        return False

    def largest_sample(self, radiance: float, weight: float, start: float) -> float | None:
        """Bound of a sample where no light is at a point; None if none is known.

        `radiance` is the brightest light's, `weight` the largest f cos / pdf, `start` a camera's.
        """
        return None
