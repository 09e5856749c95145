# Thin front: each target sets up .venv (report/environment.py) and calls a Python program there.

PYTHON ?= python3
BIN := .venv/bin

# Any locale will do: files are UTF-8. Compiled modules are kept, whatever the caller's own taste:
# without them each of some hundred processes spends two seconds on compiling.
export PYTHONUTF8 := 1
export PYTHONDONTWRITEBYTECODE :=

# Memory that big arrays give back is kept for the next ones: else up to a third of the time of big
# sweeps goes to pages that the system clears (glibc; elsewhere these mean nothing).
export MALLOC_MMAP_THRESHOLD_ := 4000000000
export MALLOC_TRIM_THRESHOLD_ := 4000000000

# One thread each, so that last digits repeat, and none waits where the browser wants to draw.
ALONE := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1

# Runs without a screen: pictures repeat, too, because Mesa draws them where it is installed, and no
# graphics card's own library.
MESA := $(wildcard /usr/share/glvnd/egl_vendor.d/50_mesa.json)
HEADLESS := $(ALONE) LP_NUM_THREADS=1 PYTHONHASHSEED=0 \
	$(if $(MESA),__EGL_VENDOR_LIBRARY_FILENAMES=$(MESA)) \
	VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow PYVISTA_JUPYTER_BACKEND=static

.DEFAULT_GOAL := help
.PHONY: help environment report stale site live dist test long check lab browser sliders atlas bench plc mutants words format lock clean

help: ## show this list
	@sed -n 's/^\([a-z]*\): [^#]*## \(.*\)/\1\t\2/p' $(MAKEFILE_LIST) | expand -t 10

environment:
	@$(PYTHON) -m report.environment

report: environment ## run the notebooks that changed, then make report/report.pdf and what lies beside it
	@$(HEADLESS) $(BIN)/python -m report.build

stale: environment ## say which notebooks `make report` would run, and why
	@$(BIN)/python -m report.build stale

site: report ## the notebooks and the report as web pages, build/site/index.html
	@$(BIN)/python -m report.site

live: report ## those pages with sliders that move without Python, build/live/index.html (fetches 39 MB of Pyodide once, or else open-webui's wheel with it, 106 MB)
	@$(BIN)/python -m report.live

dist: live ## the documents, the wheel and those pages in one archive for any static host, build/dist/
	@$(BIN)/python -m report.dist

# A worker takes a file at a time, in the order of testpaths: notebooks, which take longest, first,
# and doctests, the shortest, last, so that none waits long for another at the end. A worker that
# dies ends the run with the test's name: a new one would die of the same test, and so on.
test: environment ## run every test, doctest and notebook, and the linter, or only TESTS=FILES
	@$(BIN)/ruff check
	@$(HEADLESS) $(BIN)/python -m pytest -n auto --max-worker-restart=0 \
		--dist loadfile --no-loadscope-reorder $(TESTS)

long: environment ## run tests that have a longer form in it, for tests/audit/long.md (a quarter of an hour), or only TESTS=FILES
	@$(HEADLESS) $(BIN)/python -m tests.audit.long $(TESTS)

check: environment ## test what the working tree's changes can reach
	@$(HEADLESS) PATH="$(BIN):$$PATH" $(BIN)/python -m report.tests.check $(SINCE)

# Scenes come through JupyterLab's own port, so that one is enough from afar; JupyterHub puts its
# prefix before this.
lab: environment ## open JupyterLab on the index of the notebooks
	@$(ALONE) PYVISTA_TRAME_SERVER_PROXY_PREFIX=/proxy/ $(BIN)/jupyter lab $(if $(filter 0,$(shell id -u)),--allow-root) \
		--LabApp.default_url=/lab/tree/notebooks/00_index.ipynb

browser: site live ## try pages and notebooks in headless Chromium and Firefox, where they are
	@$(BIN)/python -m pytest tests/browser -s

sliders: environment ## time every slider in JupyterLab, for tests/audit/sliders.md, or those of CHAPTERS="43_better ..."
	@PYTHONPATH=$(CURDIR) $(BIN)/python tests/browser/sliders.py $(CHAPTERS)

atlas: environment ## sweep tori and pairs of positions anew, for notebooks/atlas.csv
	@$(HEADLESS) $(BIN)/python -m exhibits.sweep

# The peers' own sources warn, and one brings a plugin that this pytest refuses.
bench: ## time the library against others, in an environment of its own
	@$(PYTHON) -m report.environment bench
	@$(HEADLESS) build/bench/bin/python -m pytest -p no:dash -o filterwarnings=default \
		tests/bench --benchmark-only

plc: environment ## run the exported configuration, compiled by iec2c, and have its XML read, for tests/audit/plc.md
	@$(ALONE) $(BIN)/python -m tests.audit.plc

mutants: environment ## plant faults in the library and see that the tests notice (hours)
	@$(HEADLESS) $(BIN)/python tests/audit/mutants.py

words: environment ## plant faults in the words and see that the tests notice (half an hour)
	@$(HEADLESS) $(BIN)/python -m tests.audit.text_faults

format: environment ## put the sources into the common form
	@$(BIN)/ruff check --fix-only --quiet
	@$(BIN)/ruff format --quiet

lock: environment ## pin the newest versions of everything into environment.txt
	@$(BIN)/uv pip compile pyproject.toml --group study --universal --python-version 3.11.2 \
		--fork-strategy fewest --generate-hashes --upgrade --quiet \
		--custom-compile-command "make lock" \
		--output-file environment.txt

clean: ## remove the environment and everything temporary
	@$(PYTHON) -m report.lock "make clean" \
		rm -rf .venv build *.egg-info .pytest_cache .ruff_cache .hypothesis .benchmarks
	@find . -name __pycache__ -prune -exec rm -r {} +
