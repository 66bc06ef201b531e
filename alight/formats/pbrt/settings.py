"""``Camera``, ``Film``, ``PixelFilter``, ``Sampler``, ``Integrator`` -> their native settings."""

from __future__ import annotations

import math

import numpy as np

from alight.formats.pbrt.context import Context, Data
from alight.formats.pbrt.directives import Directive
from alight.formats.pbrt.lenses import realistic
from alight.formats.pbrt.media import SEEING
from alight.formats.pbrt.parameters import Parameters
from alight.formats.pbrt.transforms import FACING
from alight.formats.scenes.cameras import Parallel, Perspective, angle_of

CAMERAS = ("perspective", "orthographic", "realistic")
#: Of the film of a realistic camera, mm.
DIAGONAL = 35.0
FILMS = ("rgb", "image", "gbuffer", "spectral")
FILTERS = ("box", "gaussian", "mitchell", "sinc", "triangle")
#: Our samplers.
SAMPLERS = {
    "halton": "halton", "independent": "independent", "random": "independent",
    "paddedsobol": "sobol", "pmj02bn": "sobol", "sobol": "sobol", "zsobol": "sobol",
    "stratified": "stratified", "02sequence": "sobol", "lowdiscrepancy": "sobol",
    "maxmindist": "sobol",
}  # fmt: skip
SAME = ("halton", "independent", "sobol", "stratified")
#: Integrators that find the same light as paths do, within noise.
PATHS = ("path", "volpath", "simplepath", "simplevolpath")
#: Integrators that start at lights too, and so find caustics of lights without a size.
FROM_LIGHTS = ("bdpt", "lightpath", "mlt", "sppm")
#: Far away, pbrt's plane of focus without a lens.
FAR = 1e6


def camera(context: Context, directive: Directive | None, to_world: np.ndarray, film: Data) -> Data:
    """Convert the camera; ``to_world`` is from pbrt's camera, which looks along +z."""
    directive = directive or Directive("Camera", "", ["perspective"])
    p = Parameters(directive, context.report)
    kind = directive.type
    if kind not in CAMERAS:
        context.report.unknown(directive, "camera", kind, CAMERAS, "a perspective one is taken")
        p.forget()
        kind = "perspective"
    width, height = film["size"]
    diagonal = film.pop("diagonal", DIAGONAL)
    shutter = _shutter(context, p)
    place = {"matrix": (to_world @ FACING).tolist()}
    if kind == "realistic":
        seen = realistic(context, p, width, height, diagonal)
        return _finished(context, p, seen.data(), shutter, place)
    aspect = p.positive("frameaspectratio", width / height)
    window = [-aspect, aspect, -1.0, 1.0] if aspect > 1.0 else [-1.0, 1.0, -1 / aspect, 1 / aspect]
    found = p.values("screenwindow", "float", count=4)
    if found is not None:
        window = [float(x) for x in found.values]
    half = _window(p, window, width, height)
    if kind == "orthographic":
        data = Parallel(2.0 * half * p.number("screenscale", 1.0)).data()
        p.leave_out("an orthographic camera has no lens", "lensradius")
        p.ignore("without a lens everything is sharp", "focaldistance")
    else:
        fov = 2.0 * p.number("halffov", 45.0) if p.has("halffov") else p.number("fov", 90.0)
        if not 0.0 < fov < 180.0:
            name = "halffov" if p.has("halffov") else "fov"
            context.report.error(p.named[name], f"must be in (0, 180) degrees, got {fov:g}")
            fov = 90.0
        fov = angle_of(2.0 * half * math.tan(math.radians(0.5 * fov)), 1.0)
        lens, focus = p.number("lensradius", 0.0), p.number("focaldistance", FAR)
        optics = (lens, focus) if lens > 0.0 else (None, None)
        data = Perspective(fov, "y", *optics).data()
    return _finished(context, p, data, shutter, place)


def _finished(
    context: Context, p: Parameters, data: Data, shutter: list[float], place: Data
) -> Data:
    """A camera with its shutter and place."""
    p.finish()
    if p.directive.place:
        context.places["camera"] = p.directive.place
    if shutter != [0.0, 1.0]:
        data["shutter"] = shutter
    return {**data, "transform": place}


def _window(p: Parameters, window: list[float], width: int, height: int) -> float:
    """Half the height of what is seen, in units of the picture plane."""
    wide, high = window[1] - window[0], window[3] - window[2]
    if wide <= 0.0 or high <= 0.0:
        p.report.error(p.directive, f"must see something, got a screenwindow of {window}")
        return 1.0
    centred = max(abs(window[0] + window[1]), abs(window[2] + window[3])) <= 1e-6 * (wide + high)
    square = abs(wide / high - width / height) <= 1e-3 * width / height
    if not centred or not square:
        text = "is not covered: the picture has its middle where the camera looks, and square"
        p.report.not_covered(p.directive, f"{text} pixels", "the height alone is taken")
    return 0.5 * high


def _shutter(context: Context, p: Parameters) -> list[float]:
    """When the shutter opens and closes; in pbrt 4 light adds up as long as it is open."""
    open_, close = p.number("shutteropen", 0.0), p.number("shutterclose", 1.0)
    if context.old:
        # As pbrt 3 does.
        return sorted((open_, close))
    if close <= open_:
        p.report.error(p.directive, f"shutterclose must be > shutteropen, got {close:g}")
        return [0.0, 1.0]
    context.exposure *= close - open_
    return [open_, close]


def film(context: Context, directive: Directive | None, pixel_filter: Directive | None) -> Data:
    """Convert the film and its filter; sets the context's exposure."""
    known = directive is not None
    directive = directive or Directive("Film", "", ["image" if context.old else "rgb"])
    p = Parameters(directive, context.report)
    if directive.type not in FILMS:
        context.report.unknown(directive, "film", directive.type, FILMS, "rgb is taken")
        p.forget()
    default = (640, 480) if context.old else (1280, 720)
    size = [p.integer("xresolution", default[0]), p.integer("yresolution", default[1])]
    p.ignore("it is about files, see the options of the command line", "filename", "savefp16")
    diagonal = p.positive("diagonal", DIAGONAL)
    p.ignore("layers are asked for with --aov", "coordinatesystem")
    p.ignore("pictures are linear sRGB", "nbuckets", "lambdamin", "lambdamax")
    p.leave_out("no sample is cut off", "maxcomponentvalue", "maxsampleluminance")
    if p.text("sensor", "cie1931") != "cie1931":
        context.report.warn(p.named["sensor"], "is not covered: cie1931 is taken")
    _white(p)
    iso = p.positive("iso", 100.0)
    # The scale of pbrt 3 is left in scenes for early versions of pbrt 4.
    context.exposure *= p.positive("scale", 1.0) * (1.0 if context.old else iso / 100.0)
    data: Data = {"size": size, "filter": _filter(context, pixel_filter)}
    crop = _crop(p, size)
    if crop is not None:
        data["crop"] = crop
    if diagonal != DIAGONAL:
        data["diagonal"] = diagonal
    p.finish()
    if known:
        context.places["film"] = directive.place
    return data


def _white(p: Parameters) -> None:
    """Say how the white of the file can be had."""
    kelvin = p.number("whitebalance", 0.0)
    if kelvin:
        text = (
            f"is left out: white stays that of D65 (shown otherwise by --white-balance {kelvin:g})"
        )
        p.report.warn(p.named["whitebalance"], text)


def _crop(p: Parameters, size: list[int]) -> list[int] | None:
    found = p.values("cropwindow", "float", count=4)
    if found is not None:
        shares = np.clip(found.values, 0.0, 1.0)
        (x0, x1), (y0, y1) = sorted(shares[:2]), sorted(shares[2:])
        ends = (
            [math.ceil(size[0] * x) for x in (x0, x1)],
            [math.ceil(size[1] * y) for y in (y0, y1)],
        )
        p.ignore("cropwindow goes before it", "pixelbounds")
    else:
        found = p.values("pixelbounds", "integer", count=4)
        if found is None:
            return None
        limits = np.clip(found.values, 0, [size[0], size[0], size[1], size[1]])
        ends = [int(x) for x in limits[:2]], [int(y) for y in limits[2:]]
    (x0, x1), (y0, y1) = ends
    return [x0, y0, x1 - x0, y1 - y0]


def _filter(context: Context, directive: Directive | None) -> Data:
    if directive is None:
        if context.old:
            return {"type": "box"}
        return {"type": "gaussian", "stddev": 0.5, "radius": 1.5}
    kind = directive.type
    p = Parameters(directive, context.report)
    context.places["film.filter"] = directive.place
    default = {"box": 0.5, "gaussian": 2.0 if context.old else 1.5, "sinc": 4.0}.get(kind, 2.0)
    names = ("xwidth", "ywidth") if p.has("xwidth") or p.has("ywidth") else ("xradius", "yradius")
    radius = [p.positive(name, default) for name in names]
    if radius[0] != radius[1]:
        context.report.warn(directive, "is not as wide as high: its width is taken")
    data: Data = {"type": "gaussian", "stddev": 0.5, "radius": 1.5}
    if kind == "box":
        data = {"type": "box", "radius": radius[0]}
    elif kind == "triangle":
        data = {"type": "tent", "radius": radius[0]}
    elif kind == "mitchell":
        data = {"type": "mitchell", "radius": radius[0]}
        data |= {"b": p.number("B", 1.0 / 3.0), "c": p.number("C", 1.0 / 3.0)}
    elif kind == "gaussian":
        alpha = p.positive("alpha", 2.0)
        sigma = 1.0 / math.sqrt(2.0 * alpha) if context.old or p.has("alpha") else 0.5
        data |= {"stddev": p.positive("sigma", sigma), "radius": radius[0]}
    elif kind == "sinc":
        p.leave_out("a Mitchell filter is taken", "tau")
        context.report.warn(directive, "has negative parts: a Catmull-Rom filter is taken")
        data = {"type": "mitchell", "b": 0.0, "c": 0.5}
    else:
        context.report.unknown(directive, "filter", kind, FILTERS, "gaussian is taken")
        p.forget()
    p.finish()
    return data


def sampler(context: Context, directive: Directive | None) -> tuple[int, Data]:
    """Convert the sampler: samples per pixel, and its settings."""
    if directive is None:
        return 16, {"type": "sobol"}
    kind = directive.type
    p = Parameters(directive, context.report)
    context.places["sampler"] = directive.place
    if kind not in SAMPLERS:
        context.report.unknown(directive, "sampler", kind, SAMPLERS, "sobol is taken")
        p.forget()
    elif kind not in SAME:
        context.report.note(directive, f"becomes {SAMPLERS[kind]}: the same picture, other noise")
    p.ignore("it is an option of the command line", "seed")
    p.ignore("samples are always scrambled", "randomization", "dimensions")
    data: Data = {"type": SAMPLERS.get(kind, "sobol")}
    if kind == "stratified":
        x, y = p.integer("xsamples", 4), p.integer("ysamples", 4)
        p.ignore("samples are always jittered", "jitter")
        spp = x * y
        data["strata"] = max(1, min(1024, round(math.sqrt(max(spp, 1)))))
    else:
        spp = p.integer("pixelsamples", 16)
    if not 1 <= spp < 2**31:
        context.report.error(directive, f"must take 1 to {2**31 - 1} samples, got {spp}")
        spp = 16
    p.finish()
    return spp, data


def sees_media(context: Context, directive: Directive | None) -> bool:
    """Tell whether the integrator sees media; that of pbrt 3 does not by default."""
    return not context.old if directive is None else directive.type in SEEING


def integrator(context: Context, directive: Directive | None, in_media: bool = False) -> Data:
    """Convert the integrator; pbrt's default goes five bounces far."""
    of_paths = "volpath" if in_media else "path"
    if directive is None:
        return {"type": of_paths, "max_depth": 6}
    kind = directive.type
    p = Parameters(directive, context.report)
    context.places["integrator"] = directive.place
    if kind in ("directlighting", "whitted"):
        text = "shows direct light and mirrors only: paths of all kinds are taken"
        context.report.warn(directive, text)
    elif kind in FROM_LIGHTS:
        text = "becomes path, which finds no caustics of lights without a size (point, spot, ...)"
        context.report.warn(directive, text)
    elif kind not in PATHS:
        known = (*PATHS, *FROM_LIGHTS, "directlighting", "whitted")
        context.report.unknown(directive, "integrator", kind, known, "path is taken")
        p.forget()
    depth = p.integer("maxdepth", 5)
    if depth < 0:
        context.report.error(p.named["maxdepth"], f"must be >= 0, got {depth}")
    # pbrt counts bounces, alight the edges of a path after the camera.
    data: Data = {"type": of_paths, "max_depth": min(max(depth, 0) + 1, 2**16)}
    p.leave_out("roughness is taken as it is", "regularize")
    p.ignore("how lights are chosen is not the picture", "lightsampler", "lightsamplestrategy")
    names = ("rrthreshold", "pixelbounds", "strategy", "sampledirect", "samplelights", "samplebsdf")
    p.ignore("it does not change the picture", *names)
    # What only the other integrators have.
    for name in ("mutationsperpixel", "bootstrapsamples", "chains", "largestepprobability"):
        p.ignore("it does not change the picture", name)
    names = ("sigma", "iterations", "photonsperiteration", "radius", "imagewritefrequency")
    p.ignore("it does not change the picture", *names, "visualizestrategies", "visualizeweights")
    p.finish()
    return data
