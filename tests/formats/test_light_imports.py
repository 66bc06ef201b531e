"""Loading a scene needs no compiler and no mesh library."""

import subprocess
import sys


def test_loading_a_scene_imports_no_heavy_module():
    code = (
        "import sys, alight.formats as f, alight.scene as s; s.flatten(f.load('cornell-box'));"
        "print([m for m in ('numba', 'llvmlite', 'trimesh', 'scipy', 'matplotlib', 'PIL', "
        "'OpenEXR') if m in sys.modules])"
    )
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == "[]"
