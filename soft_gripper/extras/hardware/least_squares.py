"""Solves the least-squares problems of all fits to recordings: a `Problem` -> the `Fit` that solves it.

Over a vector x of P unknowns, a fit minimises the sum of (w_i r_i(x))^2 of R residuals r with weights w. If outliers
are expected, a residual beyond f counts less than by its square, as  2 f^2 (sqrt(1 + (r / f)^2) - 1) ; where such a
search ends, ordinary least squares with the weights  (1 + (r / f)^2)^(-1/4)  end, too. With the slopes J of the
residuals there, what the fit would be without some of them follows to the first order, without another search.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import require

M = TypeVar("M")  # model that the unknowns describe


class Progress(NamedTuple, Generic[M]):
    """State of a search after a step."""

    step: int
    error: float  # see `Problem`
    model: M
    missing: int = 0  # residuals that cannot be computed, which do not count in the error


Report = Callable[[Progress[Any]], None]


def no_report(progress: Progress[Any]) -> None:
    """Reports nothing."""


@dataclass(frozen=True)
class Problem(Generic[M]):
    """A problem of R residuals and P unknowns."""

    build_model: Callable[[Array], M]  # from a vector
    residuals: Callable[[Array], Array]  # (P,) -> (R,); NaN: cannot be computed
    slopes: Callable[[Array, Array], Array] | None = None  # vector, residuals there -> (R, P); None: by differences
    weights: Array | float = 1.0  # (R,)
    outlier: float | None = None  # residual beyond which one counts less; None: all count by their squares
    missing: float = 0.0  # counts for a residual that cannot be computed
    bounds: tuple[ArrayLike, ArrayLike] = (-np.inf, np.inf)
    error: Callable[[Array], float] | None = None  # figure of merit of residuals; above 1: no fit
    options: Mapping[str, Any] = field(default_factory=dict)  # of scipy's search


@dataclass(frozen=True)
class Fit(Generic[M]):
    """The result of a search."""

    build_model: Callable[[Array], M]  # from a vector, see `Problem`
    x: Array  # (P,)
    residuals: Array  # (R,) without their weights
    slopes: Array  # (R, P) without their weights
    weights: Array  # (R,) with which ordinary least squares have the same minimum
    cost: float  # half of what was minimised
    error: float  # see `Problem`; NaN: none
    converged: bool

    @property
    def model(self) -> M:
        """The fitted model."""
        return self.build_model(self.x)

    @property
    def covariance(self) -> Array:
        """Covariance of the unknowns, (P, P), of independent weighted residuals of variance 1."""
        slopes = self.weights[:, None] * self.slopes
        return np.linalg.inv(slopes.T @ slopes)

    def change_without(
        self, kept: NDArray[np.bool_], unobservable: float | None = None, scales: Array | float = 1.0
    ) -> Array:
        """First-order change of the unknowns, (P,), if only the residuals of a mask count, (R,), a prior's included.

        Unknowns stay that change these residuals less than a share `unobservable` of the strongest change, compared by
        `scales`, typical changes of the unknowns; None: rounding.
        """
        slopes = self.weights[:, None] * self.slopes * scales
        residuals = self.weights * self.residuals
        unknown_change: Array = np.linalg.lstsq(slopes[kept], -residuals[kept], rcond=unobservable)[0]
        return scales * unknown_change

    def profile(self, count: int) -> "Fit[M]":
        """The fit of the first unknowns, which the others follow: their best values are taken out of the slopes."""
        slopes = self.weights[:, None] * self.slopes
        first_slopes, other_slopes = slopes[:, :count], slopes[:, count:]
        first_slopes = first_slopes - other_slopes @ np.linalg.lstsq(other_slopes, first_slopes, rcond=None)[0]
        return replace(self, x=self.x[:count], slopes=first_slopes / self.weights[:, None])


def fit(problem: Problem[M], starts: ArrayLike, report: Report = no_report) -> Fit[M]:
    """Fit of least cost among those from the starts, (K, P), that come near the measurements; an InputError: none."""
    fits = list[Fit[M]]()
    for start in np.atleast_2d(starts):
        try:
            fits.append(_search(problem, start, report))
        except InputError as error:
            last_error = error
    if not fits:
        raise last_error
    return min(fits, key=lambda solution: solution.cost)


def _search(problem: Problem[M], start: Array, report: Report) -> Fit[M]:
    weights, last_values, step = np.asarray(problem.weights), dict[str, Array](), 0

    def residuals(x: Array) -> Array:
        last_values["residuals"] = problem.residuals(x)
        return weights * np.nan_to_num(last_values["residuals"], nan=problem.missing)

    def slopes(x: Array) -> Array:
        """Weighted slopes; the search asks for them at the point of its last residuals."""
        nonlocal step
        assert problem.slopes is not None
        step += 1
        if problem.error is not None:
            error, missing = problem.error(last_values["residuals"]), int(np.isnan(last_values["residuals"]).sum())
            with suppress(InputError):  # a step of the search may lead to an impossible model
                report(Progress(step, error, problem.build_model(x), missing))
        last_values["slopes"] = problem.slopes(x, last_values["residuals"])
        return weights[..., None] * last_values["slopes"]

    solution = optimize.least_squares(
        residuals,
        np.clip(start, *problem.bounds),
        "2-point" if problem.slopes is None else slopes,
        bounds=problem.bounds,
        loss="linear" if problem.outlier is None else "soft_l1",
        f_scale=problem.outlier or 1.0,
        **problem.options,
    )
    misfits: Array = solution.fun / weights
    error = np.nan if problem.error is None else problem.error(misfits)
    expected = "no fit comes near the measurements: start closer, or free fewer keys"
    is_near = not error > 1 and bool(np.isfinite(solution.cost))
    require(is_near, "identify", "residual", f"{100 * error:.3g} %", expected)
    ratio = 0.0 if problem.outlier is None else misfits / problem.outlier
    equal_weights = np.broadcast_to(weights * (1 + ratio**2) ** -0.25, misfits.shape)
    jacobian = last_values.get("slopes", solution.jac / weights[..., None])
    model, cost, converged = problem.build_model, float(solution.cost), bool(solution.success)
    return Fit(model, solution.x, misfits, jacobian, equal_weights, cost, error, converged)
