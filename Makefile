# `make demo` runs the main job on the bundled tests, `make test` the tests, `make check` all that a change must pass.
# Each sets up its own environment in .venv from the locked requirements.

PYTHON ?= python3
BIN := .venv/bin

.PHONY: check demo test test-fast lint bench lock clean

demo: .venv/base
	$(BIN)/narrows demo --out out

test: .venv/dev
	$(BIN)/python -m pytest -n auto --dist loadfile

# Without the tests that take some seconds.
test-fast: .venv/dev
	$(BIN)/python -m pytest -n auto --dist loadfile -m "not slow"

lint: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# What CI runs: the demo, lint, types, the import contracts, the tests with README, docs, examples and small benchmarks.
check: demo lint test

bench: .venv/dev
	$(BIN)/python -m pip install --quiet 'pip>=25.1'
	$(BIN)/python -m pip install --quiet --group bench
	for work in $(filter-out benchmarks/common.py benchmarks/former_kernel.py,$(wildcard benchmarks/*.py)); do $(BIN)/python $$work || exit 1; done

.venv/base: requirements/base.txt pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "narrows needs Python 3.11 or newer: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements/base.txt
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

.venv/dev: .venv/base requirements/dev.txt
	$(BIN)/python -m pip install --quiet --require-hashes -r requirements/dev.txt
	@touch $@

# Needs uv; writes the locked requirements anew.
lock:
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		pyproject.toml --group build -o requirements/base.txt
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		pyproject.toml --all-extras --group build --group test --group lint -o requirements/dev.txt

clean:
	rm -rf .venv out build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
