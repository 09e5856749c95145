"""Loops over plain numbers, which numba compiles where it is installed and the work is long.

A function given to `call` works on numbers, tuples and rows that it reads and writes by index. It
runs as it stands, on lists, or compiled, on arrays. Both take the same steps in the same order,
without fast-math, so that every bit of the answers is the same. The function may use only what both
compute alike: no powers, no `hypot` and no functions of the C library, whose last bits differ.
"""

import functools
import importlib
import inspect
import math
import sys
import threading
from collections import defaultdict
from types import FunctionType
from typing import ClassVar

import numpy as np

from .repeatable import cosine_of, sine_of

LONG = 2.0  # s of plain Python, beyond which the time to load the compiler is well spent
_compiling = threading.Lock()


class _Work:
    """The plain work expected of each kind so far, in s, and whether loops are compiled now."""

    compiled = False
    of_kind: ClassVar = defaultdict(float)
    other = None


def replace_plain(other):
    """Have `other` run the functions that numba doesn't compile; it is called as `call` is.

    A web page has another compiler, for one.
    """
    _Work.other = other


def expect(seconds, kind):
    """Announce loops of a `kind` that take about so many `seconds` in plain Python.

    Once all announced of a kind comes to more than `LONG`, its loops are compiled, if numba can be
    imported.
    """
    _Work.of_kind[kind] += seconds
    if _Work.of_kind[kind] > LONG and not _Work.compiled:
        _Work.compiled = _imported(sys.modules.get("numba", "not yet asked for"))


def ready(kind):
    """Return whether loops of a kind are compiled, so that a caller can prepare their arguments."""
    return _Work.compiled and _Work.of_kind[kind] > LONG


def each_block(work, count, size, kind):
    """Do `work` on blocks of rows that are independent of each other.

    Compiled loops run without Python's lock, so that blocks run on all cores, or on as many as
    NUMBA_NUM_THREADS allows numba.

    Parameters
    ----------
    work : function
        Of a slice of the rows.
    count, size : int
        Of all rows, and of those of a block.
    kind : object
        As for `expect`.

    Examples
    --------
    Where nothing is compiled all blocks are done by the caller's own thread, as a web page needs,
    which can't start another:

    >>> blocks, threads = [], set()
    >>> def note(rows):
    ...     blocks.append((rows.start, rows.stop))
    ...     threads.add(threading.current_thread())
    >>> each_block(note, 5, 2, "rows of an example")
    >>> blocks, threads == {threading.current_thread()}
    ([(0, 2), (2, 4), (4, 6)], True)
    """
    blocks = [slice(first, first + size) for first in range(0, count, size)]
    cores = min(len(blocks), sys.modules["numba"].config.NUMBA_NUM_THREADS) if ready(kind) else 1
    if cores < 2:
        for block in blocks:
            work(block)
        return
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(cores) as pool:
        for _ in pool.map(work, blocks):  # an error in a block is raised here
            pass


def loop(inlined=()):
    """Return a decorator of a loop, which lets a compiler handle several numbers at once.

    A compiled quotient by zero is then infinite or NaN, as `elementwise.ratio` makes it in plain
    Python, without a branch each time. Functions whose names are `inlined` become part of those
    that call them.
    """

    def marked(function):
        function.options = {"error_model": "numpy"}, inlined
        return function

    return marked


@functools.cache  # a failed import would be tried again at every call
def _imported(_found):
    """Return whether numba, as found among the modules loaded so far, can be imported."""
    try:
        importlib.import_module("numba")
    except Exception:  # any, by its cache, llvmlite, or a numpy too new for it
        return False
    return True


def call(function, *arguments, kind=None, arrays=None, **parts):
    """Return what a function of numbers, tuples and rows returns, compiled if loops are by now.

    Parameters
    ----------
    function : function
        It, and all functions that it calls, are of modules of this library.
    *arguments
        Its arguments. Rows are contiguous arrays of floats or ints, (n,) or (n, m), which the
        function may change.
    kind : object, optional
        The kind of loop; needed unless the caller has asked whether it is `ready`.
    arrays : dict of functions, optional
        Functions of whole arrays, which plain Python calls in the place of the loops of these
        names that `function` itself calls. They get arrays where tuples hold them.
    **parts
        Functions to be called in the place of those that have these names.
    """
    if _Work.compiled and (kind is None or ready(kind)):
        with _compiling:
            fast = _compiled(function, *parts.items())
        return _run(fast, arguments)
    if _Work.other is None and arrays is not None:
        return call_plain(_by_arrays(function, *arrays.items(), **parts), *arguments)
    return (_Work.other or call_plain)(function, *arguments, **parts)


def _run(fast, arguments):
    """Return what a compiled function returns, even if its form kept on the disk can't be used.

    That file may be cut short or another user's, or there may be no room for it. Any such error
    comes before a row is changed, and the function is then compiled for this process alone.
    """
    try:
        return fast(*arguments)
    except Exception:
        return _never_kept(fast.py_func)(*arguments)


@functools.cache
def _never_kept(copy):
    """Return a function's copy, compiled; its compiled form is neither kept nor looked for."""
    import numba

    return numba.njit(copy, **copy.made_with)


def call_plain(function, *arguments, **parts):
    """Return what `call` does, but always in plain Python, on lists."""
    if parts:
        function = _replaced(function, *parts.items())
    if not any([isinstance(one, np.ndarray) for one in arguments]):
        return function(*arguments)
    # Python reads and writes lists several times as fast as arrays.
    lists = [one.tolist() if isinstance(one, np.ndarray) else one for one in arguments]
    answer = function(*lists)
    for array, rows in zip(arguments, lists, strict=True):
        if isinstance(array, np.ndarray) and array.size:
            array[:] = rows
    return answer


def sine(x):
    """Return the sine of a float x, the same everywhere, or of an array, by numpy."""
    return sine_of(x) if isinstance(x, float) else np.sin(x)


def cosine(x):
    """Return the cosine of a float x, the same everywhere, or of an array, by numpy."""
    return cosine_of(x) if isinstance(x, float) else np.cos(x)


def root(x):
    """Return the square root of a float x or of an array."""
    return math.sqrt(x) if isinstance(x, float) else np.sqrt(x)


# What a loop of numbers calls in the place of these.
SCALARS = {"sine": sine_of, "cosine": cosine_of}


@functools.lru_cache(32)
def _replaced(function, *parts):
    """Return a copy of a function that calls `parts` in the place of functions of their names."""
    return _copied(function, dict(parts), lambda copy: copy, {})


@functools.lru_cache(32)
def _by_arrays(function, *arrays, **parts):
    """Return a copy of a function that calls `arrays` itself, and `parts` as of `_replaced`."""
    copy = _replaced(function, *parts.items())
    names = copy.__globals__ | dict(arrays)
    return FunctionType(copy.__code__, names, copy.__name__, copy.__defaults__, copy.__closure__)


@functools.cache
def _compiled(function, *parts):
    """Return the compiled form of a function and of all functions that it calls."""
    import hashlib

    import numba

    known = {root: math.sqrt}
    parts = tuple((SCALARS | dict(parts)).items())
    options, inlined = getattr(function, "options", ({}, ()))

    def made(copy):
        # Only compiled code calls it: an entry from Python would double the time to compile.
        alone = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        return numba.njit(copy, forceinline=copy.__name__ in inlined, **alone, **options)

    copy = _copied(function, dict(parts), made, known)
    # Numba finds a kept form by the function's name. So the name is made to change with the parts,
    # with the text of any module that takes part, and with numbers imported from other modules.
    modules = {inspect.getmodule(one) for one in (function, *known)}
    about = [part.__qualname__ for _, part in parts] + sorted(map(inspect.getsource, modules))
    named = [
        one.__globals__.get(name) for one in (function, *known) for name in one.__code__.co_names
    ]
    about += [repr(value) for value in named if isinstance(value, int | float | tuple)]
    options = {"nogil": True} | options
    about.append(repr(options))
    digest = hashlib.sha256("".join(about).encode()).hexdigest()
    copy.__qualname__ = f"{function.__qualname__}_{digest[:16]}"
    copy.made_with = options  # for `_never_kept`, which has only the copy
    try:
        return numba.njit(cache=True, **options)(copy)
    except Exception:  # no folder that could be written to
        return _never_kept(copy)


def _copied(function, parts, made, known):
    """Return a copy of a function that calls what is `made` of copies of its callees, or `parts`.

    What is made of each function is `known` from then on.
    """
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        called = parts.get(name, names.get(name))
        if isinstance(called, FunctionType):
            if called not in known:
                known[called] = made(_copied(called, parts, made, known))
            names[name] = known[called]
        elif name in parts:  # one that is written in C
            names[name] = called
    return FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )
