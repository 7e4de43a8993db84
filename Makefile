# `make demo` runs the main job on the bundled tests, `make test` the tests, `make docs` builds the site, `make check` all
# that a change must pass. Each sets up its own environment in .venv from the locked requirements.

PYTHON ?= python3
BIN := .venv/bin
# Modules are compiled when they are first imported: to compile all of them takes two minutes of an installation.
INSTALL := -m pip install --quiet --no-compile

.PHONY: check demo test test-fast test-whole lint docs site-check bench package newest newest-whole lock clean

demo: .venv/base
	$(BIN)/narrows demo --out out

test: .venv/dev
	$(BIN)/python -m pytest -n auto --dist worksteal

# Without the tests that take some seconds.
test-fast: .venv/dev
	$(BIN)/python -m pytest -n auto --dist worksteal -m "not slow"

# With the tests marked whole, every cell of the matrix of voyages among them: half an hour more.
test-whole: .venv/dev
	NARROWS_WHOLE=1 $(BIN)/python -m pytest -n auto --dist worksteal

lint: .venv/dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# What CI runs: the demo, lint, types, the import contracts, the package, the newest Python, the site's pages and links, the
# tests with README, docs, examples and small benchmarks.
check: .venv/dev
	$(MAKE) -j2 --output-sync=target .venv/zig package site-check lint demo newest
	$(MAKE) test

# The site, in out/site; it takes minutes, for its pages are run.
docs: .venv/compiler
	$(BIN)/sphinx-build --fresh-env --fail-on-warning --keep-going docs out/site

# The site's pages, references and links, none of them run: the tests do that.
site-check: .venv/docs
	$(BIN)/sphinx-build --quiet -t unrun --fresh-env --fail-on-warning --keep-going docs out/site-check

bench: .venv/dev
	$(BIN)/python $(INSTALL) 'pip>=25.1'
	$(BIN)/python $(INSTALL) --group bench
	for work in $(filter-out benchmarks/common.py,$(wildcard benchmarks/*.py)); do $(BIN)/python $$work || exit 1; done

.venv/base: requirements/base.txt pyproject.toml
	@$(PYTHON) requirements/check_machine.py
	$(PYTHON) -m venv .venv
	$(BIN)/python $(INSTALL) --require-hashes -r requirements/base.txt
	$(BIN)/python $(INSTALL) --no-deps --no-build-isolation --editable .
	@touch $@

.venv/dev: .venv/base requirements/dev.txt
	$(BIN)/python $(INSTALL) --require-hashes -r requirements/dev.txt
	@touch $@

# Builds sdist and wheel from it, and installs each into an empty environment where the demo must run.
package: .venv/package
	PYTHON=$(PYTHON) .ci/package

# The demo and the tests that are not slow on python3.15 or python3.14, where the machine has one.
newest:
	PYTHON=$(PYTHON) .ci/newest

# All that `make test` runs, there.
newest-whole:
	NARROWS_NEWEST_ALL=1 PYTHON=$(PYTHON) .ci/newest

.venv/package: .venv/base requirements/package.txt
	$(PYTHON) -m venv .venv/tools
	.venv/tools/bin/python $(INSTALL) --require-hashes -r requirements/package.txt
	@touch $@

.venv/docs: .venv/base requirements/docs.txt
	$(BIN)/python $(INSTALL) --require-hashes -r requirements/docs.txt
	@touch $@

# What builds FMUs and pages for any machine; 80 MB.
.venv/compiler: .venv/docs requirements/compiler.txt
	$(BIN)/python $(INSTALL) --require-hashes -r requirements/compiler.txt
	@touch $@

# Needs uv; writes the locked requirements anew.
# Every extra but fmu: its compiler is 80 MB, and the tests make do with the machine's own.
EXTRAS := $(addprefix --extra ,charts compiled control excel monitor nmea parquet)

lock:
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		pyproject.toml --group build -o requirements/base.txt
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		pyproject.toml $(EXTRAS) --group build --group test --group lint -o requirements/dev.txt
	echo 'ziglang>=0.13' | uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes \
		--no-header - -o requirements/compiler.txt
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		--group package -o requirements/package.txt
	uv pip compile --quiet --universal --python-version 3.11 --no-emit-index-url --generate-hashes --no-header \
		pyproject.toml --extra compiled --group build --group docs -c requirements/dev.txt -o requirements/docs.txt

# The same beside the environment, for the tests of WebAssembly alone: FMUs are then built for this machine, in seconds.
.venv/zig: .venv/base requirements/compiler.txt
	$(BIN)/python $(INSTALL) --require-hashes --upgrade --target $@ -r requirements/compiler.txt
	@touch $@

clean:
	rm -rf .venv out build dist docs/gallery docs/pictures docs/_static/ready docs/reference/api .pytest_cache .mypy_cache .ruff_cache .hypothesis
