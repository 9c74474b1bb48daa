# `make` alone lists the targets. Everything runs in .venv, which is made from requirements.lock.

SHELL := /bin/sh
VENV := .venv
PY := $(VENV)/bin/python
# Written as the very last step of the installation: an interrupted one has no stamp and is redone.
STAMP := $(VENV)/.complete
PIP_INSTALL := $(PY) -m pip install -qq --no-input --disable-pip-version-check
# Tried in this order; name one yourself with `make PYTHON=/path/to/python3 ...`.
PYTHON := python3 python3.13 python3.12 python3.11
# Limit the cores used by a study with `make reproduce CORES=2`; the profiles say how many else.
CORES :=
# Where the jobs run: this machine, or with PROFILE=workflow/profiles/slurm a cluster.
PROFILE := workflow/profiles/default
RUN = $(PY) workflow/run.py --workflow-profile "$(PROFILE)" $(if $(CORES),--cores $(CORES))

# Only what is in .venv counts, not what the user has elsewhere.
unexport PYTHONPATH
unexport PYTHONHOME
export PYTHONNOUSERSITE := 1

# One BLAS/OpenMP thread in pytest; in the workflow's jobs Snakemake itself sets these variables
# to the `threads:` of the rule.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: help reproduce beyond survey bench growth roundtrip taper designs notebooks study check
.PHONY: bless setup test fuzz test-slurm test-faults mutations lint format lock clean
.DEFAULT_GOAL := help

help:
	@echo "make reproduce             install everything into .venv, run the study, list the figures"
	@echo "make beyond                the study of what lies beyond the paper, studies/beyond.yaml"
	@echo "make study STUDY=my.yaml   the same for the study in my.yaml instead of config.yaml"
	@echo "                           (all three take CORES=n to use only n cores, and"
	@echo "                           PROFILE=workflow/profiles/slurm to run on a cluster)"
	@echo "make check                 compare the results with the reference tables"
	@echo "make bless                 make the reference tables anew; review them with git diff"
	@echo "                           (both take STUDY=my.yaml and REFERENCE=folder)"
	@echo "make test                  all tests"
	@echo "make test-slurm            a study on a SLURM that is brought up for it (Debian, root)"
	@echo "make test-faults           kill runs, fill disks, damage files: see docs/faults.md"
	@echo "make survey                100,000 random points in both contact models, counted by outcome"
	@echo "make bench                 states per second of four methods, side by side"
	@echo "make growth                time and memory of studies of 10^4 to 10^6 points, into docs/speed.md"
	@echo "                           (ARGS='--points 1e7' for ten million)"
	@echo "make roundtrip             friction of 1,000 random surfaces from their signals, into docs/sensor.md"
	@echo "                           (20 minutes; ARGS='--seeds 50' for a look)"
	@echo "make designs               the paper's rod against its limits, and the best of each material"
	@echo "make taper                 whether a tapered rod measures friction better (docs/taper.png)"
	@echo "make notebooks             run the notebooks of examples/ anew, with their outputs"
	@echo "make fuzz                  11,100 damaged recordings: named, or no harm done (docs/fuzz.md)"
	@echo "make mutations             whether make check notices broken physics; takes minutes"
	@echo "make lint                  ruff, snakefmt, snakemake --lint, mypy"
	@echo "make format                let ruff and snakefmt rewrite the source files"
	@echo "make lock                  bring requirements.lock in line with pyproject.toml"
	@echo "                           (UPGRADE=1: and move to the newest versions)"
	@echo "make clean                 remove .venv and caches; results stay"

reproduce: $(STAMP)
	@$(RUN)

beyond: $(STAMP)
	@$(RUN) --configfile studies/beyond.yaml

# Asked before the installation starts, not after it.
ifeq ($(MAKECMDGOALS)$(STUDY),study)
$(error Say which study: make study STUDY=path/to/my.yaml)
endif
study: $(STAMP)
	@$(RUN) --configfile "$(STUDY)"

CHECK := workflow/check.py $(if $(STUDY),--configfile "$(STUDY)") \
    $(if $(REFERENCE),--reference "$(REFERENCE)")

check: $(STAMP)
	@$(PY) $(CHECK)

bless: $(STAMP)
	@$(PY) $(CHECK) --bless

setup: $(STAMP)

# The stamp holds the folder's path: in a moved or copied folder .venv still points to the old one.
ifneq ($(shell cat $(STAMP) 2>/dev/null),$(CURDIR))
.PHONY: $(STAMP)
endif

# Each shell test ends in one plain line for the user instead of a Python traceback.
$(STAMP): requirements.lock pyproject.toml
	@python=; for p in $(PYTHON); do \
	    if "$$p" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' \
	        2>/dev/null; then python=$$p; break; fi; \
	done; \
	if [ -z "$$python" ]; then \
	    echo "Python 3.11, 3.12 or 3.13 is needed; tried: $(PYTHON)." \
	        "Install one, or name it: make PYTHON=/path/to/python3 ..." >&2; exit 1; \
	fi; \
	if ! "$$python" -c 'import venv, ensurepip' 2>/dev/null; then \
	    echo "$$python has no working venv module (on Debian/Ubuntu: apt install python3-venv)." \
	        >&2; exit 1; \
	fi; \
	echo "Setting up $(VENV) with $$("$$python" --version): downloading and installing the locked" \
	    "packages, a minute or two ..."; \
	rm -rf $(VENV) && "$$python" -m venv $(VENV)
# setuptools first: one locked package (connection_pool) has no wheel, and pip would otherwise
# fetch some setuptools without a pin or a hash to build it.
	@awk '/^[a-z]/ { keep = /^setuptools==/ } keep' requirements.lock > $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --require-hashes -r $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --require-hashes --no-build-isolation --use-pep517 -r requirements.lock
	@$(PIP_INSTALL) --no-deps --no-build-isolation --no-index --editable .
	@echo "$(CURDIR)" > $(STAMP)

test: $(STAMP)
	@$(ONE_THREAD) $(PY) -m pytest $(ARGS)

# Apart from `test`, as it installs SLURM; it says so and succeeds where that is not possible.
test-slurm: $(STAMP)
	@$(ONE_THREAD) $(PY) -m pytest tests/slurm $(ARGS)

bench: $(STAMP)
	@$(ONE_THREAD) $(PY) -m pytest benchmarks/bench_states.py -q \
	    --benchmark-json=.benchmarks.json --benchmark-disable-gc >/dev/null
	@$(PY) benchmarks/table.py .benchmarks.json

survey: $(STAMP)
	@$(ONE_THREAD) $(PY) benchmarks/survey.py $(ARGS)

# Not with one thread by ONE_THREAD: it is the workflow's jobs that are measured, as they are.
growth: $(STAMP)
	@$(PY) benchmarks/growth.py $(ARGS)

designs: $(STAMP)
	@$(ONE_THREAD) $(PY) benchmarks/designs.py $(ARGS)

roundtrip: $(STAMP)
	@$(ONE_THREAD) $(PY) benchmarks/roundtrip.py \
	    $(or $(ARGS),--seeds 1000 --docs docs/sensor.md --figure docs/roundtrip.png)

# Two minutes; fails if any recording gives a traceback or silently a wrong number.
fuzz: $(STAMP)
	@$(ONE_THREAD) $(PY) tests/fuzzing.py $(ARGS)

notebooks: $(STAMP)
	@$(ONE_THREAD) $(PY) examples/rerun.py $(ARGS)

taper: $(STAMP)
	@$(ONE_THREAD) $(PY) benchmarks/taper.py --figure docs/taper.png $(ARGS)

mutations: $(STAMP)
	@$(ONE_THREAD) $(PY) tests/mutations.py

# Apart from `test`, as it takes minutes; writes what came out into docs/faults.md.
test-faults: $(STAMP)
	@FAULTS_TABLE=docs/faults.md $(ONE_THREAD) $(PY) -m pytest tests/faults $(ARGS)

lint: $(STAMP)
	$(PY) -m ruff check
	$(PY) -m ruff format --check
	$(PY) -m snakefmt --check Snakefile workflow
	$(PY) workflow/lint.py
	$(PY) -m mypy src

format: $(STAMP)
	$(PY) -m ruff check --fix
	$(PY) -m ruff format
	$(PY) -m snakefmt Snakefile workflow

# One lock for Python 3.11-3.13, Linux and macOS; `fewest`: the same version on all of them.
lock: $(STAMP)
	@$(PY) -m uv pip compile pyproject.toml --extra dev --output-file requirements.lock --quiet \
	    --universal --python-version 3.11 --fork-strategy fewest --generate-hashes \
	    --no-emit-index-url --no-config --custom-compile-command "make lock" \
	    $(if $(UPGRADE),--upgrade)
	@echo "requirements.lock is written; put changed versions of direct dependencies into" \
	    "environment.yml too (make test tells which)."

# .snakemake stays: it remembers with which code and settings the results were made.
clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .mypy_cache .hypothesis build dist
	find src tests workflow -name __pycache__ -type d -prune -exec rm -rf {} +
	@echo "Results are kept; to drop those of one study: rm -r results/<study>"
