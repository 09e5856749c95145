"""Print the tests of the library's core: those that need numpy and scipy alone, and pytest."""

from report.reach import needed
from report.sources import ROOT

STUDY = ("report", "notebooks", "tunneller_lib/__main__.py")


def core_tests():
    """Return the names of the test files that need nothing of the report, and no drawing."""
    names = []
    for test in sorted((ROOT / "tests").glob("test_*.py")):
        text = test.read_text(encoding="utf-8")
        files = needed(text, ROOT, ("tests",))
        modules = [str(file.relative_to(ROOT)) for file in files]
        texts = [
            text,
            *(file.read_text(encoding="utf-8") for file in files if "tests" in file.parts),
        ]
        others = ("nbformat", "matplotlib", "import IPython", "blark")
        drawn = any(word in text for text in texts for word in others)
        if not drawn and not any(name.startswith(STUDY) for name in modules):
            names.append(str(test.relative_to(ROOT)))
    return names


if __name__ == "__main__":
    print(*core_tests())
