#!/usr/bin/env bash
# Part of the tests on an emulated ARM64 machine, some thirty times slower than a real one: parts of
# the library that take at most a minute natively, and two notebooks without scenes.
set -euo pipefail
tests="test_arguments_and_exact test_cone test_cone_chord test_machine test_plant
test_section test_torus test_volume"
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 PYTHONHASHSEED=0 PYVISTA_JUPYTER_BACKEND=static
.venv/bin/python -m pytest -n 2 --dist loadfile -q \
    --nbval-cell-timeout=1200 --nbval-kernel-startup-timeout=1200 \
    $(printf 'tests/%s.py ' $tests) notebooks/03_tunnel.ipynb notebooks/06_tangent_spheres.ipynb
