"""Pages that run: what is fetched, what is cut out of notebooks, what the pages hold."""

import ast
import base64
import hashlib
import io
import json
import re
import zipfile

import nbformat
import numpy as np
import PIL.Image
import pytest

from report.live import planner, runtime
from report.live.build import LivePages
from report.live.program import programs
from report.site import build as pages
from report.site.chapter import page_name
from report.site.links import faults
from report.sources import ROOT, cells, notebooks
from tunneller_lib.__main__ import main
from tunneller_lib.paths import geodesic_inverse
from tunneller_lib.reporting import preview
from tunneller_lib.surfaces import Torus

READS = ["report/*", "figures/*", "notebooks/*", "tunneller_lib/*"]

EVERY = [(n, k) for n in notebooks() for k in range(len(programs(n)))]


@pytest.fixture
def listed(monkeypatch):
    """Return the content of the one file that is on the list."""
    content = b"a wheel"
    about = {"name": "a.whl", "size": 7, "sha256": hashlib.sha256(content).hexdigest()}
    monkeypatch.setattr(runtime, "read_list", lambda: {"file": [about]})
    return content


def source(name, content):
    """Return a source that gives a content, or fails, and keeps count."""

    def give(file):
        give.asked.append(file)
        if isinstance(content, Exception):
            raise content
        return content

    give.asked = []
    give.__qualname__ = name
    return give


def test_provide_goes_from_source_to_source_and_keeps_what_it_got(tmp_path, listed):
    away, other = source("away", OSError("no such host")), source("other", b"a wheeL")
    right, last = source("right", listed), source("last", listed)
    assert runtime.provide(tmp_path, [away, other, right, last]) == {"a.whl": listed}
    assert [len(s.asked) for s in (away, other, right, last)] == [1, 1, 1, 0]
    assert runtime.provide(tmp_path, []) == {"a.whl": listed}


@pytest.mark.parametrize("content", [b"a wheeL", b"a whee", b"a wheel "])
def test_provide_refuses_another_content(tmp_path, listed, content):
    with pytest.raises(LookupError, match=r"a.whl: no source gave it. .*refused"):
        runtime.provide(tmp_path, [source("other", content)])
    assert list(tmp_path.iterdir()) == []


def test_provide_fetches_anew_what_was_damaged(tmp_path, listed):
    (tmp_path / "a.whl").write_bytes(b"damaged")
    assert runtime.provide(tmp_path, [source("right", listed)])["a.whl"] == listed
    assert (tmp_path / "a.whl").read_bytes() == listed


def test_release_that_does_not_answer_is_asked_once(monkeypatch):
    asked = []
    monkeypatch.setattr(runtime, "urlopen", lambda url, timeout: asked.append(url) or no_host())
    release = runtime.Release("https://a.org/full/")
    for _ in range(2):
        with pytest.raises(OSError, match="no host"):
            release("a.whl")
    assert asked == ["https://a.org/full/a.whl"]


def no_host():
    raise OSError("no host")


def test_list_names_digests_of_one_version():
    listed = runtime.read_list()
    assert listed["pyodide"] in listed["release"]
    assert len({about["name"] for about in listed["file"]}) == len(listed["file"])
    assert all(re.fullmatch("[0-9a-f]{64}", about["sha256"]) for about in listed["file"])


def kept(folder, *code):
    """Return the lines of the program of the last call of sliders in cells, without that."""
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in code])
    path = folder / "98_made.ipynb"
    nbformat.write(book, path)
    lines = programs(path)[-1].source.strip().split("\n")[:-1]
    return [line for line in lines if line]


def test_program_keeps_what_the_drawing_needs_alone(tmp_path):
    first = "import numpy as np, csv\nfrom math import pi, tau\na = pi\nb = np.ones(9)"
    second = "print(b)\ndraw = lambda x: a * x"
    assert kept(tmp_path, first, second, "sliders(draw, x=(0, 1, 0))") == [
        "from math import pi", "a = pi", "draw = lambda x: a * x"
    ]  # fmt: skip


def test_program_keeps_what_a_function_reads_that_is_bound_after_it(tmp_path):
    body = ["def draw(x):", "    return look"]
    look = ["look = {}", "look |= {'a': 1}", "look['b'] = 2"]
    look += ["for k in (1, 2):", "    look.update(c=k)"]
    assert kept(tmp_path, "\n".join(body), "\n".join(look), "sliders(draw)") == body + look


def test_program_leaves_out_what_is_bound_anew_and_names_of_inner_scopes(tmp_path):
    before = "alt = slow()\nrows = [alt for a in range(3)]\na = 1", "c = [a for a in range(3)]"
    body = ["alt = 'b'", "def draw(x, rows=2):", "    c = alt", "    return c"]
    assert kept(tmp_path, *before, "\n".join(body), "first = sliders(draw, alt=alt)") == body


def test_program_keeps_an_older_value_that_a_function_was_called_with(tmp_path):
    body = ["a = 1", "def made():", "    return a", "b = made()", "a = 2"]
    assert kept(tmp_path, "\n".join(body), "sliders(lambda x: (a, b))") == body


def test_programs_are_as_many_as_calls_of_sliders():
    written = [text for n in notebooks() for kind, text in cells(n) if kind == "code"]
    assert len(EVERY) == sum(text.count("sliders(") for text in written) > 40


@pytest.mark.parametrize(("path", "number"), EVERY, ids=lambda value: getattr(value, "stem", value))
def test_program_draws_what_the_notebook_stored(path, number, monkeypatch):
    program = programs(path)[number]
    if program.draws_scene:
        assert "scene" in program.source
        return
    monkeypatch.chdir(ROOT / "notebooks")
    monkeypatch.setenv("PYVISTA_JUPYTER_BACKEND", "static")
    shown = []
    monkeypatch.setattr("tunneller_lib.reporting.interactive.display", shown.append)
    *before, call = ast.parse(program.source).body
    names = {}
    exec(compile(ast.Module(before, []), "before", "exec"), names)
    drawn = eval(compile(ast.Expression(call.value), "call", "eval"), names)
    code = [c for c in nbformat.read(path, as_version=4).cells if c.cell_type == "code"]
    stored = [o.data["image/png"] for o in code[program.cell - 1].outputs if "image/png" in o.data]
    if not stored:  # the sliders only, for those who move them
        assert path.stem == "43_better" and len(drawn.axes) == 1
        return
    picture = shown[-1] if shown else preview(drawn)
    here, there = pixels(picture.data), pixels(base64.b64decode(stored[-1]))
    assert here.shape == there.shape and np.abs(here - there).mean() < 1


def pixels(png):
    return np.asarray(PIL.Image.open(io.BytesIO(png)).convert("RGB")).astype(float)


REFERENCE = (ROOT / "notebooks" / "reference.toml").read_text()


def quick():
    """Return the reference job, soon done: few rays, axes without oil, no ground."""
    text = re.sub(r"power = 3e3.*?(?=\n# \[hydraulics\])", "", REFERENCE, flags=re.S)
    soon = {"step = 5e-3": "step = 1e-2", "rest = 1.0": "rest = 0.2", '"T3"': '"T0"',
            "along = 200": "along = 40", "around = 360": "around = 60"}  # fmt: skip
    for old, new in soon.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    return text


@pytest.fixture
def planned(tmp_path, monkeypatch):
    monkeypatch.setattr(planner, "HERE", tmp_path / "planned")
    return tmp_path


def test_planner_prints_and_writes_what_the_command_does(planned, capsys):
    code, printed, files = planner.cut(quick(), "mine.toml")
    (planned / "mine.toml").write_text(quick())
    assert code == main(["cut", str(planned / "mine.toml"), "--out", str(planned / "out")]) == 0
    told = capsys.readouterr().out
    assert printed == told.partition(f"{planned}/out")[0].strip("\n") and "each alone" in printed
    for path in (planned / "out").iterdir():
        if path.suffix != ".png":
            assert files[path.name] == path.read_bytes(), path.name
    for name in ("plan.png", "wall.png"):
        assert pixels(files[name]).std() > 10


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ("R = 0.80", "R = 800", 2, "wrong: [machine] R: must be at most 50 m; got 800."),
        ("gain = 10 ", "gain = 90 ", 1, "refused: [controller] gain"),
        ("[section]", "[sectoin]", 2, "wrong: [sectoin]: is no table of a job"),
    ],
)
def test_planner_refuses_as_the_command_does(planned, capsys, old, new, code, said):
    assert REFERENCE.count(old) == 1
    assert planner.cut(REFERENCE.replace(old, new), "a.toml") == (code, "", {})
    assert said in capsys.readouterr().err and list((planned / "planned").iterdir()) == []


def test_calculator_returns_all_digits_and_way_and_end_agree():
    start = {"r": 0.08, "R": 0.8, "theta": 0.0, "phi": -30.0}
    way = planner.geodesic_of(start | {"theta2": 60.0, "phi2": 35.0})
    exact = geodesic_inverse(Torus(0.08, 0.8), (0, np.radians(-30)), np.radians([60, 35]))
    assert float(way["length / m"]) == exact.length and way["certificate"] == "only"
    known = {"azimuth": float(way["azimuth at the start / deg"]), "length": exact.length}
    end = planner.geodesic_of(start | known)
    assert float(end["theta at the end / deg"]) == pytest.approx(60, rel=1e-12)
    assert float(end["phi at the end / deg"]) == pytest.approx(35, rel=1e-12)


SOME = [n for n in notebooks() if n.stem[:2] in ("00", "02", "12", "56")]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return pages with a small thing in the runtime's place."""
    wheel = io.BytesIO()
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("some_thing-1.0.dist-info/licenses/LICENSE", "as you like")
    folder = tmp_path_factory.mktemp("live")
    files = {"pyodide.js": b"// 0", "some_thing-1.0-py3-none-any.whl": wheel.getvalue()}
    pages.build(folder, SOME, LivePages(SOME, files))
    return folder


def page(site, number):
    [chosen] = [n for n in SOME if n.stem.startswith(number)]
    return (site / page_name(chosen)).read_text()


def wrapped(path):
    """Return the file that a script keeps for the page."""
    text = re.fullmatch(r'\(window.runtime \?\?= {}\)\["(.*)"\] = "(.*)";\n', path.read_text())
    assert f"{text[1]}.js" == path.name
    return base64.b64decode(text[2])


def test_pages_that_run_have_no_faults(site):
    assert faults(site) == []


def test_pages_that_run_offer_it_below_each_drawing_with_sliders(site):
    for number, count in (("02", 1), ("12", 1), ("56", 0)):
        names = re.findall(r'data-program="(.*?)"><button', page(site, number))
        assert len(names) == count
        for name in names:
            text = (site / "live" / "programs" / f"{name}.js").read_text()
            assert "sliders(" in json.loads(text.partition(" = ")[2].rstrip(";\n"))
    assert "need VTK" in page(site, "56") and "These pages run" in page(site, "00")


def test_pages_that_run_let_the_worker_import_what_they_hand_over(site):
    for path in site.rglob("*.html"):
        [policy] = re.findall(r'Content-Security-Policy" content="([^"]*)"', path.read_text())
        assert "script-src &#39;self&#39; file: &#39;wasm-unsafe-eval&#39; blob:;" in policy
        assert "unsafe-eval&#39; &#39;unsafe" not in policy and "connect-src" not in policy


def test_pages_that_run_hold_the_runtime_the_library_and_their_licences(site):
    parts = json.loads((site / "live/parts.js").read_text().partition(" = ")[2].rstrip(";\n"))
    for name, size in parts["parts"]:
        assert len(wrapped(site / "live" / f"{name}.js")) == size
    packages = json.loads(wrapped(site / "live/lock.js"))["packages"]
    assert list(packages) == ["some-thing"] and packages["some-thing"]["version"] == "1.0"
    with zipfile.ZipFile(io.BytesIO(wrapped(site / "live/study.zip.js"))) as study:
        for file in ("tunneller_lib/__init__.py", "notebooks/atlas.csv"):
            assert study.read(file) == (ROOT / file).read_bytes()
    found = {p.name for p in (site / "live/licences").rglob("*") if p.is_file()}
    assert {"LICENSE", "Pyodide-MPL-2.0.txt", "Python-PSF-2.0.txt"} <= found


def test_no_own_script_of_pages_that_run_names_an_address():
    for name in ("live.js", "worker.js", "planner.js", "geodesic.js", "live.css"):
        text = re.sub(
            r"^\s*//.*$|/\*.*?\*/", "", (ROOT / "report/live" / name).read_text(), flags=re.M
        )
        assert re.findall(r"https?://[^/\"]+", text) in ([], ["https://local.invalid"]), name
