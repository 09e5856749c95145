"""Write planner.md: how long the planner's laps and moves take beside toppra's and ruckig's.

make bench, then build/bench/bin/python -m tests.bench.planner
"""

import platform
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np
import ruckig
import toppra

from tests.bench.test_bench_planner import (
    LAPS,
    TICK,
    duration,
    lap,
    ruckigs_duration,
    single_moves,
    toppra_run,
)
from tunneller_lib.ream.timing import move_shares, move_ticks

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
    ratios = [
        (len(move_shares(move_ticks(*one, TICK))) - 1) * TICK / ruckigs_duration(ruckig, *one)
        for one in single_moves().tolist()
    ]
    names = ", ".join(f"{name} {version(name)}" for name in ("numpy", "toppra", "ruckig"))
    lines = [
        "# Durations beside toppra's and ruckig's",
        "",
        f"`python -m tests.bench.planner` on {time.strftime('%F')}, {names}, Python "
        f"{platform.python_version()}. A lap of the reference machine's egg, its corners rounded, "
        "under limits of both joints and without a limit of jerk, ticks of 1 ms: both get the same "
        "way, and ours keeps the limits on the exact slopes of its moves.",
        "",
        "| rad/s | rad/s^2 | corners missed by, mm | ours, s | toppra, s | ours over toppra's |",
        "| --- | --- | --- | --- | --- | --- |",
        *rows,
        "",
        f"Single moves from rest to rest with a limit of jerk, {len(ratios)} at random: ours take "
        f"{min(ratios):.4f} to {max(ratios):.4f} times as long as ruckig's, "
        f"{np.median(ratios):.4f} in the median. Shorter "
        "ones keep their limits in slopes of whole ticks.",
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
