#!/usr/bin/env bash
# The tests of the library's core with the oldest numpy and scipy that pyproject.toml admits, in an
# environment of their own: build/oldest.
set -euo pipefail
cd "$(dirname "$0")/.."
oldest=$(grep -oE '"(numpy|scipy)>=[0-9.]+"' pyproject.toml | tr -d '"' | sed 's/>=\(.*\)/==\1.0/')
helpers=$(grep -oE '^(pytest|pytest-xdist|hypothesis|mpmath|sympy)==[^ ]+' environment.txt)
.venv/bin/uv venv --quiet --clear --python .venv/bin/python build/oldest
.venv/bin/uv pip install --quiet --python build/oldest/bin/python $oldest $helpers
build/oldest/bin/python -c 'import numpy, scipy; print("numpy", numpy.__version__, "scipy", scipy.__version__)'
OPENBLAS_NUM_THREADS=1 build/oldest/bin/python -m pytest -o addopts= -n auto --dist loadfile -q \
    $(.venv/bin/python -m tests.audit.core)
