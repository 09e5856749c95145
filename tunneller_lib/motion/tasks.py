"""The controller's tasks (Fig. 7): a fast interpolation, a servo, a slow preparation of segments.

Times are whole numbers of one unit, such as a microsecond. Tasks stand in order of priority, the
most urgent first; a more urgent task interrupts the others at once.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from ..arguments import Each, Whole, Wholes, checked

LONGEST = 2**40  # units of time
MOST_RELEASES = 200_000  # of a run; then it takes about a second

Time = Whole(1, LONGEST)
Times = Wholes("(k,) int", 1, LONGEST)


@dataclass(frozen=True)
@checked
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
        If period or cost isn't a whole number from 1 to 2^40.
    """

    name: str
    period: Time
    cost: Time


Tasks = Each(Task, some=True)


class Slice(NamedTuple):
    """A stretch of time in which one task has the processor.

    Parameters
    ----------
    name : str
        The task's.
    start, stop : int
        In the unit of the tasks' periods.
    """

    name: str
    start: int
    stop: int


class Release(NamedTuple):
    """One release of a task.

    Parameters
    ----------
    name : str
        The task's.
    released, done : int
        When it was, and when the work was done, in the unit of the tasks' periods.
    """

    name: str
    released: int
    done: int


class HandOver(NamedTuple):
    """What became of each segment: tuples with one entry a segment.

    Parameters
    ----------
    ready, needed, started : tuple of int
        When it was, in the unit of the tasks' periods.
    starved : tuple of int
        Ticks on which the last set-value was held for want of it.
    """

    ready: tuple
    needed: tuple
    started: tuple
    starved: tuple


@checked
def utilisation(tasks: Tasks):
    """Return the share of the processor that tasks take."""
    return sum(task.cost / task.period for task in tasks)


@checked
def response_times(tasks: Tasks):
    """Return the longest time from release to end of each task, released all at once.

    Parameters
    ----------
    tasks : list of Task
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
    return [_response(tasks[:i], task.cost, task.period, math.inf) for i, task in enumerate(tasks)]


@checked
def background_response(tasks: Tasks, cost: Time):
    """Return the longest time that work of a `cost` takes when all tasks are more urgent.

    Infinite where it would be beyond 2^40.

    Raises
    ------
    ValueError
        If the tasks leave nothing of the processor.
    """
    _leaves_time(tasks)
    return _response(tasks, cost, LONGEST, math.inf)


@checked
def schedule(tasks: Tasks, horizon: Time):
    """Run tasks, all released at 0, event by event up to a horizon.

    Returns
    -------
    slices : list of Slice
        Who has the processor, in order of time; gaps are idle.
    done : list of Release
        Every release whose work was done before the horizon, in order of its end.

    Raises
    ------
    ValueError
        If there are more than 200 000 releases up to the horizon.
    """
    releases = _releases(tasks, horizon)
    if releases > MOST_RELEASES:
        raise ValueError(
            f"horizon: must be after at most {MOST_RELEASES} releases; got {horizon}, which is "
            f"after {releases}."
        )
    return _run(tasks, horizon)


def _releases(tasks, horizon):
    """Return how often tasks are released before a horizon."""
    return sum(-(-horizon // task.period) for task in tasks)


def _run(tasks, horizon):
    """Return `schedule`: from event to event the most urgent work has the processor."""
    coming_release = [0] * len(tasks)
    waiting = []  # (priority, release, work left), the most urgent first
    now = 0
    slices = []
    done = []
    while now < horizon:
        # What was released meanwhile joins those that wait.
        for i, task in enumerate(tasks):
            while coming_release[i] <= now:
                waiting.append((i, coming_release[i], task.cost))
                coming_release[i] += task.period
        waiting.sort()
        # Until the next release nothing changes who is the most urgent.
        coming = min(*coming_release, horizon)
        if not waiting:
            now = coming
            continue
        i, release, left = waiting.pop(0)
        stop = min(now + left, coming)
        # A slice goes on where a release interrupted nobody.
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
    """Run the preparation of segments in the time that tasks leave, and their interpolation.

    Parameters
    ----------
    tasks : list of Task
        All more urgent than the preparation; the first is the interpolation.
    costs : (k,) int
        What the preparation of each segment costs.
    ticks : (k,) int
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
        If the lists don't match, the tasks can't keep their periods or leave no time, or their
        pattern only repeats after more than 200 000 releases.

    Notes
    -----
    Tunnelling robot, section 4.4 and Fig. 7. A double buffer is never starved if
    `background_response` of the dearest segment is at most the shortest segment's time.
    """
    costs, ticks = _segments(costs, ticks)
    _leaves_time(tasks)
    idle, cycle = _idle(tasks)
    tick = tasks[0].period
    ready = []
    needed = [0]
    started = []
    for k, (cost, number) in enumerate(zip(costs, ticks, strict=True)):
        # The preparation goes on when the segment before is ready and a place is free.
        before = ready[-1] if ready else 0
        free = max(before, started[k - depth] if k >= depth else 0)
        ready.append(_finish(idle, cycle, free, cost))
        started.append(-(-max(needed[k], ready[k]) // tick) * tick)
        needed.append(started[k] + number * tick)
    starved = tuple((s - n) // tick for s, n in zip(started, needed[:-1], strict=True))
    return HandOver(tuple(ready), tuple(needed[:-1]), tuple(started), starved)


@checked
def buffer_depth(tasks: Tasks, costs: Times, ticks: Times):
    """Return the least depth with which no segment but the first is waited for, or None.

    The arguments (tasks, costs, ticks) are those of `hand_over`.
    """
    _segments(costs, ticks)
    for depth in range(1, len(costs) + 1):
        if not any(hand_over(tasks, costs, ticks, depth=depth).starved[1:]):
            return depth
    return None


def _segments(costs, ticks):
    """Return costs and ticks as lists, which must be of one length and not empty."""
    if not len(costs):
        raise ValueError("costs: must be a list, not empty; got none.")
    if len(costs) != len(ticks):
        raise ValueError(f"ticks: needs one entry for each cost; got {len(ticks)}, {len(costs)}.")
    return costs.tolist(), ticks.tolist()


def _response(urgent, cost, latest, otherwise):
    time = 0
    wanted = cost
    while time != wanted:
        time = wanted
        if time > latest:
            return otherwise
        wanted = cost + sum(-(-time // task.period) * task.cost for task in urgent)
    return time


def _idle(tasks):
    """Return the idle stretches of one cycle after which the tasks' pattern repeats."""
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
    share = utilisation(tasks)
    if math.inf in response_times(tasks) or share >= 1:
        raise ValueError(
            "tasks: must keep their periods and leave time for the preparation; "
            f"got a utilisation of {100 * share:.1f} %."
        )
