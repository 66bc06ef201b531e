"""Points of shapes that shine, whatever shapes a scene has: chosen, and how densely."""

from __future__ import annotations

from alight.shapes.hit import INFO as SHAPE_INFO
from alight.shapes.hit import AreaSample, ShapeSample
from alight.shapes.model import SHAPES, ShapeModel
from lanewise.jit import kernel, specialised
from lanewise.simd import any_lane, gather, lanes, lanes_u32, lanes_vec3, where


@kernel
def no_sample(tables, cdf, start, shape, p, u, u2):
    """A `ShapeSample` of zeros in every lane."""
    zero = lanes(0.0)
    return ShapeSample(lanes_vec3(0.0), zero, zero, zero, zero)


@kernel
def no_pdf(tables, cdf, start, shape, p, hit):
    """Zero in every lane."""
    return lanes(0.0)


def _sample_by_kind(shapes: tuple[ShapeModel, ...]):
    """A kernel that runs each shape's `sample` where it was chosen."""
    if not shapes:
        return no_sample
    own, number = shapes[0].sample, shapes[0].number
    assert own is not None
    if len(shapes) == 1:
        return own
    others = _sample_by_kind(shapes[1:])

    @kernel
    def choose(tables, cdf, start, shape, p, u, u2):
        result = others(tables, cdf, start, shape, p, u, u2)
        mine = gather(tables.info, shape * SHAPE_INFO) == number
        if any_lane(mine):
            result = where(mine, own(tables, cdf, start, shape, p, u, u2), result)
        return result

    return choose


def _pdf_by_kind(shapes: tuple[ShapeModel, ...]):
    """A kernel that runs each shape's `pdf` where it was hit."""
    if not shapes:
        return no_pdf
    own, number = shapes[0].pdf, shapes[0].number
    assert own is not None
    if len(shapes) == 1:
        return own
    others = _pdf_by_kind(shapes[1:])

    @kernel
    def choose(tables, cdf, start, shape, p, hit):
        result = others(tables, cdf, start, shape, p, hit)
        mine = gather(tables.info, shape * SHAPE_INFO) == number
        if any_lane(mine):
            result = where(mine, own(tables, cdf, start, shape, p, hit), result)
        return result

    return choose


@specialised
def sample_shape(program):
    """``sample_shape(tables, cdf, start, shape, p, u, u2) -> ShapeSample``."""
    return _sample_by_kind(tuple(SHAPES[name] for name in program.light_shapes))


@specialised
def shape_pdf(program):
    """``shape_pdf(tables, cdf, start, shape, p, hit)``, per solid angle, of a `ShapeHit`."""
    return _pdf_by_kind(tuple(SHAPES[name] for name in program.light_shapes))


@kernel
def _nowhere(tables, cdf, start, shape, u, u2):
    """An `AreaSample` of zeros in every lane."""
    zero = lanes(0.0)
    return AreaSample(lanes_vec3(0.0), zero, zero, lanes_u32(0), zero)


def _area_by_kind(shapes: tuple[ShapeModel, ...]):
    """A kernel that runs each shape's `sample_area` where it was chosen."""
    if not shapes:
        return _nowhere
    own, number = shapes[0].sample_area, shapes[0].number
    assert own is not None
    if len(shapes) == 1:
        return own
    others = _area_by_kind(shapes[1:])

    @kernel
    def choose(tables, cdf, start, shape, u, u2):
        result = others(tables, cdf, start, shape, u, u2)
        mine = gather(tables.info, shape * SHAPE_INFO) == number
        if any_lane(mine):
            result = where(mine, own(tables, cdf, start, shape, u, u2), result)
        return result

    return choose


@specialised
def sample_area(program):
    """``sample_area(tables, cdf, start, shape, u, u2) -> AreaSample``."""
    return _area_by_kind(tuple(SHAPES[name] for name in program.light_shapes))
