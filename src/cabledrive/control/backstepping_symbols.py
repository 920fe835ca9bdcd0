r"""Backstepping on a row of inertias by symbols: every virtual control, derivative and regressor.

A row of n inertias, counted here from the load, is a chain of 2n states that is scaled so that each one is
the rate of the one before it and the virtual controls have gain one:

.. math::
    x_1 = q_1, \quad x_{2j+1} = S_j(q_{j+1} - q_j), \quad x_{2j+2} = \dot x_{2j+1}, \qquad
    S_j = S_{j-1}\frac{k_j}{J_j}, \quad S_0 = 1

Virtual controls are linear in states and signals, so that each of their derivatives has a name of its own and
the next step is derived in those names. Nothing grows: the law of six states has 72 lines. Needs SymPy.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Rate of an even state, without the virtual control.

    Attributes
    ----------
    linear : dict
        Coefficient of each estimate: what it multiplies, its sign included.
    virtual : Symbol
        Estimate that multiplies the virtual control.
    """

    linear: dict[Any, Any]
    virtual: Any


@dataclass(frozen=True)
class Backstepping:
    """Symbols and recursion of the law of a row of inertias.

    Attributes
    ----------
    inertias : int
    known : bool
        Whether each inertia has an acceleration that is known along the reference, with derivatives: that of
        the dampers.
    printed : bool
        Whether the regressor of a virtual control's gain takes the virtual control, as (6.77) does when
        mended, or the state.
    """

    inertias: int
    known: bool
    printed: bool

    @cached_property
    def x(self) -> tuple[Any, ...]:
        """Scaled states."""
        return self._symbols("x", 2 * self.inertias)

    @cached_property
    def p(self) -> tuple[Any, ...]:
        """Estimates: 2 of the load, 2 or 3 of an inertia between, 5 or 6 of the motor."""
        n = self.inertias
        return self._symbols("p", 7 if n == 2 else 3 * n + 1)

    @cached_property
    def scales(self) -> tuple[Any, ...]:
        """S_1 to S_(n-1)."""
        return self._symbols("s", self.inertias - 1)

    @cached_property
    def time(self) -> dict[Any, Any]:
        """Every signal of time that is known, with its derivative."""
        n = self.inertias
        pairs: dict[Any, Any] = {}
        chains = [self._named(f"y{m}" for m in range(2 * n + 1))]
        if self.known:
            chains += [self._named(f"w{j}_{m}" for m in range(2 * (n - j) + 1)) for j in range(1, n + 1)]
        for chain in chains:
            pairs |= dict(zip(chain, (*chain[1:], None), strict=True))
        return pairs

    @cached_property
    def gains(self) -> dict[tuple[int, int], Any]:
        """Feedback gains by the step and the error: its own, that of the step before; one more at the end."""
        last = 2 * self.inertias
        wanted = [(i, j) for i in range(1, last + 1) for j in (i - 1, i) if j >= 1]
        wanted.insert(-2, (last, last - 2))
        return {pair: self._named([f"k{pair[0]}{pair[1]}"])[0] for pair in wanted}

    @cached_property
    def rows(self) -> dict[int, Row]:
        """Rates of the even states, from (6.69) on: load, inertias between, motor."""
        n, x, p = self.inertias, self.x, list(self.p)
        speed, friction = self._named(["speed", "friction"])
        found = {2: Row(virtual=p[0], linear={p[1]: 1})}
        at = 2
        for j in range(2, n + 1):
            linear: dict[Any, Any] = {}
            virtual = None
            if j < n:
                virtual, at = p[at], at + 1
            linear[p[at]], at = -x[2 * j - 2], at + 1
            if j >= 3:
                linear[p[at]], at = x[2 * j - 4], at + 1
            if j == 2 and n > 2:
                linear[p[1]] = -self.scales[0]
            if j == n:
                linear |= {p[at]: -speed, p[at + 1]: -friction, p[at + 2]: 1}
                virtual, at = p[at + 3], at + 4
            found[2 * j] = Row(virtual=virtual, linear=linear)
        return found

    def rest(self, i: int) -> Any:
        """Estimated rate of state i without its virtual control.

        Parameters
        ----------
        i : int
            From 1.

        Returns
        -------
        Expr
        """
        if i % 2:
            return 0
        row = self.rows[i]
        value = sum(p * factor for p, factor in row.linear.items())
        return value + (self._named([f"w{i // 2}_0"])[0] if self.known else 0)

    def control_gain(self, i: int) -> Any:
        """What multiplies the virtual control of step i.

        Parameters
        ----------
        i : int

        Returns
        -------
        Expr
        """
        if i % 2:
            return 1
        gain = self.rows[i].virtual
        return gain * self.scales[-1] if i == 2 * self.inertias else gain

    def rate(self, i: int) -> Any:
        """Estimated rate of state i below the last.

        Parameters
        ----------
        i : int

        Returns
        -------
        Expr
        """
        return self.control_gain(i) * self.x[i] + self.rest(i)

    def steps(self) -> Iterator[tuple[str, Any]]:
        """Every line of the law in order, for four states Eqs. (6.71), (6.76), (6.82) and (6.90) mended.

        Yields
        ------
        name : str
        value : Expr
        """
        import sympy as sp

        last, x = 2 * self.inertias, self.x
        variables = (*x, *self.time)
        errors: list[Any] = []  # z_i in states and signals, its coefficients named: to be differentiated
        alpha, slopes = self._named(["y0"])[0], {self._named(["y0"])[0]: sp.Integer(1)}
        for i in range(1, last + 1):
            yield f"z{i}", x[i - 1] - (alpha if i == 1 else sp.Symbol(f"alpha{i - 1}"))
            errors.append(x[i - 1] - sum(c * v for v, c in slopes.items()))
            along = sum(
                c * (self.time[v] if v in self.time else self.rate(x.index(v) + 1)) for v, c in slopes.items()
            )
            feedback = [(self.gains[i, j], j) for j in range(1, i + 1) if (i, j) in self.gains]
            wanted = along - self.rest(i)
            shown = (wanted - sum(k * sp.Symbol(f"z{j}") for k, j in feedback)) / self.control_gain(i)
            if i == last:
                yield "u", shown
                return
            yield f"alpha{i}", shown
            exact = (wanted - sum(k * errors[j - 1] for k, j in feedback)) / self.control_gain(i)
            slopes = {}
            for v in variables:
                slope = sp.diff(exact, v)
                if slope != 0:
                    slopes[v] = sp.Symbol(f"a{i}_{v}")
                    yield f"a{i}_{v}", slope

    def adaptation(self) -> Iterator[tuple[str, Any]]:
        """Weights of the even states, then the adaptation function, Eq. (6.95).

        Yields
        ------
        name : str
        value : Expr
        """
        last, z = 2 * self.inertias, self._named(f"z{i}" for i in range(1, 2 * self.inertias + 1))
        for i in range(2, last, 2):
            slopes = self._named(f"a{j - 1}_x{i}" for j in range(i + 1, last + 1))
            yield f"cross{i}", sum(a * z_j for a, z_j in zip(slopes, z[i:], strict=True))
        for m, p in enumerate(self.p):
            yield f"tau[{m}]", sum(self._own(i, p) * z[i - 1] - self._through(i, p) for i in self.rows)

    def regressors(self) -> Iterator[tuple[str, Any]]:
        """Each regressor phi_i of (6.77), (6.83) and (6.91) that is not zero.

        Yields
        ------
        name : str
        value : Expr
        """
        for i in range(2, 2 * self.inertias + 1):
            for m, p in enumerate(self.p):
                value = self._own(i, p)
                for j in range(2, i, 2):
                    value -= self._named([f"a{i - 1}_x{j}"])[0] * self._state(j, p)
                if value != 0:
                    yield f"phi[{i - 1}][{m}]", value

    def _state(self, i: int, p: Any) -> Any:
        """What the true value of an estimate multiplies in the rate of state i."""
        row = self.rows[i]
        if p != row.virtual:
            return row.linear.get(p, 0)
        return self.x[i] if i < 2 * self.inertias else self.scales[-1] * self._named(["u"])[0]

    def _own(self, i: int, p: Any) -> Any:
        """The same in the rate of error i, as far as state i brings it in."""
        if i % 2:
            return 0
        if self.printed and p == self.rows[i].virtual and i < 2 * self.inertias:
            return self._named([f"alpha{i}"])[0]
        return self._state(i, p)

    def _through(self, i: int, p: Any) -> Any:
        """The part of tau that comes through the virtual controls' dependence on state i."""
        return self._state(i, p) * self._named([f"cross{i}"])[0] if i < 2 * self.inertias else 0

    def _symbols(self, letter: str, count: int) -> tuple[Any, ...]:
        return self._named(f"{letter}{i}" for i in range(1, count + 1))

    @staticmethod
    def _named(names: Iterable[str]) -> tuple[Any, ...]:
        import sympy as sp

        return tuple(sp.Symbol(name) for name in names)
