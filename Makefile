# Every target sets up .venv; this needs Python (3.11 or newer) with its venv module, and make.

# The Pythons that are found, one of each version, newest first: 3.12 and newer have a newer Drake.
PYTHONS = $(shell for v in 14 13 12 11; do for p in python3.$$v python3 $(HOME)/.pyenv/versions/3.$$v.*/bin/python; do \
	[ "$$($$p -c 'import ensurepip, sys; print(sys.version_info[1])' 2>/dev/null)" = $$v ] && echo $$p && break; done; done)
# That of .venv, once and for all: make PYTHON=python3.11 chooses another one.
PYTHON ?= $(or $(firstword $(PYTHONS)),python3)
# A second Python to run the tests on: the oldest, if it is older than that of .venv.
OLDER = $(shell $(lastword $(PYTHONS)) -c 'import sys; print(sys.executable if sys.version_info[1] < $(MINOR) else "")')
MINOR = $(shell $(BIN)/python -c 'import sys; print(sys.version_info[1])')
BIN := .venv/bin
READY := .venv/ready
STUDIES = $(BIN)/python -m studies

.PHONY: evaluate fuzz kills soak test test-newer test-slow test-older test-older-extras older check lint format types contact-points bench bench-against bench-export bench-peers scaling work-precision verification verification-soft release-check clean

evaluate: $(READY)
	$(BIN)/soft-gripper evaluate --out results/evaluation

# Three on two cores: some tests wait for browsers, sockets and processes. One thread each: more are slower on matrices
# as small as those of a finger.
PYTEST = python -m pytest -n 3 --dist loadscope
QUICK = "not slow and not published"
test-newer test-slow test-older test-older-extras check: export OPENBLAS_NUM_THREADS = 1

# On the older Python too where the newer one fails.
test: $(READY)
	@failed=; for python in newer older; do $(MAKE) --no-print-directory test-$$python || failed="$$failed test-$$python"; done; \
	if [ "$$failed" ]; then echo "Failed:$$failed"; false; fi

# CPU=avx2: as on a processor without AVX-512, where numpy's last digits differ.
ifeq ($(CPU),avx2)
test-newer: export NPY_DISABLE_CPU_FEATURES = $(shell $(BIN)/python .ci/newer_cpu_features)
endif
test-newer: $(READY)
	$(BIN)/$(PYTEST) -m $(QUICK)

# Long runs, which hardly depend on the version of Python. In the order of the files: by the number of its tests, the
# file that takes longest would come last, and run alone.
test-slow: $(READY)
	$(BIN)/$(PYTEST) --no-loadscope-reorder -m "slow and not published"

# On the older Python the tests of the core run in a copy of the tree that has no extras.
test-older: older
	$(or $(if $(OLDER),$(TEST_CORE)),@echo "$(ONE_PYTHON): the tests ran on one only.")
# Those of the extras take five minutes more: before a release.
test-older-extras: older
	$(or $(if $(OLDER),.venv-older/bin/$(PYTEST) -m $(QUICK) tests/extras tests/studies),@echo "$(ONE_PYTHON).")
CORE = $(abspath .core)
WITHOUT = ./soft_gripper/extras/[a-z]* ./studies ./tests/extras ./tests/studies ./.git ./.venv* ./.core ./results
TEST_CORE = rm -rf $(CORE) && mkdir $(CORE) && tar cf - $(patsubst %,--exclude='%',$(WITHOUT)) . | tar xf - -C $(CORE) && \
	(cd $(CORE) && PYTHONPATH=$(CORE) $(abspath .venv-older)/bin/$(PYTEST) -m $(QUICK))

# The environment for that; it may be made while tests run in .venv, but once.
ONE_PYTHON = No Python older than that of .venv was found
older: $(READY)
	$(or $(if $(OLDER),$(LOCKED) sh -c '$(MAKE_OLDER)'),@echo "$(ONE_PYTHON).")
LOCKED = $(if $(shell command -v flock),flock .venv/ready)
MAKE_OLDER = test .venv-older/ready -nt .venv/ready || { $(OLDER) -m venv .venv-older && \
	.venv-older/bin/python -m pip install -q -c constraints.txt -e .[dev] && touch .venv-older/ready; }

check: lint types
	$(BIN)/$(PYTEST) -m $(QUICK)

lint: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

format: $(READY)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

types: $(READY)
	$(BIN)/mypy

# Hostile input, FUZZ cases of every kind, different in every run.
FUZZ ?= 1000
fuzz: $(READY)
	FUZZ=$(FUZZ) $(BIN)/python -m pytest -q tests/extras/fuzz

# Commands killed at random moments, KILLS times each; and runs for SOAK seconds, whose memory must not grow.
KILLS ?= 40
SOAK ?= 3600
kills: $(READY)
	KILLS=$(KILLS) $(BIN)/python -m pytest -q tests/extras/endurance/test_random_kills.py tests/extras/endurance/test_live_kills.py
soak: $(READY)
	SOAK=$(SOAK) $(BIN)/python -m pytest -q tests/extras/endurance/test_soak.py

# Before a release: the numbers that README and docs print, compared with what the evaluation writes, and computed anew
# from published recordings, where those are (SOFT_GRIPPER_DATA).
release-check: evaluate test-older-extras
	$(BIN)/$(PYTEST) -m published
	EVALUATION=$(abspath results/evaluation) $(BIN)/python -m pytest -q tests/extras/docs/test_published.py

# Wheel and sdist, installed without a network into an empty environment of every Python from 3.11 to 3.14 that is found.
.PHONY: dist installs
dist: $(READY)
	rm -rf dist build/lib
	$(BIN)/python -m build
installs: dist
	.ci/installs

contact-points: $(READY)
	$(STUDIES) contact-points

bench: $(READY)
	$(STUDIES) block-costs

# The size and the order of the code, in numbers with their aims.
.PHONY: house
house: $(READY)
	$(STUDIES) house

# The words of every page, and their total with its aim.
.PHONY: words
words: $(READY)
	$(STUDIES) words

# Tips, forces and intervals of scenarios and contacts, before a change and after it: make oracle-store, oracle-compare.
.PHONY: oracle-store oracle-compare
oracle-store oracle-compare: $(READY)
	$(STUDIES) oracle $(subst oracle-,,$@) results/oracle

# Compared with another checkout, in which `make .venv/ready` was run: make bench-against OTHER=../before
bench-against: $(READY)
	$(STUDIES) compare $(OTHER)

bench-peers: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt -e .[peers]
	$(STUDIES) peers

# The same scenarios in Drake and, exported, in MuJoCo: fingertips, and 100 random grasps.
bench-export: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt -e .[mujoco]
	$(STUDIES) export-tips
	$(STUDIES) export-tips --time-step 0.002
	$(STUDIES) export-trials --time-step 0.002

scaling: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt -e .[mujoco]
	$(STUDIES) scaling
	$(STUDIES) many-runs

work-precision: $(READY)
	$(STUDIES) work-precision

# SPATIAL_RODS=FOLDER: solutions of another solver, see docs/verification.md.
verification: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt pyelastica
	$(STUDIES) verification

# Soft bodies between plates: the tables of docs/extras/soft/soft_objects.md, in a minute.
verification-soft: $(READY)
	$(STUDIES) verification --soft

# The site, in build/docs/html: pages and notebooks of the repository, and pages generated from the code. Every version
# has a folder there, as 0.2, beside those of earlier versions that are copied into it.
.PHONY: docs docs-links notebooks scenarios
SERIES = $(shell sed -n 's/^version = "\(.*\)\..*"/\1/p' pyproject.toml)
SPHINX = $(BIN)/sphinx-build -c docs/site -d build/docs/doctrees -j 2 -W --keep-going
docs: .venv/docs
	$(BIN)/python docs/site/stage.py build/docs/source
	$(SPHINX) -q build/docs/source build/docs/html/$(SERIES)
	rm -rf build/docs/html/jupyter_execute
	$(BIN)/python docs/site/list_versions.py build/docs/html
	SITE=$(abspath build/docs/html/$(SERIES)) $(BIN)/python -m pytest -q tests/extras/docs/test_rendered_pages.py

# After a change of a notebook, its outputs, and after one of a shipped scenario, what its page shows: a few minutes.
notebooks: .venv/docs
	$(BIN)/python docs/site/store_outputs.py
scenarios: $(READY)
	$(BIN)/python docs/site/store_scenarios.py

# External links, which need a network; after `make docs`.
docs-links: .venv/docs
	$(SPHINX) -b linkcheck build/docs/source build/docs/links

clean:
	rm -rf .venv .venv-older build dist results *.egg-info

.venv/docs: $(READY)
	$(BIN)/python -m pip install -q -c constraints.txt -e .[docs]
	touch $@

$(READY): pyproject.toml constraints.txt
	$(or $(wildcard $(BIN)/python),$(PYTHON)) -m venv .venv
	@echo "The environment .venv has $$($(BIN)/python --version); make clean and PYTHON=... choose another one."
	$(BIN)/python -m pip install -q -c constraints.txt -e .[dev]
	touch $(READY)
