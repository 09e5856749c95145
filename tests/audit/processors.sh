#!/usr/bin/env bash
# Run tests and notebooks as other processors would compute them, and print the rows of a table.
#
#   PYTHON=.venv/bin/python bash tests/audit/processors.sh [LOGS] [PYTEST'S ARGUMENTS ...]
#
# OpenBLAS' and numpy's code is chosen by their own switches; what this processor can't run is left
# out, and said. In the row "noise" sin, exp and others are off by one bit at random.
set -uo pipefail
logs=${1:-build/processors}
shift || true
mkdir -p "$logs"
export PYTHONUTF8=1 OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 LP_NUM_THREADS=1 PYTHONHASHSEED=0 \
    VTK_DEFAULT_OPENGL_WINDOW=vtkEGLRenderWindow PYVISTA_JUPYTER_BACKEND=static
processor=$(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2-)
python=$("${PYTHON:-.venv/bin/python}" -c 'import platform; print(platform.python_version())')

try() { # NAME SETTING PYTEST'S ARGUMENTS ...
    local name=$1 log=$logs/$1.log said
    said=$(env "$2" "${PYTHON:-.venv/bin/python}" -m pytest -n auto --dist loadfile -q "${@:3}" 2>&1 |
        tee "$log" | grep -aoE '[0-9]+ (passed|failed|skipped|error)[^=]* in [0-9.]+s' | tail -1)
    [[ $said == *failed* || $said == *error* || -z $said ]] && said="**fails**: $said"
    echo "| $name | $(env -u OMP_NUM_THREADS nproc) cores of$processor, Python $python | $said |"
}

try 'as the processor would have it' PYTHONUTF8=1 "$@"
for blas in Prescott Nehalem Haswell Zen SkylakeX; do
    if [ $blas = SkylakeX ] && ! grep -q avx512f /proc/cpuinfo; then
        echo "| OpenBLAS for $blas | $processor | not tried: this processor has no AVX-512 |"
        continue
    fi
    try "OpenBLAS for $blas" OPENBLAS_CORETYPE=$blas "$@"
done
newer=$("${PYTHON:-.venv/bin/python}" -c 'from numpy._core import _multiarray_umath as numpy
print(*[name for name in numpy.__cpu_dispatch__ if numpy.__cpu_features__[name]], sep=",")')
try "numpy without its code for newer processors ($newer)" NPY_DISABLE_CPU_FEATURES="$newer" "$@"
try "notebooks alone, noise" PYTHONPATH="$PWD/tests/audit/noise" notebooks
