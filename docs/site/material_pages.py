"""Pages of the materials, made from their files: formula, parameters, laws, source.

What a page says is what the model's docstrings, fields and laws say. Only the material that its
picture shows is chosen here; without a choice it is the model's first example.
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from types import ModuleType

from alight.core.registry import modules, type_name_of
from alight.core.spec import Spec
from alight.scene.keys import flow, keys_of, tables_of

DOCS = Path(__file__).resolve().parents[1]
PAGES, IMAGES = DOCS / "materials", DOCS / "images" / "materials"

_CHECKS = "{type: checkerboard, color0: 0, color1: 1, scale: [16, 8]}"
_CLOTH = (
    f"{{type: mask, opacity: {_CHECKS}, bsdf: {{type: diffuse, reflectance: [0.12, 0.4, 0.5]}}}}"
)
# Four slopes between which the picture is interpolated: rows of cushions.
_CUSHIONS = (
    "{type: bitmap, pixels: [[[0.3, 0.7, 0.9], [0.7, 0.7, 0.9]],"
    " [[0.3, 0.3, 0.9], [0.7, 0.3, 0.9]]], color_space: linear, to_uv: {scale: [16, 8]}}"
)
#: The material of the ball.
SHOWN = {
    "diffuse": "{type: diffuse, reflectance: [0.75, 0.3, 0.12]}",
    "uniform_scatter": "{type: uniform_scatter, reflectance: [0.75, 0.3, 0.12]}",
    "oren_nayar": "{type: oren_nayar, reflectance: [0.75, 0.3, 0.12], sigma: 40}",
    "eon": "{type: eon, reflectance: [0.75, 0.3, 0.12], roughness: 0.8}",
    "principled": (
        "{type: principled, base_color: [0.5, 0.03, 0.03], roughness: 0.4, metallic: 0.6,"
        " anisotropy: 0.5, clearcoat: 1, iridescence: 0.3}"
    ),
    "burley": (
        "{type: burley, base_color: [0.05, 0.2, 0.4], roughness: 0.5, sheen: 1, clearcoat: 1,"
        " clearcoat_gloss: 0.8}"
    ),
    "burley_thin": (
        "{type: burley_thin, base_color: [0.9, 0.85, 0.6], spec_trans: 0.4, through: 0.4,"
        " roughness: 0.3}"
    ),
    "normal_map": (
        f"{{type: normal_map, texture: {_CUSHIONS},"
        " bsdf: {type: rough_conductor, metal: copper, alpha: 0.2}}"
    ),
    "bump_map": (
        "{type: bump_map, texture: {type: noise, scale: 8}, scale: 0.1,"
        " bsdf: {type: plastic, diffuse_reflectance: [0.05, 0.25, 0.1]}}"
    ),
    "mirror": "{type: mirror, reflectance: 0.95}",
    "phong": "{type: phong, diffuse: [0.06, 0.2, 0.45], specular: 0.3, exponent: 100}",
    "conductor": "{type: conductor, metal: gold}",
    "dielectric": "{type: dielectric, int_ior: bk7}",
    "rough_conductor": "{type: rough_conductor, metal: copper, alpha: 0.2}",
    "rough_dielectric": "{type: rough_dielectric, int_ior: bk7, alpha: 0.15}",
    "thin_dielectric": "{type: thin_dielectric, int_ior: bk7}",
    "plastic": "{type: plastic, diffuse_reflectance: [0.55, 0.03, 0.03]}",
    "rough_plastic": (
        "{type: rough_plastic, diffuse_reflectance: [0.05, 0.35, 0.12], nonlinear: true}"
    ),
    "coated_conductor": "{type: coated_conductor, metal: copper, alpha: 0.2, coat_alpha: 0.02}",
    "diffuse_transmission": (
        "{type: diffuse_transmission, reflectance: [0.1, 0.25, 0.04], "
        "transmittance: [0.35, 0.5, 0.1]}"
    ),
    "subsurface": "{type: subsurface, color: [0.85, 0.6, 0.45], radius: [0.2, 0.07, 0.04]}",
    "two_sided": f"{{type: two_sided, bsdf: {_CLOTH}}}",
    "mask": _CLOTH,
    "null": '{type: "null"}',
    "blend": (
        f"{{type: blend, weight: {_CHECKS}, bsdfs: [{{type: rough_conductor, metal: gold}},"
        " {type: plastic, diffuse_reflectance: [0.03, 0.08, 0.3]}]}"
    ),
}

SCENE = """\
alight: 1
camera: {{fov: 30, transform: {{look_at: {{origin: [0, 1, 4], target: [0, 0, 0]}}}}}}
environment: {{type: constant, radiance: 0.8}}
nodes:
  ball:
    shape: sphere
    bsdf: {material}
"""


def materials() -> list[ModuleType]:
    """The models of the registry, in its order; none that a user has registered."""
    return [module for module in modules("bsdfs") if module.__name__.startswith("alight.")]


def shown(module: ModuleType) -> str:
    """The material of the picture, as a scene file writes it."""
    name = type_name_of(module)
    return SHOWN.get(name) or flow(module.EXAMPLES[0])


def samples(module: ModuleType) -> int:
    """Samples per pixel of the picture: light inside of clear materials takes more."""
    return 512 if any(example.transmissive for example in module.EXAMPLES) else 256


def page(module: ModuleType) -> str:
    """Write the page of one material."""
    name, material = type_name_of(module), shown(module)
    command = f"alight render material-ball --spp {samples(module)} --set 'bsdfs.ball={material}'"
    summary, body, source = _split(inspect.cleandoc(module.__doc__ or ""))
    parts = [
        f"# {name.replace('_', ' ').capitalize()}",
        f"`type: {name}`, from `{module.__name__.replace('.', '/')}.py`",
        f"![A ball of the material {name}](../images/materials/{name}.png)",
        f"**{to_markdown(summary)}**",
        to_markdown(body),
        "## Parameters",
        parameters(type(module.EXAMPLES[0])),
        "## In a scene",
        f"```yaml\n{SCENE.format(material=material)}```",
        "The picture above:",
        f"```bash\n{command}\n```",
        *_laws(module),
        *(["## Source", to_markdown(source[0].upper() + source[1:])] if source else []),
        "[All materials](index.md)",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def index() -> str:
    """Write the overview: a picture and a line for each material."""
    rows = []
    for module in materials():
        name = type_name_of(module)
        summary, _, _ = _split(inspect.cleandoc(module.__doc__ or ""))
        # Markdown has no way to say how large a picture is.
        picture = f'<img src="../images/materials/{name}.png" width="120" alt="{name}">'
        rows.append(f"| [{picture}]({name}.md) | [{name}]({name}.md) | {to_markdown(summary)} |")
    text = """# Materials

Each is one file, from which its page is made. The pictures show the built-in scene `material-ball`.

| | type | what it is |
|---|---|---|
"""
    return text + "\n".join(rows) + "\n"


# ---------------------------------------------------------------- docstrings


def _split(text: str) -> tuple[str, str, str]:
    """Summary, body and source of a module's docstring."""
    text, _, source = text.partition("\nSource: ")
    summary, _, body = text.partition("\n\n")
    return summary.strip(), body.strip(), source.strip()


def to_markdown(text: str) -> str:
    """Turn the reStructuredText of a docstring into Markdown: formulas and code."""
    text = re.sub(
        r"^\.\. math::[ \n]*((?:.*\n?)(?:(?:[ ]{2,}.*|)\n?)*)",
        lambda found: _formula(found[1]),
        text,
        flags=re.MULTILINE,
    )
    text = re.sub(r":math:`([^`]+)`", r"$\1$", text)
    return text.replace("``", "`").strip()


def _formula(tex: str) -> str:
    tex = inspect.cleandoc(tex).strip()
    if "\\\\" in tex or re.search(r"(?<!\\)&", tex):
        tex = f"\\begin{{align*}}\n{tex}\n\\end{{align*}}"
    return f"$$\n{tex}\n$$\n\n"


# ---------------------------------------------------------------- fields


def parameters(model: type[Spec]) -> str:
    """The keys of a model as a table, and the names that they take."""
    rows = [
        f"| `{key.name}` | {key.takes} | {'required' if key.required else code(key.default)} |"
        f" {to_markdown(key.text)} |"
        for key in keys_of(model)
    ]
    if not rows:
        return "None."
    lines = ["| key | value | default | what it is |", "|---|---|---|---|", *rows]
    for title, names in tables_of(model).items():
        listed = [
            f"{name} ({value:g})" if isinstance(value, float) else name
            for name, value in names.items()
        ]
        lines += ["", f"Names of `{title}`: {', '.join(listed)}."]
    return "\n".join(lines)


def code(text: str) -> str:
    """Text in the type of code, if there is any."""
    return f"`{text}`" if text else ""


def _laws(module: ModuleType) -> list[str]:
    """What the tests hold each example of the model to."""
    lines = []
    for title, name in (("Energy", "is_lossless"), ("Reciprocity", "is_reciprocal")):
        law = getattr(module, name, None)
        if law is not None:
            kept = sum(bool(law(example)) for example in module.EXAMPLES)
            text = to_markdown(inspect.cleandoc(law.__doc__ or ""))
            total = len(module.EXAMPLES)
            lines.append(f"| {title} | {text} | {kept} of {total} |")
    if not lines:
        return []
    head = ["| law | when it holds | examples of the file |", "|---|---|---|"]
    return ["## Laws", "\n".join(head + lines)]
