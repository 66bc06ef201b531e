"""The portable target: one film for processors of several kinds, in processes of its own."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from typer.testing import CliRunner

import alight
from alight.cli.main import app
from alight.films import Film
from lanewise.jit import load_compiler
from lanewise.machine import fingerprint
from tests.cluster import recorded_bits
from tests.cluster.recorded_bits import run

#: Renders on a cluster whose worker has compiled for its own processor, if at all, and goes on.
PORTABLE = """
import json
import alight
from alight.cluster.addresses import connected
from lanewise.machine import describe_machine, target
from tests.cluster import jobs

if __name__ == "__main__":
    with connected("local:1") as client:
        words = {"size": (40, 24), "spp": 9, "threads": 1, "integrator": "ambient_occlusion"}
        film = alight.render("cornell-box", target="portable", cluster=client, **words)
        told = film.stats["cluster"] | {
            "of_worker": [*client.run(jobs.target_of_process).values()],
            "has_compiler": [*client.run(jobs.has_compiler).values()],
        }
    film.save("cluster.alight")
    print(json.dumps(told | {"target": target(), "machine": describe_machine()}))
"""


#: Runs programs of Linux on processors that are not there, with instructions of its own making.
EMULATOR = shutil.which("qemu-x86_64")


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("portable")
    (folder / "script.py").write_text(PORTABLE)
    told = json.loads(run(folder, "script.py").splitlines()[-1])
    run(folder, "-m", "alight", "render", "cornell-box", "--target", "portable", "--integrator",
        "ambient_occlusion", "--size", "40x24", "--spp", "6", "--checkpoint", "begun.alight", "-o",
        "own.alight", "-q")  # fmt: skip
    return folder, told


def test_workers_that_are_native_otherwise_give_a_portable_film(rendered):
    _, told = rendered
    assert told["target"] == "portable"
    assert told["machine"]["processor"] == "x86-64-v3"
    # The worker serves renders of both kinds, and compiles for neither.
    assert told["of_worker"] == ["native"]
    assert told["has_compiler"] == [False]
    assert told["tasks"] > 0
    assert told.get("done_here", 0) == 0


def test_a_portable_film_is_gone_on_with_as_it_began(rendered, tmp_path):
    folder, _ = rendered
    run(tmp_path, "-m", "alight", "resume", folder / "begun.alight", "--spp", "9", "-o", "a.alight",
        "--checkpoint", "b.alight", "-q")  # fmt: skip
    found, whole = Film.load(tmp_path / "a.alight"), Film.load(folder / "cluster.alight")
    np.testing.assert_array_equal(found.sums, whole.sums)
    assert found.options["tables"] == whole.options["tables"]
    assert found.fingerprint == whole.fingerprint
    # This process is native.
    assert fingerprint() != found.fingerprint == fingerprint("portable")


ESTIMATES = """
from lanewise.machine import choose_target
choose_target("portable")
import llvmlite.binding as llvm
import numpy as np
from numba import typeof
from lanewise.jit import dispatcher_of, kernel
from lanewise.simd import load_lanes, rsqrt, sqrt, store_lanes
from lanewise.view import View

@kernel
def reciprocals(numbers):
    x = load_lanes(numbers, 0)
    store_lanes(numbers, 0, 1.0 / sqrt(x) + 3.0 / x + sqrt(x) + rsqrt(x + 1.0))

dispatcher = dispatcher_of(reciprocals)
signature = (typeof(View(np.ones(8, np.float32))),)
dispatcher.compile(signature)
library = dispatcher.overloads[signature].library
print(library._codegen._tm.emit_assembly(library._final_module))
"""


def test_portable_code_takes_no_instruction_whose_bits_are_a_vendors(tmp_path):
    """Rsqrtps and rcpps give twelve good bits, and Intel and AMD other ones."""
    text = run(tmp_path, "-c", ESTIMATES)
    assert "vsqrtps" in text
    assert "vdivps" in text
    assert "%ymm" in text
    assert not re.search(r"\b(v?r(cp|sqrt)|%zmm)", text)


def has_avx2(emulator):
    told = subprocess.run([emulator, "--version"], capture_output=True, text=True).stdout
    version = re.search(r"version (\d+)\.(\d+)", told)
    return version is not None and (int(version[1]), int(version[2])) >= (7, 2)


@pytest.fixture(scope="module")
def portable_films(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bits")
    return folder, recorded_bits.render(folder, "own")[0]


@pytest.mark.proofs
def test_this_processor_gives_the_bits_that_another_recorded(portable_films):
    """Where it fails after a kernel was changed, `python -m tests.cluster.recorded_bits`."""
    record = json.loads(recorded_bits.RECORD.read_text("utf-8"))
    if record["compilers"] != recorded_bits.compilers():
        pytest.skip("recorded with other versions of the compiler or of NumPy")
    assert recorded_bits.digests(portable_films[1]) == record["films"]


@pytest.mark.proofs
@pytest.mark.skipif(EMULATOR is None or not has_avx2(EMULATOR), reason="needs qemu-user 7.2")
def test_emulated_processors_of_two_vendors_give_the_same_bits(portable_films):
    """The emulator's estimates of reciprocals have other bits; roundings are those of IEEE 754.

    The tables that NumPy makes must not depend on its choice of instructions, either.
    """
    folder, own = portable_films
    for processor, known in (("Haswell", "haswell"), ("EPYC", "znver1")):
        films, told = recorded_bits.render(folder, processor, (EMULATOR, "-cpu", processor))
        assert told == known
        for name, found in films.items():
            np.testing.assert_array_equal(found.sums, own[name].sums)
            assert found.fingerprint == own[name].fingerprint
            assert found.options["tables"] == own[name].options["tables"]


def test_a_process_compiles_for_one_target(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    load_compiler()
    with pytest.raises(alight.OptionError, match="has compiled for native: portable needs"):
        alight.render("cornell-box", size=8, spp=1, target="portable")
    done = CliRunner().invoke(app, ["render", "--target", "portabel"])
    assert done.exit_code == 2
    assert 'did you mean "portable"?' in done.stderr


def test_a_scene_whose_tables_come_out_otherwise_is_not_gone_on_with(rendered, tmp_path):
    folder, _ = rendered
    text = (
        "import alight, alight.rendering.job as job\n"
        "job.digest_of_tables = lambda tables: 'another'\n"
        "try:\n"
        f"    alight.resume({str(folder / 'begun.alight')!r}, spp=20)\n"
        "except alight.FilmError as error:\n"
        "    print(error)\n"
    )
    assert "NumPy gives the tables of its scene other bits here" in run(tmp_path, "-c", text)
