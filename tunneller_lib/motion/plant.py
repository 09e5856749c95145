"""The protocol of models of an axis, and the linear models, exact from tick to tick.

A further model is one class: a `LinearPlant` gives its ``matrices``, ``discrete`` and ``gain``, and
inherits the rest.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arguments import Angle, Finite, checked
from .quantities import Frequencies, Quantity, Tick

# Coefficients of the diagonal Pade quotient of the exponential of degree 13, which is right to
# rounding up to this norm of the matrix (Higham, SIAM J. Matrix Anal. Appl. 26, 2005).
PADE = [math.comb(13, j) * math.factorial(26 - j) / math.factorial(26) for j in range(14)]
PADE_REACH = 5.37


class NoLinearForm(ValueError):
    """Raised by a plant without a linear form, which closed forms and gain limits need."""


class Plant(ABC):
    """An axis from the valve's command to the joint angle; a further model is one subclass.

    `follow` runs any subclass that has the four abstract methods. Closed forms and stability also
    need the `linear` plant, margins and the exported controller the `hydraulics`.
    """

    @abstractmethod
    def command(self, rate, position):
        """Return the command of a steady rate in rad/s at a position in rad."""

    @abstractmethod
    def rest(self, position):
        """Return the state at rest, whose first number is the position in rad."""

    @abstractmethod
    def numbers(self, tick):
        """Return a named tuple of the numbers that a `tick` in s needs, with the stroke's ends."""

    @abstractmethod
    def functions(self):
        """Return the compilable functions that `ticks` calls, by name: "ticked", "commanding"."""

    def linear(self, angle):
        """Return the `LinearPlant` of small motions about a joint angle in rad.

        Raises
        ------
        NoLinearForm
            If the plant has none.
        """
        raise NoLinearForm(
            "plant: must have a linear form, which closed forms and gain limits need; "
            f"got {type(self).__name__}, which has none."
        )

    @property
    def hydraulics(self):
        """Return the sizes, a `Hydraulics`, or None for a plant without cylinders."""
        return None


class LinearTicks(NamedTuple):
    """A linear plant as numbers, from tick to tick.

    Parameters
    ----------
    low, high : float
        Ends of the stroke: infinite, since a linear plant has none.
    steady : float
        Speed for the full command 1, in rad/s.
    rows : tuple
        Row i holds the coefficients of the state and, last, of the command in number i of the next
        state.
    """

    low: float
    high: float
    steady: float
    rows: tuple


def tick_of_one(plant, state, u):
    """Return the state (1,) of a linear `plant` after a tick under a command u."""
    (a,) = plant.rows
    return (a[0] * state[0] + a[1] * u,)


def tick_of_two(plant, state, u):
    """Return the state (2,) of a linear `plant` after a tick under a command u."""
    a, b = plant.rows
    x, v = state
    return a[0] * x + a[1] * v + a[2] * u, b[0] * x + b[1] * v + b[2] * u


def tick_of_three(plant, state, u):
    """Return the state (3,) of a linear `plant` after a tick under a command u."""
    a, b, c = plant.rows
    x, v, w = state
    return (
        a[0] * x + a[1] * v + a[2] * w + a[3] * u,
        b[0] * x + b[1] * v + b[2] * w + b[3] * u,
        c[0] * x + c[1] * v + c[2] * w + c[3] * u,
    )


def tick_of_four(plant, state, u):
    """Return the state (4,) of a linear `plant` after a tick under a command u."""
    a, b, c, d = plant.rows
    x, v, w, y = state
    return (
        a[0] * x + a[1] * v + a[2] * w + a[3] * y + a[4] * u,
        b[0] * x + b[1] * v + b[2] * w + b[3] * y + b[4] * u,
        c[0] * x + c[1] * v + c[2] * w + c[3] * y + c[4] * u,
        d[0] * x + d[1] * v + d[2] * w + d[3] * y + d[4] * u,
    )


def command_at(plant, rate, position):
    """Return the command of a steady `rate` in rad/s of a linear `plant`, at any `position`."""
    return rate / plant.steady


TICKS = tick_of_one, tick_of_two, tick_of_three, tick_of_four


class LinearPlant(Plant):
    """A plant x' = A x + B u whose `gain` is its speed for the full command 1, in rad/s."""

    @abstractmethod
    def matrices(self):
        """Return A and B of state' = A state + B command; the state begins with the angle."""

    @abstractmethod
    def discrete(self, tick):
        """Return Ad and Bd of a command held for a tick, in s."""

    @checked
    def linear(self, angle: Angle):
        """Return the plant itself, at any joint angle."""
        return self

    def functions(self):
        """Return the functions that run a plant of this order."""
        return {"ticked": TICKS[len(self.matrices()[1]) - 1], "commanding": command_at}

    @property
    def lateness(self):
        """Return the time by which the rate lags behind the command in slow motion, in s.

        It is -G'(0)/G(0) for the transfer function G from the command to the rate.
        """
        # No rate depends on the angle, whose row and column are left out.
        A, B = self.matrices()
        held = np.linalg.solve(A[1:, 1:], B[1:])
        steady = B[0] - A[0, 1:] @ held
        return float(A[0, 1:] @ np.linalg.solve(A[1:, 1:], held) / steady)

    @checked
    def command(self, rate: Finite, position: Angle | None = None):
        """Return the command of a steady rate in rad/s, the same at every position in rad."""
        return rate / self._steady

    @property
    def _steady(self):
        return self.gain

    @checked
    def numbers(self, tick: Tick):
        """Return the `LinearTicks` of a tick in s."""
        Ad, Bd = self.discrete(tick)
        rows = tuple(map(tuple, np.column_stack([Ad, Bd]).tolist()))
        return LinearTicks(-math.inf, math.inf, self._steady, rows)

    @checked
    def rest(self, position: Angle):
        """Return the state at rest at a position, in rad."""
        return (position,) + (0.0,) * (len(self.matrices()[1]) - 1)

    @checked
    def response(self, frequency: Frequencies):
        """Return the complex angle per command (...), in rad, at frequencies in rad/s.

        Zero, where every plant has a pole, isn't among them; they are from 1e-50 to 1e50 rad/s.
        """
        A, B = self.matrices()
        s = 1j * frequency[..., None, None]
        column = np.broadcast_to(B[:, None], (*frequency.shape, len(B), 1)).astype(complex)
        return np.linalg.solve(s * np.eye(len(B)) - A, column)[..., 0, 0]


@dataclass(frozen=True)
@checked
class Integrator(LinearPlant):
    """T0: x' = K u, the first-order model of the paper's position loop.

    Parameters
    ----------
    gain : float
        K, in rad/s for the full command 1.

    Raises
    ------
    ValueError
        If the gain isn't a number from 1e-9 to 1e9.

    Examples
    --------
    >>> Integrator(0.5).discrete(0.01)[1]
    array([0.005])
    """

    gain: Quantity

    def matrices(self):
        """Return A and B of state' = A state + B command."""
        return np.zeros((1, 1)), np.array([self.gain])

    @checked
    def discrete(self, tick: Tick):
        """Return Ad and Bd of a command held for a tick, in s."""
        return np.eye(1), np.array([self.gain * tick])


@dataclass(frozen=True)
@checked
class Lag(LinearPlant):
    """T1: K / (s (lag s + 1)), a rate that follows the command by a first-order lag.

    Parameters
    ----------
    gain : float
        K, in rad/s for the full command 1.
    lag : float
        Time constant, in s.

    Raises
    ------
    ValueError
        If a number isn't from 1e-9 to 1e9.

    Examples
    --------
    >>> Lag(0.5, 0.02).discrete(0.01)[0].round(6)
    array([[1.      , 0.007869],
           [0.      , 0.606531]])
    """

    gain: Quantity
    lag: Quantity

    def matrices(self):
        """Return A and B of state' = A state + B command; the state is angle and rate."""
        return np.array([[0, 1], [0, -1 / self.lag]]), np.array([0, self.gain / self.lag])

    @checked
    def discrete(self, tick: Tick):
        """Return Ad and Bd of a command held for a tick, in s."""
        x = tick / self.lag
        fall = -np.expm1(-x)  # 1 - exp(-x) loses its digits for a tick far below the lag
        moved = _beyond(x)
        Ad = np.array([[1, self.lag * fall], [0, np.exp(-x)]])
        return Ad, self.gain * np.array([self.lag * moved, fall])


@dataclass(frozen=True)
@checked
class Resonance(LinearPlant):
    """K w^2 / (s (s^2 + 2 zeta w s + w^2)): small motions of a load on the oil's spring.

    Parameters
    ----------
    gain : float
        K, in rad/s for the full command 1.
    frequency : float
        Natural frequency w, in rad/s.
    damping : float
        Damping ratio zeta.

    Raises
    ------
    ValueError
        If a number isn't from 1e-9 to 1e9.
    """

    gain: Quantity
    frequency: Quantity
    damping: Quantity

    def matrices(self):
        """Return A and B of state' = A state + B command; the state is angle, rate, change."""
        w = self.frequency
        zeta = self.damping
        A = np.array([[0, 1, 0], [0, 0, 1], [0, -(w**2), -2 * zeta * w]])
        return A, np.array([0, 0, self.gain * w**2])

    @checked
    def discrete(self, tick: Tick):
        """Return Ad and Bd of a command held for a tick, in s."""
        w = self.frequency
        return _held(*self.matrices(), np.array([1.0, w, w**2]), tick)


@dataclass(frozen=True)
@checked
class ValveResonance(LinearPlant):
    """K w^2 / (s (lag s + 1) (s^2 + 2 zeta w s + w^2)): a resonance behind a lagging valve.

    Parameters
    ----------
    gain : float
        K of small swings, in rad/s for the full command 1.
    steady : float
        K of steady motion, by which the static inverse divides.
    frequency : float
        Natural frequency w, in rad/s.
    damping : float
        Damping ratio zeta.
    lag : float
        Time constant of the valve, in s.

    Raises
    ------
    ValueError
        If a number isn't from 1e-9 to 1e9.
    """

    gain: Quantity
    steady: Quantity
    frequency: Quantity
    damping: Quantity
    lag: Quantity

    @property
    def _steady(self):
        return self.steady

    def matrices(self):
        """Return A and B of state' = A state + B command; angle, rate, change, spool."""
        w = self.frequency
        zeta = self.damping
        A = np.diag([1.0, 1.0, self.gain * w**2], 1)
        A[2, 1:3] = -(w**2), -2 * zeta * w
        A[3, 3] = -1 / self.lag
        return A, np.array([0, 0, 0, 1 / self.lag])

    @checked
    def discrete(self, tick: Tick):
        """Return Ad and Bd of a command held for a tick, in s."""
        w = self.frequency
        return _held(*self.matrices(), np.array([1.0, w, w**2, w / self.gain]), tick)


def _held(A, B, units, tick):
    """Return Ad and Bd of a command held for a tick; `units` are typical sizes of the states.

    exp([[A, B], [0, 0]] T) = [[Ad, Bd], [0, 1]].
    """
    order = len(B)
    block = np.zeros((order + 1, order + 1))
    # In these units all states are of similar size; otherwise small entries would lose digits.
    block[:order, :order] = A / units[:, None] * units
    block[:order, order] = B / units
    # The command gets a unit as well: a high gain would raise the norm, and so the number of
    # squarings, each of which doubles the rounding errors of all entries.
    own = np.abs(block[:, :order]).sum(axis=0).max()
    driven = np.abs(block[:, order]).sum()
    command = math.ldexp(1.0, min(math.frexp(own / driven)[1], 0))
    block[:, order] *= command
    Ad = _exponential(block * tick)
    return Ad[:order, :order] * units[:, None] / units, Ad[:order, order] * units / command


def _exponential(matrix):
    """Return the exponential of a small matrix by scaling, a Pade quotient and squaring.

    scipy's `expm` does the same, but takes a third of a second to load, and up to ten milliseconds
    for five rows if its threads wait for busy cores.
    """
    norm = np.abs(matrix).sum(axis=0).max()
    halvings = max(math.frexp(norm / PADE_REACH)[1], 0)
    half = np.ldexp(matrix, -halvings)
    square = half @ half
    one = np.eye(len(matrix))
    odd = PADE[-1] * one
    even = PADE[-2] * one
    for low, high in zip(PADE[-4::-2], PADE[-3::-2], strict=True):
        even = even @ square + low * one
        odd = odd @ square + high * one
    odd = half @ odd
    power = np.linalg.solve(even - odd, even + odd)
    for _ in range(halvings):
        power = power @ power
    return power


def _beyond(x):
    """Return x - 1 + exp(-x) for x > 0."""
    # Below 1/2 by the series x^2/2 - x^3/6 + .., since the difference cancels: at x = 1e-8 it would
    # keep no digit.
    if x > 0.5:
        return x + np.expm1(-x)
    term = total = x * x / 2
    for k in range(3, 20):
        term *= -x / k
        total += term
    return total
