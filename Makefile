# Everything sets itself up in .venv; it takes python3 (3.11 or newer) with its venv module, and make.

PYTHON ?= python3
BIN := .venv/bin
READY := .venv/ready
# Another Python, on which the tests run too: the newest after $(PYTHON) that is found and works.
NEWER := $(shell for v in 14 13 12; do for p in python3.$$v $(HOME)/.pyenv/versions/3.$$v.*/bin/python; do \
	[ "$$($$p -c 'import sys; print(sys.version_info[1])' 2>/dev/null)" = $$v ] && \
	[ "$$($(PYTHON) -c 'import sys; print(sys.version_info[1])')" -lt $$v ] && echo $$p && exit; done; done)

# What hardly depends on Python and takes long runs on one of them.
ON_NEWER = --ignore=tests/fuzz --ignore=tests/physics --ignore=tests/commands --ignore=tests/evaluation/report

.PHONY: evaluate fuzz test test-newer check lint format types wheel bench bench-against bench-peers scaling work-precision clean

evaluate: $(READY)
	$(BIN)/soft-gripper evaluate --out results/evaluation

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist loadscope
	@$(MAKE) --no-print-directory test-newer

test-newer:
ifeq ($(NEWER),)
	@echo "No Python 3.12 or newer was found: the tests ran on one Python only."
else
	$(NEWER) -m venv .venv-newer
	.venv-newer/bin/python -m pip install -q -c constraints.txt -e .[dev]
	.venv-newer/bin/python -m pytest -n 2 --dist loadscope $(ON_NEWER)
endif

check: lint types
	$(BIN)/python -m pytest -n 2 --dist loadscope

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# mypy wants the folders laid out as they are installed.
types: $(READY)
	rm -rf build/types && mkdir -p build/types && cp -r soft_gripper build/types/
	cp -r models diagrams evaluation pictures learning commands build/types/soft_gripper/
	cd build/types && $(abspath $(BIN))/mypy --config-file ../../pyproject.toml -p soft_gripper

# Hostile input, FUZZ of every kind, new ones every time.
FUZZ ?= 1000
fuzz: $(READY)
	FUZZ=$(FUZZ) $(BIN)/python -m pytest -q tests/fuzz

wheel: $(READY)
	rm -rf dist build/lib
	$(BIN)/python -m build --wheel

bench: $(READY)
	$(BIN)/python benchmarks/bench.py

# Against another checkout: make bench-against OTHER=../before, where `make .venv/ready` was done.
bench-against: $(READY)
	$(BIN)/python benchmarks/compare.py $(OTHER)

bench-peers: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt -e .[peers]
	$(BIN)/python benchmarks/bench_peers.py

scaling: $(READY)
	$(BIN)/python benchmarks/scaling.py

work-precision: $(READY)
	$(BIN)/python benchmarks/work_precision.py

clean:
	rm -rf .venv .venv-newer build dist results *.egg-info

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -q -c constraints.txt -e .[dev]
	touch $(READY)
