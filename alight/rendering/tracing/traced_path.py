"""A traced path: its vertices, what lights each of them, and a table of it all."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from alight.outputs import html

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Emission:
    """Light that the ray hit: radiance, density of light sampling for it, and MIS weight."""

    radiance: Triple
    light_pdf: float | None
    weight: float | None


@dataclass(frozen=True)
class LightSample:
    """Light that light sampling chose.

    Attributes
    ----------
    wi, distance
        Unit direction in the world, and metres.
    radiance, pdf, delta
        As in `alight.lights.tables.LightSample`, the choice of the light included.
    f_cos, bsdf_pdf
        Of the BSDF, for that direction; None where nothing can arrive.
    visible : bool or None
        None where no shadow ray was needed.
    weight : float or None
        For MIS.
    """

    wi: Triple
    distance: float
    radiance: Triple
    pdf: float
    delta: bool
    f_cos: Triple | None
    bsdf_pdf: float | None
    visible: bool | None
    weight: float | None


@dataclass(frozen=True)
class Scattering:
    """How the path continues: local direction, weight f cos / pdf, density, and the lobe's name.

    In a medium the direction is that in the world, and the lobe "phase".
    """

    wi: Triple
    weight: Triple
    pdf: float
    lobe: str


@dataclass(frozen=True)
class Vertex:
    """One vertex of a path.

    Attributes
    ----------
    depth : int
        Edges from the camera.
    origin, direction : triple
        Of the ray that was followed to it.
    beta : triple
        Throughput of the path up to here.
    pdf : float
        Density of `direction` per steradian, 0 for camera rays.
    delta : bool
        Whether `direction` was chosen by a delta lobe, or by the camera.
    t : float
        Length of the ray, metres; infinite if it left the scene. The following are None then.
    position, normal : triple or None
        In the world, metres; the shading normal. A collision in a medium has no normal.
    shape, bsdf : str or None
        Path of the node in the scene graph, and type of the material; None in a medium.
    primitive : int or None
    emission, light, scattering
        What happened there; None for what did not.
    contribution : triple
        What it added to the radiance of the path.
    """

    depth: int
    origin: Triple
    direction: Triple
    beta: Triple
    pdf: float
    delta: bool
    t: float
    position: Triple | None
    normal: Triple | None
    shape: str | None
    bsdf: str | None
    primitive: int | None
    emission: Emission | None
    light: LightSample | None
    scattering: Scattering | None
    contribution: Triple


@dataclass(frozen=True)
class Trace:
    """One sample of one pixel.

    Attributes
    ----------
    scene, integrator, sampler, filter : str
    size : (int, int)
        Pixels of the film.
    pixel : (int, int)
    sample, seed, replicate : int
    weight : float
        Of the pixel filter: the first throughput.
    vertices : tuple of Vertex
    radiance : triple
        What the path gathered.
    value : triple
        What the film adds: the radiance, rounded to its fixed point; zero if `valid` is False.
    valid : bool
        Whether the radiance is a finite number in every channel.
    rays : int
    """

    scene: str
    integrator: str
    sampler: str
    filter: str
    size: tuple[int, int]
    pixel: tuple[int, int]
    sample: int
    seed: int
    replicate: int
    weight: float
    vertices: tuple[Vertex, ...]
    radiance: Triple
    value: Triple
    valid: bool
    rays: int

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON; numbers that are not finite become None."""
        return _plain(asdict(self))

    def __str__(self) -> str:
        """The table that ``alight trace`` prints."""
        from alight.rendering.tracing.trace_table import table_of

        return "\n".join(table_of(self))

    def _repr_html_(self) -> str:
        """Show the table in a notebook."""
        return html.preformatted(str(self).splitlines())


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
