"""PTX of kernels: made by a process of its own, kept, accepted by ptxas, and the same film."""

import shutil
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

import alight
from alight.rendering.executors import gpu_executor
from alight.rendering.tiles import pixel_kernel
from alight.rendering.tiles.pixel_kernel import PixelFilms
from lanewise import ptx
from lanewise.machine import PTX, describe_machine, fingerprint
from lanewise.machine_code import ObjectCode
from lanewise.ptx import LoweringError, ptx_of
from lanewise.view import View
from tests.gpu.processor import ProcessorGpu
from tests.gpu.ptx_as_c import PtxOnTheProcessor

NOTHING = View(np.zeros(3, np.int64))
#: Types of arguments are all that PTX depends on.
ASKED = (
    pixel_kernel.__name__, "render_pixel", None,
    (NOTHING, PixelFilms(*(NOTHING,) * 4), np.float32(1.0), 0),
)  # fmt: skip


@pytest.fixture
def empty_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("ALIGHT_CACHE", str(tmp_path))
    return tmp_path


def test_ptx_is_made_once(empty_cache, monkeypatch):
    made = []

    def make(asked):
        made.append(asked)
        return ObjectCode("entry", ("i64",), b".version 8.3")

    monkeypatch.setattr(ptx, "_made_elsewhere", make)
    assert ptx_of(*ASKED) == ptx_of(*ASKED)
    assert [asked.arguments[0].size for asked in made] == [1]
    assert list(empty_cache.glob(f"{fingerprint(PTX)}/render_pixel-*.kernel"))


@pytest.mark.parametrize(
    ("said", "told"),
    [
        (b"Stack:\nLLVM ERROR: Cannot select: t7\nAborted\n", "LLVM ERROR: Cannot select: t7"),
        (b"Traceback\nTypeError: a kernel\n", "TypeError: a kernel"),
        (b"", "it said nothing"),
    ],
)
def test_what_cannot_be_lowered_is_told(empty_cache, monkeypatch, said, told):
    done = SimpleNamespace(returncode=-6, stderr=said, stdout=b"")
    monkeypatch.setattr(subprocess, "run", lambda *words, **given: done)
    with pytest.raises(LoweringError, match=told):
        ptx_of(*ASKED)


def test_the_bits_of_ptx_do_not_depend_on_this_processor():
    words = describe_machine(PTX)
    assert "processor" not in words
    assert "lanes" not in words
    assert fingerprint(PTX) != fingerprint()


class PtxGpu(ProcessorGpu):
    """Runs what it is given, as C."""

    folder = None

    def load(self, ptx, entry):
        self.kept(ptx)
        return PtxOnTheProcessor(ptx.decode(), self.folder)

    def kept(self, ptx):
        (self.folder / "kernel.ptx").write_bytes(ptx)

    def launch(self, kernel, block, kinds, arguments):
        kernel.launch(arguments, kinds, block)


@pytest.mark.proofs
@pytest.mark.skipif(shutil.which("gcc") is None, reason="PTX is run as C")
@pytest.mark.parametrize("scene", ["cornell-box", "many-lights"])
def test_ptx_renders_the_same_film(scene, monkeypatch, tmp_path):
    words = {"size": (24, 16), "spp": 8, "replicates": 2, "threads": 1}
    ours = alight.render(scene, **words)
    monkeypatch.setattr(gpu_executor, "Gpu", PtxGpu)
    monkeypatch.setattr(PtxGpu, "folder", tmp_path)
    film = alight.render(scene, device="gpu", **words)
    assert np.array_equal(film.cells, ours.cells)
    assert film.stats["rays"] == pytest.approx(ours.stats["rays"], rel=1e-3)
    # The same random numbers: only a path that rounding sends elsewhere differs.
    near = np.isclose(film.mean, ours.mean, rtol=1e-3).all(axis=2)
    assert near.mean() > 0.98
    if assembler := shutil.which("ptxas"):
        for processor in ("sm_75", "sm_90", "sm_120"):
            command = [assembler, f"-arch={processor}", "kernel.ptx", "-o", "kernel.cubin"]
            subprocess.run(command, cwd=tmp_path, check=True)
