# Targets for people: setup demo test lint test-slow bench worlds docs.
# For maintainers: frozen, lock, advisories, catalogues, paper-tables, tutorial, avanodes, real-data, coverage, trust, mutation.
VENV := .venv
BENCH := .bench-venv
AVAFRAME := .avaframe-venv
PYTHON := $(VENV)/bin/python
PIP_INSTALL = -m pip install -qq --disable-pip-version-check

# The first of these that is Python 3.11 or later and can make a virtual environment.
CANDIDATES := python3 python3.13 python3.12 python3.11 python
define find_python
python=; for name in $(CANDIDATES); do \
  if "$$name" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))' \
    >/dev/null 2>&1; then python="$$name"; break; fi; \
done; \
if [ -z "$$python" ]; then \
  echo "No Python 3.11 or later with its venv module was found (tried: $(CANDIDATES))." >&2; \
  echo "Install one, on Debian: apt-get install python3 python3-venv" >&2; exit 1; \
fi
endef

.PHONY: setup developer avaframe qgis-plugin demo test lint test-slow bench worlds frozen docs paper-tables tutorial avanodes real-data coverage trust mutation catalogues lock advisories

# What only developers need is installed when a target of theirs asks for it.
setup: $(VENV)/.installed
developer: $(VENV)/.developer

# AvaFrame needs an older numpy: it has an environment of its own, which `simulate` finds here.
avaframe: requirements-avaframe.lock
	@set -e; $(find_python); "$$python" -m venv --clear $(AVAFRAME); \
	$(AVAFRAME)/bin/python $(PIP_INSTALL) --require-hashes --no-deps -r $<; \
	echo "AvaFrame is in $(AVAFRAME)"

# For Plugins > Install from ZIP.
qgis-plugin:
	@mkdir -p dist && rm -rf dist/avahazard_qgis.zip qgis/avahazard_qgis/__pycache__
	@set -e; $(find_python); cp LICENSE qgis/avahazard_qgis/LICENSE; \
	"$$python" -c 'import shutil; shutil.make_archive("dist/avahazard_qgis", "zip", "qgis", "avahazard_qgis")'; \
	rm qgis/avahazard_qgis/LICENSE; echo "dist/avahazard_qgis.zip"

demo: setup
	$(VENV)/bin/avahazard demo

# Work goes by whole files, in the order of tests/order.py; what both workers need is made and
# compiled once (tests/once.py). Bytecode is kept: the tests start many processes.
test: developer
	PYTHONDONTWRITEBYTECODE= $(PYTHON) -m pytest -m "not slow" -n 2 --dist loadfile --no-loadscope-reorder --durations 10

lint: developer
	$(PYTHON) -m ruff check .
	$(PYTHON) -m ruff format --check .
	$(PYTHON) -m mypy
	$(VENV)/bin/lint-imports
	$(PYTHON) benchmarks/advisories.py

test-slow: developer
	$(PYTHON) -m pytest -m slow --durations 10

bench: $(BENCH)/.installed
	$(BENCH)/bin/python -m benchmarks.run

# Goes on from the results that are there; hours long.
worlds: developer
	$(PYTHON) benchmarks/worlds.py beyond --seeds $(or $(SEEDS),5000-5019) -o benchmarks/worlds.jsonl
	$(PYTHON) benchmarks/worlds.py table benchmarks/worlds.jsonl --page docs/worlds.md

frozen: developer
	$(PYTHON) benchmarks/frozen.py

docs: developer
	NO_MKDOCS_2_WARNING=1 $(PYTHON) -m mkdocs build --strict --quiet
	@echo "Open site/index.html"

# New sentences of the report go into its catalogues, which people translate.
catalogues: developer
	$(PYTHON) docs/_tools/catalogues.py

paper-tables: developer
	$(PYTHON) -m benchmarks.paper_tables

# Runs the tutorials' own commands; writes what they print, and their pictures.
tutorial: developer
	$(PYTHON) docs/_tools/tutorials.py

coverage: developer
	$(PYTHON) -m benchmarks.coverage $(ARGS)

# Kills, power cuts, bad disks, many users, upgrades, bad input: hours long.
trust: developer
	$(PYTHON) -m benchmarks.trust

# Mutation testing of what computes: MUTANTS of them, drawn by SEED.
mutation: $(BENCH)/.installed
	$(BENCH)/bin/python -m benchmarks.mutation --mutants $(or $(MUTANTS),60) --seed $(or $(SEED),1)

avanodes: developer
	$(PYTHON) -m benchmarks.avanodes

real-data: developer
	$(PYTHON) -m benchmarks.real_data

# $(1): environment, $(2): lock. The locks are whole, so nothing is resolved: pip 23 would take a newer
# release for a package asked for with an extra (coverage[toml]) and refuse it as not pinned. The
# package comes last, and `pip check` holds that they were whole.
define install
@set -e; \
if ! $(1)/bin/python -c 'import pip' >/dev/null 2>&1; then \
  $(find_python); \
  echo "Making $(1) with $$("$$python" --version)"; \
  "$$python" -m venv --clear $(1); \
fi; \
echo "Installing $(2) into $(1)"; \
$(1)/bin/python $(PIP_INSTALL) --require-hashes --no-deps -r $(2); \
$(1)/bin/python $(PIP_INSTALL) --no-deps --no-build-isolation --editable .; \
$(1)/bin/python -m pip check; \
touch $@
endef

$(VENV)/.installed: requirements.lock pyproject.toml
	$(call install,$(VENV),requirements.lock)

$(VENV)/.developer: requirements-dev.lock $(VENV)/.installed
	$(call install,$(VENV),requirements-dev.lock)

# The rivals that we measure against stay out of the users' environment.
$(BENCH)/.installed: requirements-bench.lock pyproject.toml
	$(call install,$(BENCH),requirements-bench.lock)

# Needs uv on the PATH. Versions already locked stay unless pyproject.toml rules them out. What users
# have is left out of the developers' lock, which is installed on top of theirs.
COMPILE := uv pip compile --quiet --universal --python-version 3.11 --generate-hashes \
  --no-emit-find-links --no-header
lock:
	$(COMPILE) --group build --extra gis --extra cluster \
	  --output-file requirements.lock pyproject.toml
	$(COMPILE) --extra dev --extra docs --constraint requirements.lock \
	  $$(sed -n '/sys_platform/!s/^\([a-z0-9._-]*\)==.*/--no-emit-package \1/p' requirements.lock) \
	  --output-file requirements-dev.lock pyproject.toml
	$(COMPILE) --group build --extra dev \
	  --constraint requirements.lock --constraint requirements-dev.lock \
	  --output-file requirements-bench.lock pyproject.toml benchmarks/requirements.in
	printf 'avaframe==2.1.*\nnumpy<2\n' | $(COMPILE) --output-file requirements-avaframe.lock -

# What was locked anew is held against the advisories of a clone of github.com/pypa/advisory-database.
advisories: developer
	@test -n "$(DATABASE)" || { echo "Say where the clone is: make advisories DATABASE=FOLDER" >&2; exit 1; }
	$(PYTHON) benchmarks/advisories.py --database "$(DATABASE)"
