"""Write planner.md: how long the planner's laps and moves take beside toppra's.

make bench, then build/bench/bin/python -m tests.bench.planner
"""

import platform
import time
from importlib.metadata import version
from pathlib import Path

import toppra

from tests.bench.test_bench_planner import LAPS, duration, lap, toppra_run

TABLE = Path(__file__).with_suffix(".md")


def main():
    rows = []
    for speed, acceleration, blend in LAPS:
        job = lap(speed, acceleration, blend)
        ours = duration(job)
        theirs = toppra_run(toppra, job.route, speed, acceleration)
        rows.append(
            f"| {speed} | {acceleration} | {1e3 * blend} | {ours:.3f} | {theirs:.3f} "
            f"| {ours / theirs:.4f} |"
        )
    names = ", ".join(f"{name} {version(name)}" for name in ("numpy", "toppra"))
    lines = [
        "# Durations beside toppra's",
        "",
        f"`python -m tests.bench.planner` on {time.strftime('%F')}, {names}, Python "
        f"{platform.python_version()}. A lap of the reference machine's egg, its corners rounded, "
        "under limits of both joints, ticks of 1 ms: both get the same way, and ours keeps the "
        "limits on the exact slopes of its moves.",
        "",
        "| rad/s | rad/s^2 | corners missed by, mm | ours, s | toppra, s | ours over toppra's |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows,
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
