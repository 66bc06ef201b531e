"""The driver's faults become messages."""

import numpy as np
import pytest
from typer.testing import CliRunner

from alight.cli.main import app
from alight.core.errors import DeviceError
from alight.gpu.driver import Gpu
from tests.gpu.driver import Library, have


def message_of(monkeypatch, library):
    have(monkeypatch, library)
    with pytest.raises(DeviceError) as raised:
        Gpu()
    return str(raised.value)


@pytest.mark.parametrize(
    ("library", "text"),
    [
        (None, "no NVIDIA driver is installed here"),
        (Library(count=0), "the NVIDIA driver finds no GPU"),
        (Library(failing={"cuInit": 100}), "the NVIDIA driver finds no GPU"),
        (Library(capability=(7, 0)), "Model 3 has compute capability 7.0; kernels need 7.5"),
        (Library(version=12020), "the driver of Model 3 supports CUDA 12.2; kernels need 12.3"),
        (Library(failing={"cuInit": 803}), "it is tired (CUDA error 803)"),
    ],
)
def test_what_is_missing_is_named(monkeypatch, library, text):
    assert text in message_of(monkeypatch, library)


@pytest.mark.parametrize("fault", [{"count": 0}, {"failing": {"cuInit": 100}}])
def test_hidden_gpus_are_pointed_at(monkeypatch, fault):
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "")
    assert "CUDA_VISIBLE_DEVICES hides" in message_of(monkeypatch, Library(**fault))


def test_the_command_line_ends_with_2(monkeypatch):
    have(monkeypatch, None)
    done = CliRunner().invoke(app, ["render", "cornell-box", "--device", "gpu", "-o", "a.png"])
    assert done.exit_code == 2
    assert done.stderr.startswith("error: no NVIDIA driver")


def test_memory_that_is_not_there_is_counted(monkeypatch):
    have(monkeypatch, Library(failing={"cuMemAlloc_v2": 2}))
    with Gpu() as gpu, pytest.raises(DeviceError, match=r"Model 3 has no 3\.0 MB of memory free"):
        gpu.allocate(3_000_000)


def test_memory_is_given_back(monkeypatch):
    library = Library()
    have(monkeypatch, library)
    with Gpu() as gpu:
        kept, freed = gpu.allocate(8), gpu.allocate(8)
        assert kept != freed
        gpu.free(freed)
    assert library.called.count("cuMemFree_v2") == 2
    assert library.called[-1] == "cuDevicePrimaryCtxRelease_v2"


def test_a_lost_gpu_does_not_hide_why(monkeypatch):
    have(monkeypatch, Library(failing={"cuMemFree_v2": 719, "cuCtxSynchronize": 719}))
    with pytest.raises(DeviceError, match="CUDA error 719") as raised, Gpu() as gpu:
        gpu.allocate(8)
        gpu.launch(None, 128, ["i64"], [1])
    assert raised.value.__context__ is None


def test_what_the_driver_says_of_ptx_is_told(monkeypatch):
    have(monkeypatch, Library(failing={"cuModuleLoadDataEx": 218}))
    with Gpu() as gpu, pytest.raises(DeviceError, match="line 3: what"):
        gpu.load(b".version 8.3", "entry")


def test_nothing_is_copied_of_empty_tables(monkeypatch):
    library = Library()
    have(monkeypatch, library)
    with Gpu() as gpu:
        gpu.write(64, np.zeros(0))
        gpu.read(64, np.zeros(0))
    assert not [name for name in library.called if "Memcpy" in name]
