"""What a text reaches: names followed through packages, meaning without comments."""

import subprocess
import sys

import pytest

from report.reach import meaning, needed, steps
from report.sources import ROOT

LIBRARY = {
    "a/__init__.py": '"""A."""\nfrom .one import f\nfrom .two import g as h\n__all__ = ["f", "h"]',
    "a/one.py": "from ..base import x\ndef f(): pass",
    "a/two.py": "def g():\n    from ..b import own",
    "b/__init__.py": "own = 1",
    "base.py": "x = 1",
    "lonely.py": "",
}


@pytest.fixture
def root(tmp_path):
    for name, text in LIBRARY.items():
        file = tmp_path / "tunneller_lib" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    (tmp_path / "tunneller_lib" / "__init__.py").write_text('"""The library."""')
    return tmp_path


@pytest.mark.parametrize(
    ("text", "files"),
    [
        ("from tunneller_lib.a import f", "a/one base"),
        ("from tunneller_lib.a import h", "a/two b/__init__"),
        ("from tunneller_lib.a import f, h as k", "a/one base a/two b/__init__"),
        ("from tunneller_lib.a import *", "a/one base a/two b/__init__"),
        ("import tunneller_lib.a", "a/one base a/two b/__init__"),
        ("from tunneller_lib import a", "a/one base a/two b/__init__"),
        ("from tunneller_lib.a.two import g", "a/two b/__init__"),
        ("from tunneller_lib.a import two", "a/two b/__init__"),
        ("import tunneller_lib.a.one as one", "a/one base"),
        ("if 1:\n    from tunneller_lib.b import own", "b/__init__"),
        ("import numpy, scipy.optimize\nfrom json import load", ""),
        ("from tunneller_lib.none import x", ""),
    ],
)
def test_imports_are_followed_by_name(root, text, files):
    found = {str(f.relative_to(root / "tunneller_lib"))[:-3] for f in needed(text, root)}
    assert found == set(files.split())


def test_steps_count_imports_on_the_shortest_way(root):
    (root / "tunneller_lib" / "far.py").write_text(
        "from .base import x\nfrom .a import f, h\ny = x"
    )
    found = steps("from tunneller_lib.far import y\nfrom tunneller_lib.a import f", root)
    names = {str(f.relative_to(root / "tunneller_lib"))[:-3]: away for f, away in found.items()}
    assert names == {"far": 1, "a/one": 1, "base": 2, "a/two": 2, "b/__init__": 3}


def test_module_that_reads_its_package_s_data_needs_them(root):
    (root / "tunneller_lib" / "a" / "text.st").write_text("x := 1;")
    assert len(needed("from tunneller_lib.a import f", root)) == 2
    text = "from importlib.resources import files\ndef g(): return files(__package__)"
    (root / "tunneller_lib" / "a" / "reader.py").write_text(text)
    found = steps("from tunneller_lib.a.reader import g", root)
    assert {file.name: away for file, away in found.items()} == {"reader.py": 1, "text.st": 1}


def test_broken_module_is_named(root):
    (root / "tunneller_lib" / "base.py").write_text("x = (")
    with pytest.raises(SystemExit, match=r"base\.py, line 1: '\(' was never closed\.$"):
        needed("from tunneller_lib.base import x", root)


SOURCE = 'def f(x):\n    """Double."""\n    return 2 * x'


@pytest.mark.parametrize(
    ("other", "same"),
    [
        ("def f(x):  # twice\n\n    return (2 * x)", True),
        ('"""M."""\n' + SOURCE.replace("Double", "Twice"), True),
        (SOURCE.replace("2", "3"), False),
        (SOURCE + "\n'text'", False),
        (SOURCE + "\nprint(f.__doc__)", False),
    ],
)
def test_meaning_is_that_of_the_code(other, same):
    assert (meaning(SOURCE) == meaning(other)) is same


def test_what_is_needed_is_what_python_imports():
    text = "from tunneller_lib.motion.oil import Compressible"
    code = f"{text}\nimport sys\nprint(*[getattr(m, '__file__', '') for m in sys.modules.values()])"
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    found = {str(file) for file in needed(text, ROOT)}
    assert found <= set(run.stdout.split()) and len(found) > 3
