"""Kill, double and damage builds, and see that the next one ends with the same bytes.

    .venv/bin/python -m tests.audit.interruptions [--kills 8] [--doubles 4] [--seed 1]

A clone of what is committed, in a temporary folder, is built. Then builds of lost results are
killed (SIGKILL, make and all) at random moments, two builds are started at once, and ten things are
damaged. After each the next `make report` must end well and leave every file as it was after the
first. The table goes to tests/interruptions.md, and a row a trial to the screen.
"""

import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from report.sources import ROOT, digest
from tests.audit.long import git

TABLE = ROOT / "tests" / "audit" / "interruptions.md"


def build(study, **options):
    """Start `make report` in a group of processes of its own."""
    return subprocess.Popen(
        ["make", "report"], cwd=study, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options,
    )  # fmt: skip


def built(study):
    """Build to the end, and return what was said; a build that fails ends the program."""
    process = build(study)
    said, _ = process.communicate(timeout=1800)
    if process.returncode:
        raise SystemExit(f"{study}: a build failed.\n{said}")
    return said


def results(study):
    """Return the digest of each file that a build makes or may spoil."""
    folders = ("notebooks", "figures", "report")
    files = (f for folder in folders for f in sorted((study / folder).rglob("*")))
    kept = (f for f in files if f.is_file() and f.suffix != ".pyc")
    return {str(f.relative_to(study)): digest(f.read_bytes()) for f in kept}


def lose(study, rng):
    """Lose or alter results, or change a source, so that there is something to build."""
    made = [f for f in results(study) if f.startswith(("figures/", "report/numbers/"))]
    for name in rng.sample(made, 3):
        (study / name).unlink()
    state = sorted((study / "build" / "state").glob("*.json"))
    rng.choice(state).unlink()


def killed(study, rng, usual):
    while True:
        lose(study, rng)
        process = build(study)
        wait = rng.uniform(0.5, usual)
        try:
            process.communicate(timeout=wait)  # it had less to do, and ended: once more
        except subprocess.TimeoutExpired:
            break
    os.killpg(process.pid, signal.SIGKILL)
    said, _ = process.communicate()
    return f"killed after {wait:.1f} s, {len(re.findall(r'^ *[0-9]+ of', said, re.M))} done"


def doubled(study, rng, usual):
    lose(study, rng)
    first = build(study)
    time.sleep(rng.uniform(0, usual / 2))
    second = build(study)
    said = [process.communicate(timeout=1800)[0] for process in (first, second)]
    waited = "one waited" if any("Waiting for `make report`" in text for text in said) else ""
    if first.returncode or second.returncode:
        raise SystemExit("\n".join(said))
    return waited or "the second came when the first had ended"


def shortened(path):
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


DAMAGES = {
    "a state cut in two": lambda s: shortened(s / "build/state/03_tunnel.json"),
    "a state that is another file": lambda s: (s / "build/state/report.json").write_text("[1]"),
    "no state": lambda s: shutil.rmtree(s / "build/state"),
    "no folder build": lambda s: shutil.rmtree(s / "build"),
    "numbers cut in two": lambda s: shortened(s / "report/numbers/03_tunnel.json"),
    "numbers without a figure's record": lambda s: without_figure(s),
    "a figure altered": lambda s: (s / "figures/rod_box.svg").write_text("<svg/>"),
    "the PDF cut in two": lambda s: shortened(s / "report/report.pdf"),
}


def without_figure(study):
    file = study / "report/numbers/03_tunnel.json"
    content = json.loads(file.read_text())
    content["figures"].clear()
    file.write_text(json.dumps(content))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kills", type=int, default=8)
    parser.add_argument("--doubles", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng, rows = random.Random(options.seed), []
    with tempfile.TemporaryDirectory(prefix="interruptions-") as folder:
        study = Path(folder, "study")
        subprocess.run(["git", "clone", "--quiet", ROOT, study], check=True)
        built(study)
        first, begun = results(study), time.monotonic()
        lose(study, rng)
        built(study)
        usual = time.monotonic() - begun
        trials = [("killed", killed)] * options.kills + [("two at once", doubled)] * options.doubles
        for name, trial in trials:
            rows.append([name, trial(study, rng, usual)])
            check(study, first, rows)
        for name, damage in DAMAGES.items():
            damage(study)
            rows.append(["damaged", name])
            check(study, first, rows)
    write(rows)


def check(study, first, rows):
    """Build again and compare; a difference ends the program."""
    begun = time.monotonic()
    built(study)
    now = results(study)
    odd = sorted(name for name in {*first, *now} if first.get(name) != now.get(name))
    rows[-1] += [f"{time.monotonic() - begun:.0f} s", "the same bytes" if not odd else str(odd)]
    print(" | ".join(rows[-1]), flush=True)
    if odd:
        raise SystemExit("The next build left other bytes.")


def write(rows):
    commit = git("describe", "--always")
    lines = [
        "# Builds that were killed, doubled, damaged", "",
        f"By `tests/audit/interruptions.py` on {time.strftime('%F')}, commit {commit}.", "",
        "| build | what happened | next build | its results |", "| --- | --- | --- | --- |",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]  # fmt: skip
    TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
