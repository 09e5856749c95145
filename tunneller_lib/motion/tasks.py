"""The controller's tasks (Fig. 7): a fast interpolation, a servo, a slow preparation of segments.

Times are whole numbers of one unit, such as a microsecond. Tasks stand in order of priority, the
most urgent first; a more urgent task interrupts the others at once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ..arguments import instance, whole

LONGEST = 2**40


@dataclass(frozen=True)
class Task:
    """A task that is released again and again.

    Parameters
    ----------
    name : str
        What it does.
    period, cost : int
        Time between two releases, and time that each takes of the processor.

    Raises
    ------
    ValueError
        If period or cost isn't a whole number above zero.
    """

    name: str
    period: int
    cost: int

    def __post_init__(self):
        for name in ("period", "cost"):
            object.__setattr__(self, name, _one(name, getattr(self, name)))


class Slice(NamedTuple):
    """A stretch of time in which one task has the processor."""

    name: str
    start: int
    stop: int


class Job(NamedTuple):
    """One release of a task, and when it was done."""

    name: str
    release: int
    done: int


class HandOver(NamedTuple):
    """When each segment was ready, needed and started; ticks that were held for want of it."""

    ready: tuple
    needed: tuple
    started: tuple
    starved: tuple


def load(tasks):
    """Return the share of the processor that tasks take."""
    return sum(task.cost / task.period for task in _checked(tasks))


def response_times(tasks):
    """Return the longest time from release to end of each task, released all at once.

    Parameters
    ----------
    tasks : sequence of Task
        In order of priority.

    Returns
    -------
    times : list of int or float
        The least R with R = C + sum of ceil(R / T_j) C_j over the more urgent tasks; infinite
        where it would be later than the next release.

    Examples
    --------
    >>> fast = [Task("line", 1000, 100), Task("servo", 2000, 300)]
    >>> response_times([*fast, Task("slow", 9000, 2000)])
    [100, 400, 2900]
    """
    tasks = _checked(tasks)
    return [_response(tasks[:i], task.cost, task.period, math.inf) for i, task in enumerate(tasks)]


def background_response(tasks, cost):
    """Return the longest time that work of a `cost` takes when all tasks are more urgent.

    Raises
    ------
    ValueError
        If the tasks leave nothing of the processor.
    """
    tasks = _checked(tasks)
    _leaves_time(tasks)
    return _response(tasks, _one("cost", cost), LONGEST, math.inf)


def schedule(tasks, horizon):
    """Run tasks, all released at 0, event by event up to a horizon.

    Returns
    -------
    slices : list of Slice
        Who has the processor, in order of time; gaps are idle.
    jobs : list of Job
        Every release that was done before the horizon, in order of its end.
    """
    tasks, horizon = _checked(tasks), _one("horizon", horizon)
    releases = [0] * len(tasks)
    waiting = []  # (priority, release, work left), the most urgent first
    now, slices, jobs = 0, [], []
    while now < horizon:
        for i, task in enumerate(tasks):
            while releases[i] <= now:
                waiting.append((i, releases[i], task.cost))
                releases[i] += task.period
        waiting.sort()
        coming = min(*releases, horizon)
        if not waiting:
            now = coming
            continue
        i, release, left = waiting.pop(0)
        stop = min(now + left, coming)
        if slices and slices[-1].name == tasks[i].name and slices[-1].stop == now:
            slices[-1] = slices[-1]._replace(stop=stop)
        else:
            slices.append(Slice(tasks[i].name, now, stop))
        if stop == now + left:
            jobs.append(Job(tasks[i].name, release, stop))
        else:
            waiting.append((i, release, left - (stop - now)))
        now = stop
    return slices, jobs


def hand_over(tasks, costs, ticks, *, depth=1):
    """Run the preparation of segments in the time that tasks leave, and their interpolation.

    Parameters
    ----------
    tasks : sequence of Task
        All more urgent than the preparation; the first is the interpolation.
    costs : sequence of int
        What the preparation of each segment costs.
    ticks : sequence of int
        How many ticks of the interpolation each segment lasts.
    depth : int
        How many segments may wait, ready or in work; 1 is a double buffer.

    Returns
    -------
    run : HandOver
        Tuples with one entry for each segment. A segment starts on the first tick at which it is
        needed and ready; until then the last set-value is held, so that starvation costs time and
        never counts. What is starved before the first segment is the start-up.

    Raises
    ------
    ValueError
        If the lists don't match, or the tasks can't keep their periods or leave no time.

    Notes
    -----
    Tunnelling robot, section 4.4 and Fig. 7. A double buffer is never starved if
    `background_response` of the dearest segment is at most the shortest segment's time.
    """
    tasks, depth = _checked(tasks), _one("depth", depth)
    costs = [_one("costs", cost) for cost in costs]
    ticks = [_one("ticks", number) for number in ticks]
    if len(costs) != len(ticks) or not costs:
        raise ValueError(f"ticks: needs one entry for each cost; got {len(ticks)}, {len(costs)}.")
    _leaves_time(tasks)
    idle, cycle = _idle(tasks)
    tick = tasks[0].period
    ready, needed, started = [], [0], []
    for k, (cost, number) in enumerate(zip(costs, ticks, strict=True)):
        free = max(ready[-1] if ready else 0, started[k - depth] if k >= depth else 0)
        ready.append(_finish(idle, cycle, free, cost))
        started.append(-(-max(needed[k], ready[k]) // tick) * tick)
        needed.append(started[k] + number * tick)
    starved = tuple((s - n) // tick for s, n in zip(started, needed[:-1], strict=True))
    return HandOver(tuple(ready), tuple(needed[:-1]), tuple(started), starved)


def buffer_depth(tasks, costs, ticks):
    """Return the least depth with which no segment but the first is waited for, or None.

    The arguments (tasks, costs, ticks) are those of `hand_over`.
    """
    for depth in range(1, len(costs) + 1):
        if not any(hand_over(tasks, costs, ticks, depth=depth).starved[1:]):
            return depth
    return None


def _response(urgent, cost, latest, otherwise):
    time, wanted = 0, cost
    while time != wanted:
        time = wanted
        if time > latest:
            return otherwise
        wanted = cost + sum(-(-time // task.period) * task.cost for task in urgent)
    return time


def _idle(tasks):
    """Return the idle stretches of one cycle after which the tasks' pattern repeats."""
    cycle = math.lcm(*(task.period for task in tasks))
    slices, _ = schedule(tasks, cycle)
    edges = [0, *(edge for one in slices for edge in one[1:]), cycle]
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a], cycle


def _finish(idle, cycle, start, cost):
    """Return when work that may begin at `start` is done in the idle stretches."""
    turn, place = divmod(start, cycle)
    per_cycle = sum(b - a for a, b in idle)
    cost += sum(max(0, min(b, place) - a) for a, b in idle)  # as if begun with the cycle
    full, left = divmod(cost - 1, per_cycle)
    left += 1
    for a, b in idle:
        if left <= b - a:
            break
        left -= b - a
    return (turn + full) * cycle + a + left


def _leaves_time(tasks):
    if math.inf in response_times(tasks) or load(tasks) >= 1:
        raise ValueError(
            "tasks: must keep their periods and leave time for the preparation; "
            f"got a load of {100 * load(tasks):.1f} %."
        )


def _checked(tasks):
    if not isinstance(tasks, Sequence) or not tasks:
        raise ValueError(f"tasks: must be a sequence of at least one task; got {tasks!r}.")
    return [instance("tasks", task, Task) for task in tasks]


def _one(name, value):
    number = whole(name, value, 1, LONGEST)
    if number.ndim:
        raise ValueError(f"{name}: must be one whole number; got an array {number.shape}.")
    return int(number)
