"""Fig. 7 as tasks: response times against a run event by event, starvation, buffers."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tunneller_lib.motion.tasks import (
    Task,
    background_response,
    buffer_depth,
    hand_over,
    response_times,
    schedule,
)

FAST = [Task("interpolation", 5000, 400), Task("servo", 5000, 600), Task("watch", 20000, 1500)]


def random_tasks(draw):
    """Return up to four tasks, rate-monotonic, that take less than the whole processor."""
    periods = sorted(draw(st.lists(st.sampled_from([20, 30, 40, 60, 100, 120]), min_size=1,
                                   max_size=4)))  # fmt: skip
    return [
        Task(f"t{i}", p, draw(st.integers(1, max(1, p // (len(periods) + 1)))))
        for i, p in enumerate(periods)
    ]


@given(st.data())
def test_response_times_are_the_longest_of_a_run(data):
    tasks = random_tasks(data.draw)
    times = response_times(tasks)
    _, releases = schedule(tasks, 4 * math.lcm(*(t.period for t in tasks)))
    for task, time in zip(tasks, times, strict=True):
        if math.inf not in times:
            assert max(one.done - one.released for one in releases if one.name == task.name) == time


def by_events(tasks, costs, ticks, depth):
    """Return when segments are ready and start, unit of time by unit of time."""
    slices, _ = schedule(tasks, 40 * math.lcm(*(t.period for t in tasks)))
    busy = {t for s in slices for t in range(s.start, s.stop)}
    tick, now, left = tasks[0].period, 0, costs[0]
    ready, started, end = [], [], 0
    while len(started) < len(costs):
        if now % tick == 0 and len(started) < len(ready) and now >= end:
            end = now + ticks[len(started)] * tick
            started.append(now)
        if len(ready) < len(costs) and len(ready) - len(started) < depth and now not in busy:
            left -= 1
            if left == 0:
                ready.append(now + 1)
                left = costs[len(ready)] if len(ready) < len(costs) else 0
        now += 1
    return tuple(ready), tuple(started)


@given(st.lists(st.tuples(st.integers(1, 90), st.integers(1, 6)), min_size=1, max_size=7),
       st.integers(1, 3))  # fmt: skip
def test_hand_over_is_what_happens_unit_by_unit(segments, depth):
    tasks = [Task("line", 10, 2), Task("servo", 20, 3)]
    costs, ticks = zip(*segments, strict=True)
    run = hand_over(tasks, costs, ticks, depth=depth)
    assert (run.ready, run.started) == by_events(tasks, costs, ticks, depth)
    enough = background_response(tasks, max(costs)) <= 10 * min(ticks)
    assert not (enough and any(run.starved[1:]))
    for k, wait in enumerate(run.starved):
        assert (wait > 0) == (run.ready[k] > run.needed[k])
        assert run.started[k] == run.needed[k] + 10 * wait


def test_buffer_depth_evens_out_segments():
    costs, ticks = [10_000] * 8, [10, 10, 10, 1, 1, 10, 10, 10]
    depth = buffer_depth(FAST, costs, ticks)
    assert depth > 1
    assert not any(hand_over(FAST, costs, ticks, depth=depth).starved[1:])
    assert any(hand_over(FAST, costs, ticks, depth=depth - 1).starved[1:])
    assert buffer_depth(FAST, [100_000] * 8, ticks) is None


def test_tasks_refuse_what_cannot_be():
    full = [Task("a", 10, 10)]
    coprime = [Task("a", 9973, 1), Task("b", 9967, 1), Task("c", 9949, 1)]
    for call, said in [
        (lambda: hand_over(full, [1], [1]), r"tasks: must keep their periods and leave time"),
        (lambda: schedule(FAST, 2**40), r"horizon: must come after at most 200000 releases"),
        (lambda: hand_over(coprime, [1], [1]), r"tasks: their pattern must repeat after at most"),
    ]:
        with pytest.raises(ValueError, match=f"^{said}"):
            call()
