"""``MakeNamedMedium`` and ``MediumInterface`` -> media of the native format.

A surface is a border of media in pbrt only where the names of both sides differ; elsewhere a path
stays in the medium that it is in. Which medium is meant is settled at the end of the file, so that
names may be used before they are explained.

Between the centres of the outermost cells of a grid and its box the density of pbrt falls to what
lies outside, 0; ours stays. So grids get a rim of empty cells: the same density everywhere in the
box that the file gives.

Source: pbrt-v4, documentation of the file format, "Participating media"; PBR4 section 11.4.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from alight.core.errors import join_path, quote, unknown_name
from alight.formats.materials.substances import SUBSTANCES
from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive, Parameter
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.transforms import scaling, translation
from alight.media.volumes import Volume
from alight.scene.description import VACUUM
from alight.shapes.strands import StrandShape

#: Our names of pbrt's media; the last one is pbrt 3's word for a grid.
COVERED = {
    "homogeneous": "homogeneous",
    "uniformgrid": "grid",
    "heterogeneous": "grid",
    "rgbgrid": "grid",
}
#: Why some media are not covered, and the way out.
_WAYS_OUT = {
    "nanovdb": "convert the volume to a uniformgrid",
    "cloud": "a uniformgrid can hold one",
}
#: Integrators that see media; the others pass through them as through empty space.
SEEING = ("volpath", "simplevolpath", "bdpt", "mlt")
#: What media absorb and scatter that say nothing: whole milk, per mm.
_MILK = {"sigma_a": (0.0011, 0.0024, 0.014), "sigma_s": (2.55, 3.21, 3.77)}
_LARGEST_G = 0.99
#: Cells around a grid, which hold 0.
_RIM = ((1, 1), (1, 1), (1, 1), (0, 0))
#: What takes the place of a medium that is none of these.
EMPTY: Data = {"type": "homogeneous", "sigma_t": 0.0}


class Media:
    """The media of a scene by name.

    Parameters
    ----------
    context : Context
        Its table ``media`` receives those that are used.
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self._made: dict[str, tuple[Directive, Data]] = {}
        # By pbrt's name: ours, and the directive that asked first.
        self._used: dict[str, tuple[str, Directive]] = {}
        # Nothing in the file may have the name of empty space.
        context.free_name("media", VACUUM)

    def define(
        self, directive: Directive, defaults: Sequence[Parameter], matrix: np.ndarray
    ) -> None:
        """Follow MakeNamedMedium.

        Parameters
        ----------
        directive : Directive
        defaults : sequence of Parameter
            Those of ``Attribute``.
        matrix : (4, 4) float64
            From the space of the medium to the world.
        """
        report = self.context.report
        if directive.type in self._made:
            first = self._made[directive.type][0].place
            report.error(directive, f"is given twice, first at {first}")
            return
        p = Parameters(directive, report, defaults)
        self._made[directive.type] = (directive, _medium(self.context, p, matrix))
        p.finish()

    def sides(self, interface: Directive | None, shape: object = None) -> Data:
        """The keys ``interior`` and ``exterior`` of a surface; none where it is no border."""
        if interface is None or interface.texts[0] == interface.texts[1]:
            return {}
        if isinstance(shape, StrandShape):
            text = "plays no part at curves: they are met from outside only"
            self.context.report.warn(interface, text)
            return {}
        inside, outside = (self._name(interface, text) for text in interface.texts)
        return {"interior": inside, "exterior": outside} if self.context.sees_media else {}

    def around_camera(self, interface: Directive | None) -> Data:
        """The key ``medium`` of a camera; none in empty space."""
        if interface is None or not interface.texts[1]:
            return {}
        name = self._name(interface, interface.texts[1])
        return {"medium": name} if self.context.sees_media else {}

    def _name(self, interface: Directive, wanted: str) -> str:
        """Our name of a medium that a directive asks for."""
        if not wanted:
            return VACUUM
        if not self.context.sees_media:
            text = "plays no part: the integrator does not see media"
            self.context.report.note(interface, text)
        if wanted not in self._used:
            self._used[wanted] = (self.context.free_name("media", wanted), interface)
        return self._used[wanted][0]

    def close(self) -> bool:
        """Report what is missing and what is not used; tell whether any medium plays a part."""
        report = self.context.report
        for wanted, (name, interface) in self._used.items():
            if wanted not in self._made:
                known = unknown_name("medium", wanted, self._made, listed_as="named media")
                report.error(interface, known)
            if self.context.sees_media:
                directive, data = self._made.get(wanted, (interface, EMPTY))
                self.context.tables.setdefault("media", {})[name] = data
                self.context.places[join_path("media", name)] = directive.place
        for wanted, (directive, _) in self._made.items():
            if wanted not in self._used:
                report.note(directive, "is not used: no surface has it")
        return self.context.sees_media and bool(self._used)


def _medium(context: Context, p: Parameters, matrix: np.ndarray) -> Data:
    """Convert the parameters of a medium; empty space after a problem."""
    kind = p.text("type")
    if kind not in COVERED:
        if kind in _WAYS_OUT:
            text = f"medium {quote(kind)} is not covered: {_WAYS_OUT[kind]}"
            context.report.not_covered(p.directive, text, "empty space is taken")
        elif p.has("type"):
            context.report.unknown(p.directive, "medium", kind, COVERED, "empty space is taken")
        else:
            context.report.error(p.directive, 'needs "string type"')
        p.forget()
        return EMPTY
    data: Data = {"type": COVERED[kind]}
    if kind == "rgbgrid":
        return _colored_grid(context, p, data, matrix)
    # A grid of pbrt 4 has coefficients of 1, all others those of milk.
    milk = kind != "uniformgrid"
    known = _preset(context, p)
    for key, usual in known.items():
        data[key] = _color(context, p, key, usual if milk else (1.0, 1.0, 1.0))
    scale = p.number("scale", 1.0)
    if scale < 0.0:
        context.report.error(p.named["scale"], f"must be >= 0, got {scale:g}")
    elif scale != 1.0:
        # A factor of 0 makes empty space, which ours do not allow.
        for key in _MILK:
            data[key] = [scale * channel for channel in data[key]]
    _shine(context, p, data)
    _phase(context, p, data)
    if data["type"] == "grid":
        _grid(context, p, data, matrix)
    return data


def _preset(context: Context, p: Parameters) -> dict[str, tuple[float, float, float]]:
    """Coefficients where the file gives none."""
    name = p.text("preset")
    if name and name not in SUBSTANCES:
        message = unknown_name("medium", name, SUBSTANCES, listed_as="known")
        context.report.not_covered(p.named["preset"], message, "whole milk is taken")
    if name not in SUBSTANCES:
        return _MILK
    scattered, absorbed = SUBSTANCES[name]
    if p.number("g", 0.0) != 0.0:
        text = "is left out: what is known of the medium holds for scattering to all sides alike"
        context.report.warn(p.named.pop("g"), text)
    return {"sigma_a": absorbed, "sigma_s": scattered}


def _colored_grid(context: Context, p: Parameters, data: Data, matrix: np.ndarray) -> Data:
    """Convert an ``rgbgrid``: densities, and the parts of the colours that scatter."""
    report = context.report
    count = _count(p)
    cells = max(count[0] * count[1] * count[2], 0)
    found = [p.values(key, "rgb") for key in _MILK]
    scale = p.number("scale", 1.0)
    p.leave_out("such grids do not shine here", "Le", "Lescale")
    for parameter in found:
        if parameter is not None and len(parameter.values) != 3 * cells:
            wanted = f"must hold nx * ny * nz = {cells} colours"
            report.error(parameter, f"{wanted}, got {len(parameter.values)} numbers")
            return EMPTY
    given = [f.values for f in found if f is not None]
    if not cells or not given or min(map(np.min, given)) < 0.0 or scale < 0.0:
        report.error(p.directive, "needs rgb sigma_a or sigma_s, and no numbers below 0")
        return EMPTY
    absorbed, scattered = (
        np.zeros((cells, 3)) if f is None else np.asarray(f.values).reshape(-1, 3) for f in found
    )
    if found[0] is None or found[1] is None:
        # pbrt takes 1 for what is missing.
        absorbed = np.ones_like(absorbed) if found[0] is None else absorbed
        scattered = np.ones_like(scattered) if found[1] is None else scattered
    whole = absorbed + scattered
    mean = whole.mean(axis=1)
    if np.ptp(whole, axis=1).max() > 1e-3 * max(float(mean.max()), 1e-30):
        text = "is not as dense for all colours: their mean is taken, their albedos are kept"
        report.warn(p.directive, text)
    shape = (count[2], count[1], count[0])
    albedo = np.where(whole > 0.0, scattered / np.where(whole > 0.0, whole, 1.0), 0.0)
    data |= {"sigma_t": scale}
    _phase(context, p, data)
    if not _place(context, p, data, matrix, mean.reshape(*shape, 1)):
        return EMPTY
    values = np.pad(albedo.reshape(*shape, 3).astype(np.float32), _RIM, mode="edge")
    return data | {"albedo_values": Volume(values)}


def _color(context: Context, p: Parameters, key: str, usual: Sequence[float]) -> list[float]:
    """Coefficients of the three channels, 1/m where the scene is in metres."""
    found = p.find(key)
    color = None if found is None else context.colors.read(found, "index")
    if found is not None and color is not None and min(color) < 0.0:
        context.report.error(found, f"must be >= 0, got {min(color):g}")
        color = None
    return list(usual) if color is None else color


def _shine(context: Context, p: Parameters, data: Data) -> None:
    """What the medium shines with; of a grid, before ``Lescale``."""
    found = p.find("temperature")
    if found is not None:
        context.report.not_covered(found, "is not covered: give Le and Lescale", "left out")
    why = "temperatures are not covered"
    p.ignore(why, "temperaturescale", "temperatureoffset", "temperaturecutoff")
    found = p.find("Le")
    color = None if found is None else context.colors.read(found, "light")
    scale = p.number("Lescale", 1.0) if data["type"] == "homogeneous" else 1.0
    if found is not None and color is not None:
        if min(color) < 0.0 or scale < 0.0:
            context.report.error(found, "must not shine less than 0, nor Lescale be below 0")
        elif scale * max(color) > 0.0:
            data["emission"] = [scale * context.exposure * channel for channel in color]


def _phase(context: Context, p: Parameters, data: Data) -> None:
    g = p.number("g", 0.0)
    if not -1.0 < g < 1.0:
        context.report.error(p.named["g"], f"must be in (-1, 1), got {g:g}")
    elif g != 0.0:
        cut = min(max(g, -_LARGEST_G), _LARGEST_G)
        if cut != g:
            context.report.warn(p.named["g"], f"was cut to {cut:g}")
        data["phase"] = {"type": "henyey_greenstein", "g": cut}


def _shining_cells(
    context: Context, p: Parameters, data: Data, shape: tuple[int, int, int]
) -> None:
    """``Lescale`` of a grid: factors of ``Le``, cell by cell."""
    found = p.values("Lescale", "float")
    if found is None:
        return
    factors = np.asarray(found.values, np.float64)
    if len(factors) != np.prod(shape):
        text = f"must hold nx * ny * nz = {np.prod(shape)} numbers, got {len(factors)}"
        context.report.error(found, text)
    elif not 0.0 <= factors.min() <= factors.max() <= 1e15:
        wrong = factors.min() if factors.min() < 0.0 else factors.max()
        context.report.error(found, f"must be in [0, 1e+15], got {wrong:g}")
    elif "emission" in data:
        cells = factors.reshape(*shape, 1) * np.array(data.pop("emission"))
        data["emission_values"] = Volume(np.pad(cells.astype(np.float32), _RIM))


def _grid(context: Context, p: Parameters, data: Data, matrix: np.ndarray) -> None:
    """Densities, and the matrix from the unit cube to the world."""
    report = context.report
    count = _count(p)
    data["values"] = Volume(np.zeros((1, 1, 1, 1), np.float32))
    found = p.values("density", "float")
    if found is None:
        if not p.has("density"):
            report.error(p.directive, 'needs "float density"')
        return
    densities = np.asarray(found.values, np.float64)
    nx, ny, nz = count
    if min(count) < 1 or len(densities) != nx * ny * nz:
        text = f"must hold nx * ny * nz = {nx} * {ny} * {nz} numbers, got {len(densities)}"
        report.error(found, text)
    elif not 0.0 <= densities.min() <= densities.max() <= 1e15:
        wrong = densities.min() if densities.min() < 0.0 else densities.max()
        report.error(found, f"must be in [0, 1e+15], got {wrong:g}")
    elif _place(context, p, data, matrix, densities.reshape(nz, ny, nx, 1)):
        _shining_cells(context, p, data, (nz, ny, nx))


def _count(p: Parameters) -> list[int]:
    return [p.integer(key, 1) for key in ("nx", "ny", "nz")]


def _place(
    context: Context, p: Parameters, data: Data, matrix: np.ndarray, densities: np.ndarray
) -> bool:
    """Put densities (nz, ny, nx, 1) into the box of a grid; False after a problem."""
    report = context.report
    a, b = p.triple("p0", (0.0, 0.0, 0.0)), p.triple("p1", (1.0, 1.0, 1.0))
    low, high = np.minimum(a, b), np.maximum(a, b)
    if not (low < high).all():
        report.error(p.directive, "p0 and p1 must differ in x, y and z")
        return False
    if not np.array_equal(matrix[3], [0.0, 0.0, 0.0, 1.0]):
        report.error(p.directive, "its transformation must be affine")
        return False
    data["values"] = Volume(np.pad(densities.astype(np.float32), _RIM))
    side = (high - low) / densities.shape[2::-1]
    box = translation(*(low - side)) @ scaling(*(high - low + 2.0 * side))
    data["matrix"] = (matrix @ box)[:3].ravel().tolist()
    return True
