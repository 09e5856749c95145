"""Straight moves of whole ticks between setpoints, and how they keep the limits."""

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from ..motion import polyline, polyline_slopes

FINEST = 4096  # parts of a count, to which setpoints are rounded
MOST = 2**30  # parts, and parts times the ticks of a move, so that 32 bits hold their sums


@dataclass(frozen=True, eq=False)
class Moves:
    """Straight moves of both joints in whole ticks: m of them between m + 1 setpoints.

    Parameters
    ----------
    setpoints : (m + 1, 2) float
        Joint positions (theta, phi), in rad.
    ticks : (m,) int
        Durations of the moves, in ticks.
    tick : float
        Period of the fast task, in s.
    count : float
        Angle of a count of both joints, in rad.
    """

    setpoints: np.ndarray
    ticks: np.ndarray
    tick: float
    count: float

    @property
    def fineness(self):
        """Return the number of parts of a count: 4096, or fewer if 32 bits can't hold them."""
        greatest = max(np.abs(self.setpoints).max() / self.count, self.ticks.max(), 1.0)
        return int(2 ** np.floor(np.log2(np.clip(MOST / greatest, 1, FINEST))))

    @property
    def parts(self):
        """Return the setpoints (m + 1, 2) in whole parts of a count; see `fineness`."""
        return np.rint(self.fineness / self.count * self.setpoints).astype(np.int64)

    @property
    def setvalues(self):
        """Return the joint positions (ticks + 1, 2) at all ticks, in whole counts, in rad.

        Each is within half a count of the exact line between the setpoints' `parts`.
        """
        return self.count * polyline(self.parts, self.ticks, parts=self.fineness)

    @property
    def slopes(self):
        """Return the exact rates (ticks, 2) of the lines that the set-values round, in rad/s."""
        rates = polyline_slopes(self.parts, self.ticks, parts=self.fineness)
        return self.count / self.tick * rates


def strains(torus, positions, tick, limits):
    """Return the cutter's accelerations in a run as shares of their limit.

    Parameters
    ----------
    torus : Torus
        The machine's.
    positions : (n + 1, 2) float
        Joint positions, one for each tick, in rad; the joints rest before and after the run.
    tick : float
        Period of the fast task, in s.
    limits : Limits
        Limits of the motion.

    Returns
    -------
    acceleration : (n + 1,) float
        The share at each tick.
    """
    lever = levers(torus, positions)
    still = np.concatenate([positions[:1], positions, positions[-1:]])
    second = np.diff(still, n=2, axis=0) / tick**2
    return np.linalg.norm(lever * second, axis=-1) / limits.acceleration


def levers(torus, positions):
    """Return the levers (..., 2) of both joints: how far the cutter moves per radian, in m."""
    return np.stack(
        [torus.r + torus.R * np.cos(positions[..., 1]), np.full(positions.shape[:-1], torus.R)], -1
    )


def move_lengths(moved, strain, step):
    """Return the durations (m,) of the moves into which a run of n ticks is divided, in ticks.

    Parameters
    ----------
    moved : (n + 1,) float
        Length of the cutter's way at each tick, in m.
    strain : (n + 1,) float
        Acceleration at each tick as a share of its limit, at most 1.
    step : float
        Greatest length of a move, in m.

    Notes
    -----
    A move of N ticks has the mean slope of the run over them. Between moves of N and M ticks the
    slope changes by the sum of the run's changes, weighted from 1 at the place between the moves
    down to 1/N and 1/M at their far ends. So no change exceeds that of a tick at the limit if the
    strain is at most 1/N all along each move of N ticks.
    """
    longest = np.floor((1 + 1e-6) / np.maximum(strain, 1e-9)).astype(int)
    longest = np.maximum(longest, 1).tolist()
    reach = moved.tolist()
    step = step * (1 + 1e-9)
    ticks = []
    start = 0
    while start < len(reach) - 1:
        # A move ends where it gets too long, or at the number of ticks that its strain allows.
        most = min(longest[start], longest[start + 1])
        end = start + 1
        while end < len(reach) - 1 and reach[end + 1] - reach[start] <= step:
            most = min(most, longest[end + 1])
            if end + 1 - start > most:
                break
            end += 1
        ticks.append(end - start)
        start = end
    return np.array(ticks)


def move_ticks(distance, speed, acceleration, tick):
    """Return the ticks (n0, n1) of two means that make the fastest move from rest to rest.

    A step of the `distance` D, smoothed by means over n0 and n1 ticks one after the other, has the
    greatest speed D / n0 and the greatest `acceleration` D / (n0 n1). With n0 >= n1 this is the
    motion of three phases. Units are m and s, with a `tick` in s; the `speed` may be infinite. Both
    numbers are rounded up, which keeps the limits.
    """
    # If the speed isn't reached the first mean is as long as the second.
    n1 = min(speed / acceleration, sqrt(distance / acceleration))
    n0 = distance / (acceleration * n1)
    first, second = (max(ceil(n / tick * (1 - 1e-12)), 1) for n in (n0, n1))
    # Rounded up separately, the second could exceed the first.
    return [max(first, second), second]


def move_shares(ticks):
    """Return the share of the way, from 0 to 1, at each tick of a move by `move_ticks`."""
    speed = np.ones(1)
    for n in ticks:
        speed = np.convolve(speed, np.full(n, 1 / n))
    shares = np.concatenate([[0.0], np.cumsum(speed)])
    return shares / shares[-1]
