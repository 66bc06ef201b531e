# Developer targets. Each first installs what it needs into .venv (once: stamp files remember);
# none needs a compiler, a GPU, OpenGL or a separate LLVM.
PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2
SEEDS ?= 0-1
SEED ?= 1
COUNT ?= 500
PORTION ?= 1/1
BIN := $(VENV)/bin
# The compiler, the core, all built-in scenes and the bits of films.
SMOKE := tests/lanewise tests/core tests/scene tests/options tests/determinism
# Where the number of lanes could matter: besides, what renders and what it meets.
LANES := tests/accel tests/film tests/media tests/physics tests/rendering tests/samplers tests/shapes
# --require-hashes: only the very files that were locked; --only-binary: never start a compiler.
PIP_LOCKED := --quiet --disable-pip-version-check --require-hashes --only-binary :all:
PIP_INSTALL := $(BIN)/python -m pip install $(PIP_LOCKED)
PACKAGE_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check \
	--no-deps --no-build-isolation --editable .

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup setup-dev demo test proofs smoke campaign mutants lint format types docs package \
	figures peers lock canary clean

help:
	@echo "make demo      install into .venv and render the Cornell box to cornell.png"
	@echo "make test      run the test suite (10 minutes on 2 cores)"
	@echo "make proofs    run the long statistics, the planted bugs and 8 lanes; every fourth case of"
	@echo "               long lists, from the second on: make proofs PORTION=2/4"
	@echo "make smoke     run a short suite: make smoke PYTHON=python3.13 VENV=.venv-3.13"
	@echo "make package   build wheel and sdist, install the wheel afresh and render with it"
	@echo "make campaign  check the invariants of rendering on random scenes (SEEDS=0-1)"
	@echo "make mutants   try random slips in the code against the tests (SEED=1 COUNT=500)"
	@echo "make lint      check style and import layers        make format  fix formatting with ruff"
	@echo "make types     check static types                   make docs    build the site in site/"
	@echo "make figures   render the figures of docs/          make peers   install Mitsuba and Embree"
	@echo "make canary    try the newest Numba and NumPy: what would they break in lanewise?"
	@echo "make lock      regenerate requirements/*.txt        make clean   remove everything built"

$(VENV)/.created:
	@$(PYTHON) -c 'import sys; v = sys.version_info; sys.exit(None if (3, 11) <= v < (3, 14) else \
	"alight needs Python 3.11, 3.12 or 3.13; this is %d.%d: make PYTHON=python3.12 ..." % v[:2])'
	@echo "creating $(VENV)"
	@$(PYTHON) -m venv --clear $(VENV)
	@touch $@

$(VENV)/.runtime: $(VENV)/.created requirements/runtime.txt pyproject.toml
	@echo "installing the locked dependencies"
	@$(PIP_INSTALL) --requirement requirements/runtime.txt
	@$(PACKAGE_INSTALL)
	@touch $@

$(VENV)/.dev: $(VENV)/.runtime requirements/dev.txt
	@echo "installing the locked development dependencies"
	@$(PIP_INSTALL) --requirement requirements/dev.txt
	@touch $@

$(VENV)/.docs: $(VENV)/.dev requirements/docs.txt
	@$(PIP_INSTALL) --requirement requirements/docs.txt
	@touch $@

$(VENV)/.peers: $(VENV)/.dev requirements/peers.txt
	@$(PIP_INSTALL) --requirement requirements/peers.txt
	@touch $@

setup: $(VENV)/.runtime

setup-dev: $(VENV)/.dev

demo: setup
	$(BIN)/alight render cornell-box --output cornell.png

# Tests start processes, which need not compile the sources again.
test smoke: export PYTHONDONTWRITEBYTECODE =

test: setup-dev
	$(BIN)/python -m pytest -n $(JOBS)

proofs: setup-dev
	# Where packets have 8 lanes anyway, `make test` was this, and more.
	[ "$$($(BIN)/python -c 'from lanewise import machine; print(machine.lanes_of_machine())')" = 8 ] || \
		ALIGHT_LANES=8 $(BIN)/python -m pytest -n $(JOBS) $(SMOKE) $(LANES)
	PORTION=$(PORTION) $(BIN)/python -m pytest -n $(JOBS) -m proofs

smoke: setup-dev
	$(BIN)/python -m pytest -n $(JOBS) $(SMOKE)

package: setup-dev
	rm -rf dist build/fresh
	$(BIN)/hatchling build --directory dist
	$(BIN)/python -m venv build/fresh
	build/fresh/bin/python -m pip install $(PIP_LOCKED) --requirement requirements/runtime.txt
	build/fresh/bin/python -m pip install --quiet --disable-pip-version-check --no-deps dist/*.whl
	cd build/fresh && bin/alight render cornell-box --spp 4 --output cornell.png

campaign: setup-dev
	$(BIN)/python benchmarks/campaign/run.py --seeds $(SEEDS)
	$(BIN)/python benchmarks/known_error/random_scenes.py --seeds $(SEEDS) --save campaign.jsonl

mutants: setup-dev
	$(BIN)/python -m tests.mutants.campaign --seed $(SEED) --count $(COUNT) --save mutants.jsonl

lint: setup-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/lint-imports

format: setup-dev
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

types: setup-dev
	$(BIN)/pyright --pythonpath $(BIN)/python

docs: $(VENV)/.docs
	$(BIN)/mkdocs build --strict

figures: setup
	set -e; for script in docs/figures/*.py; do echo $$script; $(BIN)/python $$script; done

peers: $(VENV)/.peers

lock:
	requirements/lock.sh

canary:
	PYTHON=$(PYTHON) NUMBA=$(NUMBA) requirements/canary.sh

clean:
	rm -rf $(VENV) build dist site .pytest_cache .ruff_cache .hypothesis .import_linter_cache
