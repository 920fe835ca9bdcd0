# Every target works as the first command in a fresh clone; it needs Python 3.11 or newer, make and a C compiler.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
BENCH_VENV := .venv-bench
RELEASE_VENV := .venv-release
REPORT := build/demo/report.html
DISSERTATION := build/demo/dissertation
REPRODUCTION := build/reproduction
CAMPAIGN := build/demo/campaign
# Modules are compiled when they are first imported: most of a library never is.
PIP_INSTALL = -m pip install --quiet --disable-pip-version-check --no-compile -c $(CURDIR)/constraints.txt
BENCH_PEERS := $(wildcard benchmarks/requirements.txt)
KERNEL_TESTS = $(shell grep -rl "mark.kernel" tests --include="test_*.py")
KERNEL_MODULES = $(shell grep -rlwE --include='*.py' 'njit|guvectorize' src)

export MPLBACKEND := Agg
# Modules compiled by one process serve all that follow, whatever a shell says.
unexport PYTHONDONTWRITEBYTECODE
# Two workers share the processor: threads of the linear algebra's own would wait for one another.
test check mutants verify: export OPENBLAS_NUM_THREADS := 1

ifndef SIDE_BY_SIDE  # `lint` alone runs parts of itself at once
.NOTPARALLEL:
endif
.DELETE_ON_ERROR:
.PHONY: help demo reproduce test lint lint-style lint-types lint-docstrings lint-house check mutants docs bench verify release format clean

help:
	@echo "make demo     the report on the packaged drives, the dissertation and a small campaign, in build/demo"
	@echo "make reproduce  the dissertation recomputed, item by item, in build/reproduction; ONLY=\"Fig. 5.3\""
	@echo "make test     format, lint, types, import contract, tests, examples, kernels without the compiler"
	@echo "make lint     the part of it that runs no test"
	@echo "make check    the part of it that a change needs first: lint, types and the fast tests, two minutes"
	@echo "make mutants  which of 200 changes to kernels and formulas the tests notice, into tests/mutants.md; a quarter of an hour"
	@echo "make verify   every test, the long statistical runs included, and the figures they measure"
	@echo "make docs     the documentation, into build/docs; a warning is an error"
	@echo "make bench    the figures of benchmarks/performance.md, measured on this machine"
	@echo "make release  wheel and source distribution in dist, checked and tried in an environment of their own"
	@echo "make format   rewrite the sources in the house format"
	@echo "make clean    remove environments and everything made"

demo: $(VENV)/run.stamp
	@mkdir -p $(dir $(REPORT))
	$(BIN)/python -m reproduction --quick -o $(DISSERTATION) --force
	$(BIN)/cabledrive sweep examples/tolerance_campaign.toml -o $(CAMPAIGN).zarr --workers 1 --force
	$(BIN)/cabledrive report $(CAMPAIGN).zarr --goal "longitudinal_hz[0] > 5.9 Hz" -o $(CAMPAIGN).html --force
	$(BIN)/cabledrive report -o $(REPORT) --link $(CAMPAIGN).html --link $(DISSERTATION)/report.html --force
	@echo "The report is in $(REPORT), the dissertation item by item in $(DISSERTATION)/report.html,"
	@echo "a campaign of 1,280 variants of one drive in $(CAMPAIGN).html"

reproduce: $(VENV)/run.stamp
	@mkdir -p $(dir $(REPRODUCTION))
	$(BIN)/python -m reproduction $(if $(ONLY),--only "$(ONLY)") -o $(REPRODUCTION) --force
	@echo "The dissertation, item by item, is in $(REPRODUCTION)/report.html"

test: lint
	$(BIN)/python -m pytest -n 2 --dist loadfile
ifneq ($(KERNEL_MODULES),)
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -n 2 --dist loadfile -m "kernel and not verify" --every-kernel $(KERNEL_TESTS)
endif

lint: $(VENV)/test.stamp
	$(MAKE) --no-print-directory -j2 SIDE_BY_SIDE=1 lint-types lint-docstrings lint-house lint-style

lint-types:
	$(BIN)/mypy

lint-docstrings:
	$(BIN)/numpydoc lint $$(find src -name '*.py')

lint-house:
	$(BIN)/python tools/lint.py

lint-style:
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/lint-imports --no-logo
	$(BIN)/check-jsonschema --quiet --builtin-schema vendor.github-workflows $(wildcard .github/workflows/*.yml)
	$(BIN)/check-jsonschema --quiet --builtin-schema vendor.github-issue-forms \
		$(filter-out %/config.yml,$(wildcard .github/ISSUE_TEMPLATE/*.yml))

# Fast tests: of the rooms below, those that took less than half a second when they were last run on this machine.
ROOMS := parameters mechanics trajectories modal simulation reduction identification control rig
check: lint
	$(BIN)/python -m pytest -n 2 --fast $(ROOMS:%=tests/%)

mutants: $(VENV)/test.stamp
	$(BIN)/python tools/mutants.py

verify: $(VENV)/test.stamp
	$(BIN)/python -m pytest -n 2 --dist worksteal --resume -m "verify or not verify" \
		-o faulthandler_timeout=7200 tests reproduction tools/attack

docs: $(VENV)/docs.stamp
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs build/docs
	@echo "The documentation is in build/docs/index.html"

bench: $(BENCH_VENV)/bench.stamp
	$(BENCH_VENV)/bin/python benchmarks/run.py

# The wheel is made from the source distribution, so that both are known to be whole, and tried where nothing else is.
release: $(RELEASE_VENV)/release.stamp
	@test -z "$$(git status --porcelain)" || { echo "make release: uncommitted changes: commit or stash them" >&2; exit 1; }
	rm -rf dist $(RELEASE_VENV)/try
	$(RELEASE_VENV)/bin/python -m build --outdir dist .
	$(RELEASE_VENV)/bin/python -m twine check --strict dist/*
	$(PYTHON) -m venv $(RELEASE_VENV)/try
	$(RELEASE_VENV)/try/bin/python $(PIP_INSTALL) dist/*.whl
	cd $(RELEASE_VENV)/try && bin/cabledrive modes dissertation-2 --below 120 && bin/cabledrive drives
	@ls -l dist

format: $(VENV)/test.stamp
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) $(BENCH_VENV) $(RELEASE_VENV) build dist docs/reference
	rm -rf .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find src tests benchmarks examples docs -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true

# One stamp per set of packages: what is installed is what pyproject.toml and constraints.txt say now.
$(VENV)/run.stamp: pyproject.toml constraints.txt
	$(call new-venv,$(VENV))
	$(BIN)/python $(PIP_INSTALL) -e ".[campaign]"
	@touch $@

$(VENV)/test.stamp: pyproject.toml constraints.txt
	$(call new-venv,$(VENV))
	$(BIN)/python $(PIP_INSTALL) -e ".[test]"
	@touch $@

$(VENV)/verify.stamp: $(VENV)/test.stamp
	$(BIN)/python $(PIP_INSTALL) -e ".[test,verify]"
	@touch $@

$(VENV)/docs.stamp: $(VENV)/run.stamp
	$(BIN)/python $(PIP_INSTALL) -e ".[docs]"
	@touch $@

$(RELEASE_VENV)/release.stamp: pyproject.toml constraints.txt
	$(call new-venv,$(RELEASE_VENV))
	$(RELEASE_VENV)/bin/python $(PIP_INSTALL) build twine
	@touch $@

$(BENCH_VENV)/bench.stamp: pyproject.toml constraints.txt $(BENCH_PEERS)
	$(call new-venv,$(BENCH_VENV))
	$(BENCH_VENV)/bin/python $(PIP_INSTALL) -e . $(addprefix -r ,$(BENCH_PEERS))
	@touch $@

define new-venv
@command -v $(PYTHON) >/dev/null || { echo "cabledrive needs Python 3.11 or newer; no $(PYTHON) found." >&2; exit 1; }
@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	echo "cabledrive needs Python 3.11 or newer; $(PYTHON) is `$(PYTHON) -V 2>&1`. Try: make PYTHON=python3.12 <target>" >&2; exit 1; }
$(PYTHON) -m venv $(1)
endef
