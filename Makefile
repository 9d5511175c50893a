# Everything here sets up what it needs: a virtual environment, the build and the dependencies.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
CARGO_FEATURES := std std,glam libm libm,glam

.DEFAULT_GOAL := help
.PHONY: help demo test test-rust test-python lint build stubs accuracy robustness endurance calibration papers browser
.PHONY: bench firmware header format clean

help: ## Show what there is
	@awk 'BEGIN {FS = ":.*## "} /^[a-z-]+:.*## / {printf "make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: build ## Simulate a recording, run every filter on it, print the errors, draw them into demo/
	$(BIN)/ahrs-rs demo -o demo

test: test-rust lint test-python ## Run all tests and checks

$(VENV)/.made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "ahrs_rs needs Python 3.11 or later; say which with PYTHON=..."; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.8,<2'
	@touch $@

build: $(VENV)/.made ## Build the package into the virtual environment, with all that tests and demo need
	$(BIN)/maturin develop --release --quiet --extras all,test

test-rust: ## Run the Rust tests with every set of features
	cargo test --workspace --exclude ahrs-rs-python --quiet
	@for features in $(CARGO_FEATURES); do \
		echo "core with --features $$features"; \
		cargo test --quiet --no-default-features --features $$features --test so3 --test trig || exit 1; \
	done

test-python: build ## Run the Python tests; those on real recordings need AHRS_RS_DATA
	$(BIN)/python -m pytest -q

lint: build ## Check format, lints, types and stubs
	cargo fmt --all --check && rustfmt --check --edition 2024 src/filters/*.rs
	cargo clippy --workspace --all-targets --quiet -- -D warnings
	cargo clippy --no-default-features --features libm --quiet -- -D warnings
	cd firmware && cargo fmt --check && cargo clippy --quiet --all-targets -- -D warnings
	$(BIN)/ruff format --check --quiet . && $(BIN)/ruff check --quiet .
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest --allowlist tools/stubtest-allowlist.txt ahrs_rs
	$(BIN)/python tools/stubs.py --check

stubs: build ## Write the type stubs of the filter classes from the registry
	$(BIN)/python tools/stubs.py

accuracy: build ## Score every filter on real recordings (AHRS_RS_DATA) into docs/accuracy.md
	$(BIN)/python tools/accuracy.py

robustness: build ## Lose, clip and damage measurements (AHRS_RS_DATA), and see how the filters come back: docs/robustness.md
	$(BIN)/python tools/robustness.py

endurance: build ## Run float32 beside float64 for a day of readings at 1 kHz into docs/endurance.md; an hour, can be resumed
	$(BIN)/python tools/endurance.py

papers: build ## Reproduce the five papers (AHRS_RS_DATA) into docs/papers.md
	$(BIN)/python tools/papers.py

browser: ## Install the browser (Debian, root) that the test of the papers' report looks for; without it: skipped
	apt-get update && apt-get install --yes --no-install-recommends chromium

calibration: build ## Calibrate the magnetometers of real recordings (AHRS_RS_DATA) into docs/calibration.md
	$(BIN)/python tools/calibration.py

bench: build ## Time every filter beside other packages into docs/performance.md, and the core by itself
	$(BIN)/python -m pip install --quiet 'vqf>=2.1' 'ahrs>=0.3.1' 'imufusion==1.3.3'
	$(BIN)/python benches/peers.py
	$(BIN)/python benches/calibration.py
	cargo bench --quiet

firmware: ## Run every filter on an emulated Cortex-M, compare it with the host, write docs/firmware.md
	$(PYTHON) tools/firmware.py

header: ## Write the C header from its source and the registry
	AHRS_WRITE_HEADER=1 cargo test --quiet --package ahrs-rs-capi --test header

format: build ## Format everything
	cargo fmt --all && rustfmt --edition 2024 src/filters/*.rs && cd firmware && cargo fmt
	$(BIN)/ruff format . && $(BIN)/ruff check --fix .

clean: ## Remove what was built
	rm -rf target $(VENV) demo
