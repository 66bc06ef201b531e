"""Mutated scenes that can be rendered can be written to glTF and read again."""

from pathlib import Path

import pytest

from alight.core.errors import AlightError
from alight.formats import load, loads
from alight.formats.gltf.write import write
from alight.scene import flatten
from tests.formats.mutate import mutations
from tests.fuzz.extremes import extremes
from tests.fuzz.feature_files import features
from tests.fuzz.feature_files import write_files as write_features
from tests.fuzz.in_the_twin import MODELS
from tests.fuzz.mitsuba_files import copy_files, mitsuba_files
from tests.fuzz.model_files import copy_models, models
from tests.fuzz.pbrt_files import pbrt_files, write_files

#: More take their time.
MOST_SHAPES = 100
KINDS = {
    "native": (mutations, None),
    "extremes": (extremes, None),
    "features": (features, write_features),
    "mitsuba": (mitsuba_files, copy_files),
    "models": (models, copy_models),
    "pbrt": (pbrt_files, write_files),
}


def written(case, folder: Path) -> bool:
    """Write a scene, if it is one, and read it again."""
    (folder / case.mesh_name).write_bytes(case.mesh)
    try:
        is_name = case.text.endswith(MODELS)
        scene = load(folder / case.text) if is_name else loads(case.text, case.name, folder)
        flat = flatten(scene)
    except AlightError:
        return False
    if len(flat.shapes) > MOST_SHAPES:
        return False
    write(flat, folder / "written.glb")
    flatten(load(folder / "written.glb"))
    return True


@pytest.mark.parametrize("kind", KINDS)
def test_mutated_scenes_are_written_and_read_again(kind, tmp_path):
    generator, prepare = KINDS[kind]
    if prepare is not None:
        prepare(tmp_path)
    assert sum(written(case, tmp_path) for case in generator(seed=201, n=60)) >= 5
