"""`check_laws`: one call runs every law of a model's family on all of its examples."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from alight.core.registration import registered_module
from alight.core.registry import type_name_of
from alight.core.spec import Spec
from alight.laws import (
    bsdfs,
    cameras,
    emission,
    features,
    filters,
    integrators,
    lights,
    media,
    metrics,
    phases,
    samplers,
    shapes,
    textures,
    tone_curves,
)
from alight.laws.compiled import compiled_bsdf_is_the_twins
from alight.laws.materials import COSINES, Material
from alight.laws.report import Report, Result, judged
from alight.lights.model import LIGHTS


def check_laws(model: object, *, compiled: bool = True) -> Report:
    """Prove a model by the laws that all of ours obey.

    Parameters
    ----------
    model : module, str, class or namespace
        What was given to `alight.register`, or one of our own modules.
    compiled : bool, default True
        Also compare machine code with the Python text, which takes some seconds of compilation.

    Returns
    -------
    Report
        True if all laws hold; ``print`` shows which do not, for which example, and by how much.

    Raises
    ------
    RegistrationError
        If the model is not registered.

    Examples
    --------
    >>> from alight.bsdfs import mirror
    >>> bool(check_laws(mirror, compiled=False))
    True
    """
    module = registered_module(model)
    family = type(module.EXAMPLES[0]).family
    results = tuple(CHECKS[family](module.EXAMPLES, compiled))
    return Report(f"{family}: {type_name_of(module)}", results)


def _check_bsdf(examples: Sequence[Spec], compiled: bool) -> Iterator[Result]:
    for example in examples:
        material, name = Material(example), _short(example)
        for cosine in COSINES:
            for law in bsdfs.DIRECTIONAL_LAWS:
                yield judged(law, f"{name}, cosine {cosine}", material, cosine)
        for law in bsdfs.WHOLE_LAWS:
            yield judged(law, name, material)
    if compiled:
        yield judged(compiled_bsdf_is_the_twins, "all examples", examples)


def _check_sampler(examples: Sequence[Spec], compiled: bool) -> Iterator[Result]:
    yield from _each(samplers.LAWS, examples)
    yield from _each(samplers.FIRST_LAWS, examples[:1])
    if compiled:
        yield from _each(samplers.COMPILED_LAWS, examples[-1:])


def _check_light(examples: Sequence[Spec], compiled: bool) -> Iterator[Result]:
    laws = lights.LAWS[LIGHTS[examples[0].type_name()].spec.placement]
    compiled_laws = (*lights.COMPILED_LAWS, *emission.COMPILED_LAWS)
    yield from _simple((*laws, *emission.LAWS), compiled_laws)(examples, compiled)


def _check_integrator(examples: Sequence[Spec], compiled: bool) -> Iterator[Result]:
    yield from _simple(integrators.LAWS, integrators.COMPILED_LAWS)(examples, compiled)
    for law in features.FIRST_LAWS:
        for name in features.FEATURES:
            yield judged(law, f"{_short(examples[0])}, {name}", examples[0], name)


def _simple(
    laws: Sequence[Callable], compiled_laws: Sequence[Callable] = ()
) -> Callable[[Sequence[Spec], bool], Iterator[Result]]:
    def check(examples: Sequence[Spec], compiled: bool) -> Iterator[Result]:
        yield from _each(laws, examples)
        if compiled:
            yield from _each(compiled_laws, examples)

    return check


def _each(laws: Sequence[Callable], examples: Sequence[Spec]) -> Iterator[Result]:
    for example in examples:
        for law in laws:
            yield judged(law, _short(example), example)


def _short(example: Spec) -> str:
    """An example by what is not at its default."""
    defaults = {name: field.default for name, field in type(example).model_fields.items()}
    shown = {name: repr(value) for name, value in example if repr(value) != repr(defaults[name])}
    given = [f"{name}={text if len(text) < 60 else '...'}" for name, text in shown.items()]
    return f"{type(example).__name__}({', '.join(given)})"


#: Family -> its laws, run on all examples of a model.
CHECKS: dict[str, Callable[[Sequence[Spec], bool], Iterator[Result]]] = {
    "bsdfs": _check_bsdf,
    "samplers": _check_sampler,
    "shapes": _simple((*shapes.LAWS, *emission.LAWS_OF_SHAPES), shapes.COMPILED_LAWS),
    "phases": _simple(phases.LAWS),
    "media": _simple(media.LAWS),
    "lights": _check_light,
    "integrators": _check_integrator,
    "textures": _simple(textures.LAWS, textures.COMPILED_LAWS),
    "filters": _simple(filters.LAWS, filters.COMPILED_LAWS),
    "cameras": _simple(cameras.LAWS, cameras.COMPILED_LAWS),
    "tone_curves": _simple(tone_curves.LAWS),
    "metrics": _simple(metrics.LAWS),
}
