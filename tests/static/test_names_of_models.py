"""Nobody asks for a model by its name: what others must know of it stands in its own file.

Outside its own file a model is named by its family's registry (``__init__.py``) and by the readers
of scene formats. A model may be made of others of its family. `OFFENDERS` are still to go, and must
leave the list when they do; `OTHER_MEANINGS` are words that happen to be the name of a model too.
"""

import ast
from functools import cache
from importlib import import_module

import pytest

from tests.static.sources import FAMILIES, PACKAGE, assigned_names, package_files, tree

#: Folders of scenes, which name what they are made of, as files of scenes do.
SCENES = ("formats", "scene/builtin", "lab/random_scenes")

#: A tone curve, and the word for nothing at all.
EVERYWHERE = {"none"}

#: Words of another meaning, by file.
OTHER_MEANINGS: dict[str, set[str]] = {
    "bsdfs/plastics/phong.py": {"diffuse"},
    "bsdfs/plastics/plastic.py": {"diffuse"},
    "core/arguments.py": {"path"},
    "core/model_form.py": {"area"},
    "core/spec.py": {"environment", "light"},
    "integrators/queue.py": {"direct"},
    "integrators/interiors/volume_walk.py": {"channel"},
    "lab/arms.py": {"environment"},
    "lab/report/page.py": {"curves"},
    "lab/run.py": {"measured"},
    "lab/replicates/steering.py": {"threshold"},
    "lab/warm.py": {"environment"},
    "lab/why/shares.py": {"light"},
    "lab/why/trials.py": {"environment"},
    "lab/why/words.py": {"light"},
    "laws/lights.py": {"environment", "light"},
    "laws/scene/pictures.py": {"light"},
    "lights/area.py": {"environment"},
    "lights/constant.py": {"constant", "environment"},
    "lights/daylight.py": {"environment"},
    "lights/model.py": {"environment"},
    "lights/portal.py": {"environment"},
    "options/render.py": {"direct"},
    "options/table.py": {"path"},
    "rendering/schedules/cycles.py": {"threshold"},
    "rendering/executors/gpu_executor.py": {"direct"},
    "rendering/layers.py": {"direct"},
    "rendering/summary.py": {"relmse", "relmse_literature"},
    "rendering/tiles/tile.py": {"direct"},
    "rendering/tiles/tile_kernel.py": {"direct"},
    "rendering/tracing/trace.py": {"null"},
    "scene/build.py": {"environment", "null"},
    "scene/description.py": {"light"},
    "scene/flatten.py": {"environment"},
    "scene/manager.py": {"path"},
    "scene/moving.py": {"environment", "light"},
    "scene/plain_yaml.py": {"null"},
    "scene/validation.py": {"environment"},
    "textures/bitmap.py": {"clamp", "mirror"},
    "textures/constant.py": {"constant"},
    "view/editor.py": {"path"},
    "view/inspection.py": {"light", "path"},
    "view/tree.py": {"environment", "light"},
}

#: Files that still name models, by family.
OFFENDERS: dict[str, dict[str, set[str]]] = {}


@cache
def models(family):
    """Type name -> (module, name of the description's class)."""
    found = {}
    for module in import_module(f"alight.{family}").MODELS:
        spec = type(module.EXAMPLES[0])
        found[spec.type_name()] = module.__name__, spec.__name__
    return found


@cache
def words(path):
    """Texts and imports of a file: (strings, imported modules)."""
    strings, imported = set(), set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            strings.add(node.value)
        elif isinstance(node, ast.ImportFrom) and node.module:
            imported |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
    return strings, imported


def named_models(family, path):
    """Models of a family that a file names and should not."""
    place = path.relative_to(PACKAGE).as_posix()
    own = f"alight.{place[:-3].replace('/', '.')}"
    if place.startswith(SCENES) or place == f"{family}/__init__.py":
        return set()
    strings, imported = words(path)
    # A model may be made of others of its family.
    related = place.startswith(f"{family}/") and "EXAMPLES" in assigned_names(path)
    return {
        name
        for name, (module, _) in models(family).items()
        if own != module
        and name not in EVERYWHERE
        and (
            (name in strings and name not in OTHER_MEANINGS.get(place, set()))
            or (module in imported and not related)
        )
    }


@pytest.mark.parametrize("family", FAMILIES)
def test_models_are_named_in_their_own_files_only(family):
    found = {
        path.relative_to(PACKAGE).as_posix(): names
        for path in package_files()
        if path.is_relative_to(PACKAGE) and (names := named_models(family, path))
    }
    assert found == OFFENDERS.get(family, {})


def test_no_exception_is_out_of_date():
    for place, names in OTHER_MEANINGS.items():
        assert names <= words(PACKAGE / place)[0], place


def test_a_name_is_found_as_a_text_and_as_an_import(tmp_path, monkeypatch):
    monkeypatch.setattr("tests.static.test_names_of_models.PACKAGE", tmp_path)
    path = tmp_path / "compiled.py"
    for text, found in {
        "kind == 'sphere'": {"sphere"},
        "from alight.shapes.sphere import Sphere": {"sphere"},
        "from alight.shapes import disk, sphere": {"disk", "sphere"},
        "import alight.shapes.disk": {"disk"},
        "kind == 'spheres'": set(),
    }.items():
        path.write_text(text)
        tree.cache_clear()
        words.cache_clear()
        assert named_models("shapes", path) == found
