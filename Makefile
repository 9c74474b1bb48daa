# `make` alone lists the targets. Everything runs in .venv, which is made from locks/.

SHELL := /bin/sh
VENV := .venv
PY := $(VENV)/bin/python
# What is installed follows what is done: each of these has a lock file, and a stamp that is written
# as the last step of its installation. An interrupted one has no stamp and is redone.
STUDY_STAMP := $(VENV)/.study
TEST_STAMP := $(VENV)/.test
DOCS_STAMP := $(VENV)/.docs
LINT_STAMP := $(VENV)/.lint
CLUSTER_STAMP := $(VENV)/.cluster
PIP_INSTALL := $(PY) -m pip install -qq --no-input --disable-pip-version-check
# Tried in this order; name one yourself with `make PYTHON=/path/to/python3 ...`.
PYTHON := python3 python3.13 python3.12 python3.11
# Limit the cores used by a study with `make reproduce CORES=2`; the profiles say how many else.
CORES ?=
# Where the jobs run: this machine, or with PROFILE=workflow/profiles/slurm a cluster.
PROFILE ?= workflow/profiles/default
# What a run needs: a cluster's profile has its plugins, too.
RUN_STAMPS = $(STUDY_STAMP) $(if $(filter-out default,$(notdir $(PROFILE:/=))),$(CLUSTER_STAMP))
RUN = $(PY) workflow/run.py --workflow-profile "$(PROFILE)" $(if $(CORES),--cores $(CORES))

# Only what is in .venv counts, not what the user has elsewhere.
unexport PYTHONPATH
unexport PYTHONHOME
export PYTHONNOUSERSITE := 1

# One BLAS/OpenMP thread in pytest; in the workflow's jobs Snakemake itself sets these variables
# to the `threads:` of the rule.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: help reproduce study beyond mounted check bless proof proof-sample archive verify test known test-slurm test-faults mutations mutate lint
.PHONY: laboratory costs survey chains trailing roundtrip fuzz published explorer explorer-agreement explorer-speed designs taper bench growth
.PHONY: docs setup notebooks architecture schema sketch format lock clean
.DEFAULT_GOAL := help

help:
	@echo "Studies (each takes CORES=n, and PROFILE=workflow/profiles/slurm for a cluster):"
	@echo "  make reproduce            the paper's study: Figures 3 to 8, tables, report"
	@echo "  make study STUDY=my.yaml  the study in my.yaml instead of config.yaml"
	@echo "  make beyond               studies/beyond.yaml: strong taper, line contact, self-locking"
	@echo "  make mounted              studies/mounted.yaml: inclined and yielding clamps, curved rods"
	@echo "  make check                compare the results with the reference tables"
	@echo "  make bless                update the reference tables; review them with git diff"
	@echo "                            (check and bless take STUDY=my.yaml and REFERENCE=folder,"
	@echo "                            of reference tables or for check of other results;"
	@echo "                            check writes a summary, JSON and a diff to OUTPUT=folder)"
	@echo "  make proof                prove the numbers of the paper's study, for make check"
	@echo "                            (takes STUDY=my.yaml, CORES=n and OUTPUT=file.csv)"
	@echo "  make archive              a study with its results and code as one file, an RO-Crate"
	@echo "                            (takes STUDY=my.yaml and OUTPUT=file.zip)"
	@echo "  make verify               in an unpacked archive: make its results again and compare"
	@echo "  make explorer             results/explorer.html: move the rod in a browser, without a network"
	@echo "Tests:"
	@echo "  make test                 all tests (ARGS='tests/sensor -x' for some)"
	@echo "  make known                take the whole results of tests as known; review them with git diff"
	@echo "                            (takes ARGS as make test)"
	@echo "  make test-slurm           a study on a SLURM that is set up for it (Debian, as root)"
	@echo "  make test-faults          kill runs, fill disks, damage files at random times"
	@echo "  make mutations            does make check notice broken physics? writes validation/records/physics.md"
	@echo "  make mutate               do the tests notice small faults in the code? 600 of them at random,"
	@echo "                            an hour on two cores; writes validation/records/tests.md (takes SEED=n, SAMPLE=n,"
	@echo "                            JOBS=n; SINCE=main: only in changed lines, minutes)"
	@echo "  make lint                 ruff, snakefmt, snakemake --lint, import layers, mypy"
	@echo "Validation:"
	@echo "  make survey               solve 100,000 random points in both kinds of contact"
	@echo "  make chains               push chains of links in space, compare with the planar states"
	@echo "  make trailing             last sticking states of 2,000 swung rods, by multiple shooting"
	@echo "  make proof-sample         prove 300 random onsets, far beyond the paper's grid"
	@echo "  make roundtrip            friction of 1,000 random surfaces from simulated signals, into"
	@echo "                            validation/records/roundtrip.md (20 minutes; ARGS='--seeds 50' only prints)"
	@echo "  make laboratory           recordings of an independent bench with a laboratory's mistakes;"
	@echo "                            writes validation/records/laboratory.md (ARGS='--seeds 2' only prints)"
	@echo "  make costs                what each tolerance costs in friction, into validation/records/costs.md"
	@echo "  make fuzz                 read 11,100 damaged recordings; writes validation/records/fuzz.md"
	@echo "  make published            274 numbers that others published, beside ours; writes"
	@echo "                            validation/records/published.md"
	@echo "  make explorer-agreement   2,000 random points in the page's solver and in Python; writes"
	@echo "                            validation/records/explorer_agreement.md (ARGS='--points 200' only prints)"
	@echo "  make explorer-speed       drag the clamp in the explorer's page: frames, work, time to solve"
	@echo "  make designs              the paper's rod against its limits, the best rod of each material"
	@echo "  make taper                does a tapered rod measure friction better? draws docs/taper.png"
	@echo "  make bench                states per second of this and of other methods"
	@echo "  make growth               time and memory of studies of 10^4 to 10^6 points, into"
	@echo "                            validation/records/growth.md (ARGS='--points 1e7' for ten million)"
	@echo "Upkeep:"
	@echo "  make setup                install the locked packages into .venv; the others do it too"
	@echo "  make notebooks            run the notebooks of examples/ and keep their outputs"
	@echo "  make architecture         bring docs/architecture.md in line with the imports"
	@echo "  make schema               bring docs/study_file.md, docs/tables.md, the tables of tolerances,"
	@echo "                            materials and transducers, and the study file's schema in line"
	@echo "                            with the code"
	@echo "  make sketch               draw docs/sketch.svg"
	@echo "  make docs                 these pages, the reference and the notebooks as a site, in"
	@echo "                            build/site (warnings are errors; OUTPUT=folder)"
	@echo "  make format               let ruff and snakefmt rewrite the source files"
	@echo "  make lock                 bring locks/ in line with pyproject.toml"
	@echo "                            (UPGRADE=1: and move to the newest versions)"
	@echo "  make clean                remove .venv and caches; results stay"

reproduce: $(RUN_STAMPS)
	@$(RUN)

beyond: $(RUN_STAMPS)
	@$(RUN) --configfile studies/beyond.yaml

mounted: $(RUN_STAMPS)
	@$(RUN) --configfile studies/mounted.yaml

# Asked before the installation starts, not after it.
ifneq ($(filter study,$(MAKECMDGOALS)),)
ifeq ($(STUDY),)
$(error Say which study: make study STUDY=path/to/my.yaml)
endif
ifneq ($(shell test -f "$(STUDY)" && test -r "$(STUDY)" && echo readable),readable)
$(error No such study file, or it cannot be read: $(STUDY))
endif
endif
study: $(RUN_STAMPS)
	@$(RUN) --configfile "$(STUDY)"

CHECK := workflow/check.py $(if $(STUDY),--configfile "$(STUDY)") \
    $(if $(REFERENCE),--reference "$(REFERENCE)") $(if $(OUTPUT),--output "$(OUTPUT)")

check: $(STUDY_STAMP)
	@$(PY) $(CHECK)

bless: $(STUDY_STAMP)
	@$(PY) $(CHECK) --bless

# What is proved already is not proved again.
proof: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/enclosures.py $(if $(STUDY),--configfile "$(STUDY)") \
	    $(if $(OUTPUT),--output "$(OUTPUT)") $(if $(CORES),--jobs $(CORES)) $(ARGS)

proof-sample: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/proof_sample.py $(ARGS)

archive: $(STUDY_STAMP)
	@$(PY) workflow/archive.py $(if $(STUDY),--configfile "$(STUDY)") \
	    $(if $(OUTPUT),--output "$(OUTPUT)")

verify: $(STUDY_STAMP)
	@$(PY) workflow/verify.py

setup: $(RUN_STAMPS)
	@echo "$(VENV) is ready. For the commands vibrissa and python, type: . $(VENV)/bin/activate"

# The stamp holds the folder's path: in a moved or copied folder .venv still points to the old one.
# In shell words a quote in it is spelled '\''.
HERE := '$(subst ','\'',$(CURDIR))'
ifneq ($(shell test -f $(STUDY_STAMP) && printf '%s\n' $(HERE) | cmp -s - $(STUDY_STAMP) && echo same),same)
.PHONY: $(STUDY_STAMP)
endif

# Each shell test ends in one plain line for the user instead of a Python traceback.
$(STUDY_STAMP): locks/study.lock pyproject.toml
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
	echo "Setting up $(VENV) with $$("$$python" --version): installing what a study needs," \
	    "silently for a minute ..."; \
	rm -rf $(VENV) && "$$python" -m venv $(VENV)
# setuptools first: one locked package (connection_pool) has no wheel, and pip would otherwise
# fetch some setuptools without a pin or a hash to build it.
	@awk '/^[a-z]/ { keep = /^setuptools==/ } keep' locks/study.lock > $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --require-hashes -r $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --require-hashes --no-build-isolation --use-pep517 -r locks/study.lock
# In place of an editable installation, which needs a build backend: the source is found here, and
# the command is a module.
	@$(PY) -c 'import pathlib, sysconfig; pathlib.Path(sysconfig.get_path("purelib"), "vibrissa.pth").write_text(str(pathlib.Path("src").absolute()) + "\n")'
	@printf '#!/bin/sh\nexec "$$(dirname "$$0")/python" -m vibrissa.cli "$$@"\n' > $(VENV)/bin/vibrissa
	@chmod +x $(VENV)/bin/vibrissa
	@printf '%s\n' $(HERE) > $(STUDY_STAMP)

$(VENV)/.%: locks/%.lock $(STUDY_STAMP)
	@echo "Installing the packages of locks/$*.lock, silently for a minute ..."
	@$(PIP_INSTALL) --require-hashes --no-build-isolation --use-pep517 -r locks/$*.lock
	@touch $@

# With kept bytecode: without it each worker would rewrite the assertions of all tests anew.
test: $(TEST_STAMP)
	@env -u PYTHONDONTWRITEBYTECODE $(ONE_THREAD) $(PY) -m pytest -n logical --dist worksteal -p no:benchmark $(ARGS)

# Results that differ from the known ones are written, not told as failures.
known: export KNOWN := write
known: test

# Apart from `test`, as it installs SLURM; it says so and succeeds where that is not possible.
test-slurm: $(TEST_STAMP) $(CLUSTER_STAMP)
	@$(ONE_THREAD) $(PY) -m pytest tests/slurm $(ARGS)

# A link that leads nowhere is a warning, and a warning stops the build.
docs: $(DOCS_STAMP)
	@$(ONE_THREAD) $(PY) -m sphinx -q -W --keep-going -j 2 -b html docs "$(or $(OUTPUT),build/site)"
	@echo "Open $(or $(OUTPUT),build/site)/index.html in a browser; it needs no network."

bench: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) -m pytest benchmarks/bench_states.py -q \
	    --benchmark-json=.benchmarks.json --benchmark-disable-gc >/dev/null
	@$(PY) benchmarks/table.py .benchmarks.json

survey: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/survey.py $(ARGS)

# Two minutes; fails if energies differ by more than 1e-5.
chains: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/chains.py $(ARGS)

# Five minutes; fails if a state is not found again, or displacements differ by more than 1e-11.
trailing: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/trailing.py $(ARGS)

# Not with one thread by ONE_THREAD: it is the workflow's jobs that are measured, as they are.
growth: $(STUDY_STAMP)
	@$(PY) benchmarks/growth.py $(ARGS)

designs: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/designs.py $(ARGS)

roundtrip: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/roundtrip.py \
	    $(or $(ARGS),--seeds 1000 --docs validation/records/roundtrip.md --figure docs/roundtrip.png)

laboratory: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/sensor/laboratory.py \
	    $(or $(ARGS),--docs validation/records/laboratory.md)

costs: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/sensor/costs.py \
	    --docs validation/records/costs.md --figure docs/laboratory.png

# A quarter of an hour on two cores; fails if any recording gives a traceback or silently a wrong number.
fuzz: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/fuzzing.py $(ARGS)

# Half a minute; fails if a number differs by more than its rounding without a known reason.
published: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/published.py

explorer: $(STUDY_STAMP)
	@$(PY) -m vibrissa.explorer results/explorer.html

# A minute; fails if a number differs by more than 1e-8.
explorer-agreement: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/explorer_agreement.py $(or $(ARGS),--docs)

# A minute and a half.
explorer-speed: $(TEST_STAMP)
	@$(PY) validation/explorer_speed.py $(ARGS)

notebooks: $(DOCS_STAMP)
	@$(ONE_THREAD) $(PY) examples/rerun.py $(ARGS)

architecture: $(DOCS_STAMP)
	@$(PY) docs/architecture.py

schema: $(DOCS_STAMP)
	@$(PY) docs/study_file.py
	@$(PY) docs/tables.py
	@$(PY) docs/sensor_tables.py

sketch: $(DOCS_STAMP)
	@$(PY) docs/sketch.py

taper: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/taper.py --figure docs/taper.png $(ARGS)

mutations: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) validation/mutations.py

# Each mutant is tried in a copy; the checkout is never changed.
mutate: $(TEST_STAMP)
	@$(ONE_THREAD) PYTHONPATH=validation $(PY) -m mutation $(if $(SINCE),--since "$(SINCE)",--docs) \
	    $(if $(SEED),--seed $(SEED)) $(if $(SAMPLE),--sample $(SAMPLE)) $(if $(JOBS),--jobs $(JOBS)) $(ARGS)

# Apart from `test`, as it takes minutes.
test-faults: $(TEST_STAMP)
	@$(ONE_THREAD) $(PY) -m pytest tests/faults $(ARGS)

# What checks the types of the explorer's JavaScript; npm fetches it when it is needed first.
TSC := npx --yes --package typescript@5.9.3 tsc --project src/vibrissa/explorer

lint: $(LINT_STAMP)
	$(PY) -m ruff check
	$(PY) -m ruff format --check
	$(PY) -m snakefmt --check Snakefile workflow
	$(PY) -m snakemake --lint
	$(VENV)/bin/lint-imports --no-cache --no-logo
	$(PY) -m mypy src
	@if command -v npx >/dev/null; then $(TSC); \
	    else echo "JavaScript is not checked: npx of Node.js is missing"; fi

format: $(LINT_STAMP)
	$(PY) -m ruff check --fix
	$(PY) -m ruff format
	$(PY) -m snakefmt Snakefile workflow

# Locks for Python 3.11-3.13, Linux and macOS; `fewest`: the same version on all of them. Each later
# lock has the versions of the one before, as all of them may be installed together.
COMPILE = $(PY) -m uv pip compile pyproject.toml --extra workflow --group build --quiet --universal \
    --python-version 3.11 --fork-strategy fewest --generate-hashes --no-emit-index-url --no-config \
    --custom-compile-command "make lock" $(if $(UPGRADE),--upgrade)
lock: $(LINT_STAMP)
	@$(COMPILE) --output-file locks/study.lock
	@$(COMPILE) --extra proof --group test --constraints locks/study.lock --output-file locks/test.lock
	@$(COMPILE) --extra cluster --constraints locks/study.lock --output-file locks/cluster.lock
	@$(COMPILE) --extra proof --group docs --constraints locks/test.lock --output-file locks/docs.lock
	@$(COMPILE) --extra proof --group lint --constraints locks/test.lock --output-file locks/lint.lock
	@echo "locks/ is written; put changed versions of what a study needs into environment.yml and" \
	    "workflow/envs/vibrissa.yaml too (make test tells which)."

# .snakemake stays: it remembers with which code and settings the results were made.
clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .mypy_cache .hypothesis build dist
	find src tests workflow -name __pycache__ -type d -prune -exec rm -rf {} +
	@echo "Results are kept; to drop those of one study: rm -r results/<study>"
