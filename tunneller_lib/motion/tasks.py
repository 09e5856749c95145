"""The controller's tasks (Fig. 7): a fast interpolation, a servo, a slow preparation of segments.

Times are whole numbers of one unit, such as a microsecond. Tasks are listed by priority, the most
urgent first; a more urgent task interrupts the others at once.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from ..arguments import Each, Whole, Wholes, checked

LONGEST = 2**40  # units of time
MOST_RELEASES = 200_000  # in a run, which takes about a second then

Time = Whole(1, LONGEST)
Times = Wholes("(k,) int", 1, LONGEST)


@dataclass(frozen=True)
@checked
class Task:
    """A task that is released periodically.

    Parameters
    ----------
    name : str
        Its name.
    period, cost : int
        Time between two releases, and the processor time that each takes.

    Raises
    ------
    ValueError
        If period or cost isn't a whole number from 1 to 2^40.
    """

    name: str
    period: Time
    cost: Time


Tasks = Each(Task, some=True)


class Slice(NamedTuple):
    """A stretch of time from start to stop in which the task `name` has the processor."""

    name: str
    start: int
    stop: int


class Release(NamedTuple):
    """One release of the task `name`: the time when it was `released` and when it was `done`."""

    name: str
    released: int
    done: int


class HandOver(NamedTuple):
    """The times at which segments were ready, needed and started, with one entry per segment.

    Parameters
    ----------
    ready, needed, started : tuple of int
        Times in the unit of the tasks' periods.
    starved : tuple of int
        Number of ticks in which the last set-value was held because the segment wasn't ready.
    """

    ready: tuple
    needed: tuple
    started: tuple
    starved: tuple


@checked
def utilisation(tasks: Tasks):
    """Return the share of the processor that tasks take, the sum of cost / period."""
    return sum(task.cost / task.period for task in tasks)


@checked
def response_times(tasks: Tasks):
    """Return the longest time from release to end of each task, which is met if all start at once.

    Parameters
    ----------
    tasks : list of Task
        The tasks in order of priority.

    Returns
    -------
    times : list of int or float
        For a task of cost C the least R = C + sum of ceil(R / T_j) C_j over the more urgent tasks,
        of periods T_j and costs C_j; infinite if it would exceed the task's own period.

    Examples
    --------
    >>> fast = [Task("line", 1000, 100), Task("servo", 2000, 300)]
    >>> response_times([*fast, Task("slow", 9000, 2000)])
    [100, 400, 2900]
    """
    return [_response(tasks[:i], task.cost, task.period) for i, task in enumerate(tasks)]


@checked
def background_response(tasks: Tasks, cost: Time):
    """Return the longest time that work of a `cost` takes if all `tasks` are more urgent.

    It is infinite if it would exceed 2^40.

    Raises
    ------
    ValueError
        If the tasks leave no processor time.
    """
    _leaves_time(tasks)
    return _response(tasks, cost, LONGEST)


@checked
def schedule(tasks: Tasks, horizon: Time):
    """Return the schedule of tasks, all released at 0, up to a `horizon`.

    Returns
    -------
    slices : list of Slice
        The tasks that have the processor, in order of time; gaps are idle.
    done : list of Release
        Every release whose work is done by the horizon, in order of the ends.

    Raises
    ------
    ValueError
        If there are more than 200 000 releases up to the horizon.
    """
    releases = _releases(tasks, horizon)
    if releases > MOST_RELEASES:
        raise ValueError(
            f"horizon: must come after at most {MOST_RELEASES} releases; got {horizon}, after "
            f"{releases}."
        )
    return _run(tasks, horizon)


def _releases(tasks, horizon):
    """Return how often tasks are released before a horizon."""
    return sum(-(-horizon // task.period) for task in tasks)


def _run(tasks, horizon):
    """Return the slices and the finished releases of `schedule`."""
    coming_release = [0] * len(tasks)
    waiting = []  # (priority, release, work left), the most urgent first
    now = 0
    slices = []
    done = []
    while now < horizon:
        # Releases up to now join the waiting work.
        for i, task in enumerate(tasks):
            while coming_release[i] <= now:
                waiting.append((i, coming_release[i], task.cost))
                coming_release[i] += task.period
        waiting.sort()
        # Until the next release the most urgent work keeps the processor.
        coming = min(*coming_release, horizon)
        if not waiting:
            now = coming
            continue
        i, release, left = waiting.pop(0)
        stop = min(now + left, coming)
        # A release that didn't interrupt the task continues its last slice.
        if slices and slices[-1].name == tasks[i].name and slices[-1].stop == now:
            slices[-1] = slices[-1]._replace(stop=stop)
        else:
            slices.append(Slice(tasks[i].name, now, stop))
        if stop == now + left:
            done.append(Release(tasks[i].name, release, stop))
        else:
            waiting.append((i, release, left - (stop - now)))
        now = stop
    return slices, done


@checked
def hand_over(tasks: Tasks, costs: Times, ticks: Times, *, depth: Time = 1):
    """Return when segments are ready and start if they are prepared in the time that tasks leave.

    Parameters
    ----------
    tasks : list of Task
        All more urgent than the preparation; the first is the interpolation.
    costs : (k,) int
        Processor times that the preparation of the segments takes.
    ticks : (k,) int
        Durations of the segments, in ticks of the interpolation.
    depth : int
        Number of segments that may be ready or in preparation; 1 is a double buffer.

    Returns
    -------
    run : HandOver
        A segment starts at the first tick at which it is needed and ready. Until then the last
        set-value is held: starvation costs time, never counts. The wait for the first segment is
        the start-up.

    Raises
    ------
    ValueError
        If the lists don't match, the tasks can't keep their periods or leave no time, or their
        pattern only repeats after more than 200 000 releases.

    Notes
    -----
    Tunnelling robot, section 4.4 and Fig. 7. A double buffer never starves if the
    `background_response` to the highest cost is at most the time of the shortest segment.

    Examples
    --------
    >>> line = [Task("line", 1000, 100)]
    >>> hand_over(line, [500, 500], [2, 2]).started
    (1000, 3000)
    >>> hand_over(line, [500, 500], [2])
    Traceback (most recent call last):
    ValueError: ticks: needs one entry for each cost; got 1, 2.
    >>> import numpy as np
    >>> hand_over(line, np.zeros(0, int), np.zeros(0, int))
    Traceback (most recent call last):
    ValueError: costs: must be a list, not empty; got none.
    """
    if not len(costs):
        raise ValueError("costs: must be a list, not empty; got none.")
    if len(costs) != len(ticks):
        raise ValueError(f"ticks: needs one entry for each cost; got {len(ticks)}, {len(costs)}.")
    _leaves_time(tasks)
    idle, cycle = _idle(tasks)
    tick = tasks[0].period
    ready = []
    needed = [0]
    started = []
    for k, (cost, number) in enumerate(zip(costs.tolist(), ticks.tolist(), strict=True)):
        # A preparation begins once the one before is finished and a place is free.
        before = ready[-1] if ready else 0
        free = max(before, started[k - depth] if k >= depth else 0)
        ready.append(_finish(idle, cycle, free, cost))
        started.append(-(-max(needed[k], ready[k]) // tick) * tick)
        needed.append(started[k] + number * tick)
    starved = tuple((s - n) // tick for s, n in zip(started, needed[:-1], strict=True))
    return HandOver(tuple(ready), tuple(needed[:-1]), tuple(started), starved)


@checked
def buffer_depth(tasks: Tasks, costs: Times, ticks: Times):
    """Return the least depth at which only the first segment is waited for, or None.

    The arguments (tasks, costs, ticks) are those of `hand_over`.
    """
    for depth in range(1, max(len(costs), 1) + 1):
        if not any(hand_over(tasks, costs, ticks, depth=depth).starved[1:]):
            return depth
    return None


def _response(urgent, cost, latest):
    """Return the least R = cost + sum ceil(R / T_j) C_j over urgent tasks; infinite if too late."""
    # From below, each step adds the releases within the time so far, up to the least fixed point.
    time = 0
    wanted = cost
    while time != wanted:
        time = wanted
        if time > latest:
            return math.inf
        wanted = cost + sum(-(-time // task.period) * task.cost for task in urgent)
    return time


def _idle(tasks):
    """Return the idle stretches of the cycle after which the pattern repeats, and the cycle."""
    cycle = math.lcm(*(task.period for task in tasks))
    releases = _releases(tasks, cycle)
    if releases > MOST_RELEASES:
        raise ValueError(
            f"tasks: their pattern must repeat after at most {MOST_RELEASES} releases; "
            f"got {releases} in the least common multiple of their periods."
        )
    slices, _ = _run(tasks, cycle)
    edges = [0, *(edge for one in slices for edge in one[1:]), cycle]
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a], cycle


def _finish(idle, cycle, start, cost):
    """Return when work of a `cost` that may begin at `start` is done in the idle stretches."""
    turn, place = divmod(start, cycle)
    per_cycle = sum(b - a for a, b in idle)
    # Count as if it had begun with the cycle, and used the idle time before `start` as well.
    cost += sum(max(0, min(b, place) - a) for a, b in idle)
    full, left = divmod(cost - 1, per_cycle)  # the end of a cycle's idle time belongs to that cycle
    left += 1
    for a, b in idle:
        if left <= b - a:
            break
        left -= b - a
    return (turn + full) * cycle + a + left


def _leaves_time(tasks):
    """Raise ValueError if tasks can't keep their periods or take the whole processor."""
    share = utilisation(tasks)
    if math.inf in response_times(tasks) or share >= 1:
        raise ValueError(
            "tasks: must keep their periods and leave time for the preparation; "
            f"got a utilisation of {100 * share:.1f} %."
        )
