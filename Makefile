# Everything here sets up what it needs: a virtual environment, the build and the dependencies.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Modules are compiled when they are first imported, not all ten thousand of them now.
INSTALL := $(BIN)/python -m pip install --quiet --no-compile
# For recipes of several targets: two of them at a time, unless make was told how many.
SIDE_BY_SIDE = $(MAKE) --no-print-directory $(if $(filter -j%,$(MAKEFLAGS)),,--jobs=2)
CARGO_FEATURES := std std,glam libm libm,glam

.DEFAULT_GOAL := help
.PHONY: help demo test test-rust test-python lint build native stubs accuracy calibration papers browser bench firmware
.PHONY: aarch64 oracle wheel baseline pair dev attack robustness endurance header format formats damage tables check-table map names picture clean

help: ## Show what there is
	@awk 'BEGIN {FS = ":.*## "} /^[a-z0-9-]+:.*## / {printf "make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

# The demo compiles the vector instructions of this processor alone; whatever is built after it has all of them.
REGISTERS := $(if $(shell grep -m1 -wo avx512dq /proc/cpuinfo 2> /dev/null),avx512,avx2)
# Features of the native library, as options of cargo; none: all that are in a wheel.
FEATURES ?=

demo: ## Simulate a recording, run every filter on it, print the errors, draw them into demo/
	@echo "The filters are compiled, and the packages that they need are fetched: some two minutes the first time."
	@$(SIDE_BY_SIDE) build FEATURES="--no-default-features --features abi3,$(REGISTERS)"
	$(BIN)/ahrs-rs demo -o demo

test: ## Run all tests and checks
	@$(SIDE_BY_SIDE) dev
	@$(MAKE) --no-print-directory test-rust lint test-python

$(VENV)/.made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "ahrs_rs needs Python 3.11 or later; say which with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --upgrade 'pip>=26.3' 'maturin>=1.8,<2'
	@touch $@

# What the demo and the README's next lines need.
$(VENV)/.run: $(VENV)/.made pyproject.toml
	$(INSTALL) --only-deps --no-build-isolation '.[io,plot]'
	@touch $@

# What all tests and checks need.
$(VENV)/.test: $(VENV)/.run
	$(INSTALL) --only-deps --no-build-isolation '.[all]'
	$(INSTALL) --group test --group lint
	@touch $@

# Compiled in the open, beside the packages' installation; the editable package finds it done.
native: $(VENV)/.made
	$(BIN)/maturin develop --release --skip-install $(FEATURES)

$(VENV)/.installed: $(VENV)/.run pyproject.toml Cargo.toml | native
	$(INSTALL) --no-deps --no-build-isolation $(if $(FEATURES),--config-settings=build-args="$(FEATURES)") --editable .
	@touch $@

build: native $(VENV)/.installed ## Build the package into the virtual environment, with what the demo needs

dev: build $(VENV)/.test ## The same, with what tests, checks and tables need

# One test a process where nextest is installed, on all cores; it runs no documentation's examples.
test-rust: ## Run the Rust tests with every set of features
	@if cargo nextest --version > /dev/null 2>&1; then \
		set -x; \
		cargo nextest run --workspace --exclude ahrs-rs-python --cargo-quiet --status-level fail && \
		cargo test --workspace --exclude ahrs-rs-python --quiet --doc; \
	else \
		set -x; \
		cargo test --workspace --exclude ahrs-rs-python --quiet; \
	fi
	@for features in $(CARGO_FEATURES); do \
		echo "core with --features $$features"; \
		cargo test --quiet --no-default-features --features $$features --test so3 --test trig || exit 1; \
	done

# A worker on every core, of one thread each; the tests of threads by themselves, with all cores.
test-python: dev ## Run the Python tests; those on real recordings need AHRS_RS_DATA
	RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 \
		$(BIN)/python -m pytest -q --numprocesses auto --dist loadfile -m 'not threads'
	$(BIN)/python -m pytest -q -m threads

lint: dev ## Check format, lints, types and stubs
	cargo fmt --all --check && rustfmt --check --edition 2024 src/filters/*.rs
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	cargo clippy --no-default-features --features libm --quiet -- -D warnings
	cd firmware && cargo fmt --check && cargo clippy --quiet --all-targets -- -D warnings
	$(BIN)/ruff format --check --quiet . && $(BIN)/ruff check --quiet .
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest --allowlist tools/stubtest-allowlist.txt ahrs_rs
	$(BIN)/python tools/stubs.py --check
	$(BIN)/python tools/map.py --check
	$(BIN)/python tools/names.py --check

oracle: dev ## Compute all results of the oracles in full, compare every row, keep what is new (ARGS="-k vqf": some)
	AHRS_RS_ORACLE=all RAYON_NUM_THREADS=1 OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q --numprocesses auto $(ARGS) \
		tests/python/test_oracle.py tests/python/test_oracle_losses.py tests/python/test_mag_delay.py \
		tests/python/test_offline_selfcal.py

stubs: dev ## Write the type stubs of the filter classes from the registry
	$(BIN)/python tools/stubs.py

accuracy: dev ## Score every filter on real recordings (AHRS_RS_DATA) into docs/accuracy.md, and what `check` may promise
	$(BIN)/python tools/accuracy.py
	$(BIN)/python tools/check_expected.py

picture: dev ## Draw the README's picture from real recordings (AHRS_RS_DATA): docs/picture.png
	$(BIN)/python tools/picture.py

robustness: dev ## Lose, clip and damage measurements (AHRS_RS_DATA), and see how the filters come back: docs/robustness.md
	$(BIN)/python tools/robustness.py

endurance: dev ## Run float32 beside float64 for a day of readings at 1 kHz into docs/endurance.md; an hour, can be resumed
	$(BIN)/python tools/endurance.py

check-table: dev ## Plant faults into recordings (AHRS_RS_DATA) and see what `check` finds: docs/check.md; half an hour
	$(BIN)/python tools/check_table.py

papers: dev ## Reproduce the five papers (AHRS_RS_DATA) into docs/papers.md
	$(BIN)/python tools/papers.py

browser: ## Install the browser (Debian, root) that the test of the papers' report looks for; without it: skipped
	apt-get update && apt-get install --yes --no-install-recommends chromium

calibration: dev ## Calibrate the magnetometers of real recordings (AHRS_RS_DATA) into docs/calibration.md
	$(BIN)/python tools/calibration.py

map: dev ## Draw what imports what, crates and Python modules, into docs/map.md
	$(BIN)/python tools/map.py

names: dev ## Write what one quantity is called in each filter into docs/names.md
	$(BIN)/python tools/names.py

tables: dev ## Write what tables are understood into docs/tables.md
	$(BIN)/python tools/tables.py

formats: dev ## Read a file of every format, and write what each of them gives into docs/formats.md
	$(BIN)/python -m pip install --quiet 'pymavlink>=2.4.50'
	$(BIN)/python tools/formats.py

damage: dev ## Read a thousand damaged files of every format: an error or what is left, never a crash
	$(BIN)/python -m pip install --quiet 'pymavlink>=2.4.50'
	$(BIN)/python tools/damage.py

bench: dev ## Time every filter beside other packages into docs/performance.md, and the core by itself
	$(BIN)/python benches/peers.py
	$(BIN)/python benches/calibration.py
	$(BIN)/python benches/reading.py
	cargo bench --quiet

wheel: $(VENV)/.made ## Build a wheel into target/wheels, without the symbols that a test counts
	$(BIN)/maturin build --release --strip

# "Today" of all ratios: the build before the crates were split. Another one by BASELINE=..., beside it.
BASELINE ?= 3962d5a
PAST := target/baseline/$(BASELINE)

baseline: $(PAST)/.made ## Build the package as it was at commit BASELINE, for `make pair`

$(PAST)/.made: $(VENV)/.made
	rm -rf $(PAST) && mkdir -p $(PAST)/source
	git archive --output $(PAST)/source.tar $(BASELINE) && tar -xf $(PAST)/source.tar -C $(PAST)/source
	$(BIN)/maturin build --release --manifest-path $(PAST)/source/crates/python/Cargo.toml --out $(PAST)
	$(INSTALL) --no-deps --target $(PAST)/python $(PAST)/*.whl
	rm -rf $(PAST)/source.tar $(PAST)/source/target
	@touch $@

pair: build baseline ## Time this build beside the one of the past (ARGS="--filter VQF ..."; ARGS=--help lists them)
	$(BIN)/python benches/pair.py --old $(PAST)/python $(ARGS)

attack: dev ## End commands at random moments and look for leaks (hours) into docs/attacks.md
	$(BIN)/python tools/attack.py

firmware: ## Run every filter on an emulated Cortex-M, compare it with the host, write docs/firmware.md
	$(PYTHON) tools/firmware.py

aarch64: ## Run the Rust tests of core and batch engine for aarch64 in an emulator
	$(PYTHON) tools/aarch64.py

header: ## Write the C header from its source and the registry
	AHRS_WRITE_HEADER=1 cargo test --quiet --package ahrs-rs-capi --test header

format: dev ## Format everything
	cargo fmt --all && rustfmt --edition 2024 src/filters/*.rs && cd firmware && cargo fmt
	$(BIN)/ruff format . && $(BIN)/ruff check --fix .

clean: ## Remove what was built
	rm -rf target $(VENV) demo
