# `make` alone lists the targets. Everything runs in .venv, which is made from locks/.

SHELL := /bin/sh
VENV := .venv
PY := $(VENV)/bin/python
# Groups of packages, each installed when a target needs it. Each has a lock file, and a stamp that is
# written as the last step of its installation: an interrupted installation is redone.
STUDY_STAMP := $(VENV)/.study
TEST_STAMP := $(VENV)/.test
DOCS_STAMP := $(VENV)/.docs
LINT_STAMP := $(VENV)/.lint
CLUSTER_STAMP := $(VENV)/.cluster
# Further groups that `make setup` installs: files, test, docs, lint, cluster.
LOCKS ?=
PIP_INSTALL := $(PY) -m pip install -qq --no-input --disable-pip-version-check
# Tried in this order; name one yourself with `make PYTHON=/path/to/python3 ...`.
PYTHON := python3 python3.13 python3.12 python3.11
# Limit the cores used by a study with `make reproduce CORES=2`; the profile has the default.
CORES ?=
# Profile for this machine; for a cluster, PROFILE=workflow/profiles/slurm.
PROFILE ?= workflow/profiles/default
# Groups that a run needs: a cluster's profile also needs plugins of Snakemake.
RUN_STAMPS = $(STUDY_STAMP) $(if $(filter-out default,$(notdir $(PROFILE:/=))),$(CLUSTER_STAMP))
# Progress bars are shown on a terminal only.
RUN = $(PY) -m vibrissa.pipeline --workflow-profile "$(PROFILE)" $(if $(CORES),--cores $(CORES)) \
    $(shell test -t 2 && echo --logger rich)

# Only packages in .venv are used, not the user's other packages.
unexport PYTHONPATH
unexport PYTHONHOME
export PYTHONNOUSERSITE := 1

# One BLAS/OpenMP thread in pytest; in the workflow's jobs Snakemake itself sets these variables
# to the `threads:` of the rule.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1

.PHONY: help reproduce study check bless archive verify explorer setup test lint docs format lock clean
.DEFAULT_GOAL := help
# Each target runs its own processes on all cores, and two installations in .venv would collide.
.NOTPARALLEL:

help:
	@echo "Studies (CORES=n; on a cluster PROFILE=workflow/profiles/slurm):"
	@echo "  make reproduce            the paper's study: Figures 3 to 8, tables, report"
	@echo "  make study STUDY=my.yaml  the study in my.yaml instead of config.yaml"
	@echo "                            (further studies: studies/*.yaml)"
	@echo "  make check                compare the results with the reference tables"
	@echo "  make bless                update the reference tables; review with git diff"
	@echo "                            (check and bless take STUDY=my.yaml, and"
	@echo "                            REFERENCE=folder with reference tables or, in check,"
	@echo "                            other results; check writes check.md, check.json"
	@echo "                            and new tables to OUTPUT=folder)"
	@echo "  make archive              put a study, its results and code into one RO-Crate"
	@echo "                            (takes STUDY=my.yaml and OUTPUT=file.zip)"
	@echo "  make verify               in an unpacked archive: reproduce and compare"
	@echo "  make explorer             make results/explorer.html: move the rod by hand"
	@echo "Development:"
	@echo "  make setup                install the locked packages into .venv, as other"
	@echo "                            targets do if needed (the packages of these, too:"
	@echo "                            LOCKS='files test docs lint cluster')"
	@echo "  make test                 run the tests (pytest's options: ARGS='-x')"
	@echo "  make lint                 ruff, snakefmt, snakemake --lint, layers, mypy"
	@echo "  make docs                 build the documentation as a site, in build/site"
	@echo "                            (warnings are errors; OUTPUT=folder)"
	@echo "  make format               let ruff and snakefmt rewrite the source files"
	@echo "  make lock                 bring locks/ in line with pyproject.toml"
	@echo "                            (UPGRADE=1: with the newest versions)"
	@echo "  make clean                remove .venv and caches; results stay"
	@echo "Long checks, after make setup LOCKS=test:"
	@echo "  .venv/bin/python -m validation --list"

reproduce: $(RUN_STAMPS)
	@$(RUN)

# Checked before the installation starts. Snakemake would ignore a missing profile.
ifneq ($(shell test -f "$(PROFILE)/config.yaml" && echo there),there)
$(error No such profile: $(PROFILE))
endif
ifneq ($(filter study,$(MAKECMDGOALS)),)
ifeq ($(STUDY),)
$(error STUDY is missing: make study STUDY=path/to/my.yaml)
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

archive: $(STUDY_STAMP)
	@$(PY) workflow/archive.py $(if $(STUDY),--configfile "$(STUDY)") \
	    $(if $(OUTPUT),--output "$(OUTPUT)")

verify: $(STUDY_STAMP)
	@$(PY) workflow/verify.py

setup: $(RUN_STAMPS) $(LOCKS:%=$(VENV)/.%)
	@echo "$(VENV) is ready. For the commands vibrissa and python, type: . $(VENV)/bin/activate"

# The stamp holds the folder's path: in a moved or copied folder .venv still points to the old one.
# A quote in the path is written '\'' for the shell.
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
	echo "Setting up $(VENV) with $$("$$python" --version): installing the" \
	    "$$(grep -c '^[a-z]' locks/study.lock) packages of locks/study.lock, one to two minutes ..."; \
	rm -rf $(VENV) && "$$python" -m venv $(VENV)
# setuptools first: one locked package (connection_pool) has no wheel, and pip would otherwise
# fetch some setuptools without a pin or a hash to build it.
	@awk '/^[a-z]/ { keep = /^setuptools==/ } keep' locks/study.lock > $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --require-hashes -r $(VENV)/setuptools.lock
	@$(PIP_INSTALL) --no-deps --require-hashes --no-build-isolation --use-pep517 -r locks/study.lock
# Instead of an editable installation, which needs a build backend: a .pth file points to the source,
# and a script runs the module of the command.
	@$(PY) -c 'import pathlib, sysconfig; pathlib.Path(sysconfig.get_path("purelib"), "vibrissa.pth").write_text(str(pathlib.Path("src").absolute()) + "\n")'
	@printf '#!/bin/sh\nexec "$$(dirname "$$0")/python" -m vibrissa.cli "$$@"\n' > $(VENV)/bin/vibrissa
	@chmod +x $(VENV)/bin/vibrissa
	@printf '%s\n' $(HERE) > $(STUDY_STAMP)

# A lock has all packages. Without --no-deps pip rejects one that is needed with an extra, such as
# coverage[toml], as soon as there is a newer version of it.
$(VENV)/.%: locks/%.lock $(STUDY_STAMP)
	@echo "Installing the packages of locks/$*.lock, silently for a minute ..."
	@$(PIP_INSTALL) --no-deps --require-hashes --no-build-isolation --use-pep517 -r locks/$*.lock
	@touch $@

# Bytecode is kept: otherwise each worker would rewrite the assertions of all tests again.
test: $(TEST_STAMP)
	@env -u PYTHONDONTWRITEBYTECODE $(ONE_THREAD) $(PY) -m pytest -m "not nightly" -n logical \
	    --dist worksteal -p no:benchmark $(ARGS)

# A broken link is a warning, and a warning stops the build. -E reads all pages again: otherwise the
# search index lacks the pages that have not changed.
docs: $(DOCS_STAMP)
	@$(ONE_THREAD) $(PY) -m sphinx -q -W --keep-going -E -j 2 -b html docs "$(or $(OUTPUT),build/site)"
	@echo "Open $(or $(OUTPUT),build/site)/index.html in a browser; it needs no network."

explorer: $(STUDY_STAMP)
	@$(PY) -m vibrissa.explorer results/explorer.html

# Type checker of the explorer's JavaScript; npx fetches it at its first use.
TSC := npx --yes --package typescript@5.9.3 tsc --project src/vibrissa/explorer

lint: $(LINT_STAMP)
	$(PY) -m ruff check
	$(PY) -m ruff format --check
	$(PY) -m snakefmt --check Snakefile workflow
	$(PY) -m snakemake --lint
	$(VENV)/bin/lint-imports --no-cache --no-logo
	$(PY) -m mypy
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
	@$(COMPILE) --group test --extra files --constraints locks/study.lock --output-file locks/test.lock
	@$(COMPILE) --extra files --extra profilometer --constraints locks/test.lock \
	    --output-file locks/files.lock
	@$(COMPILE) --extra cluster --constraints locks/study.lock --output-file locks/cluster.lock
	@$(COMPILE) --group docs --constraints locks/test.lock --output-file locks/docs.lock
	@$(COMPILE) --group lint --constraints locks/test.lock --output-file locks/lint.lock
	@echo "locks/ is written; put changed versions of what a study needs into environment.yml and" \
	    "workflow/envs/vibrissa.yaml too (make test shows which)."

clean:
	rm -rf $(VENV) .pytest_cache .ruff_cache .mypy_cache .hypothesis build dist
	find src tests workflow -name __pycache__ -type d -prune -exec rm -rf {} +
	@echo "Results are kept; to drop those of one study: rm -r results/<study>"
