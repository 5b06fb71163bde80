"""Standard deviations of what a fit found, and the combinations of numbers that the data do not determine.

With ψ the derivative of the loss, J the Jacobian over the noise, N residuals and m unknowns, the covariance of an M-estimate is

    (Σ ψ²/(N − m)) / (mean ψ')² · τ (Jᵀ J)⁻¹

τ is 1 for residuals that are independent. If the residuals correlate from sample to sample, as those of a model that lacks something
do, N samples tell no more than N/τ: τ = 1 + 2 Σ |ρ_k|, ρ_k the correlation of ψ k samples apart. Its sign does not count, as what a
vibration leaves meets a Jacobian that vibrates too. If residuals are not noise, large ones are no outliers: ψ is then the residual."""

import numpy as np

from .solve import FAILED, LEAST_NOISE, LOSS, NARROW, STEEPEST, until_steep
from .varied import NOT_ZERO

UNLIKELY, LAGS = 4.0, 10  # deviations: a correlation within them counts as none; samples apart
NOT_TOLD = 0.5  # a direction whose deviation is above it, in sizes: of a number its value, or if that is less its scale. A number may be 0
SMALL = 0.1  # a part of a direction that is left out
WIDTH, STEEP = 3e-6, 500.0  # of the differences of a Jacobian whose largest entry is STEEP, rad. A steeper one, of a chaotic motion,
# has narrower ones
ROUNDED = (np.finfo(float).eps / LEAST_NOISE) ** 2  # the square of a residual that is rounded: without any, none could be divided by
DOUBT = 3.0  # a singular value below so many errors of the Jacobian is none


def correlation(series, lag):
    """The correlation of values so many samples apart, in a list of arrays; 0 if noise may have as much."""
    series = [values - values.mean() for values in series if len(values) > 20]
    power = sum(np.sum(values ** 2) for values in series)
    if power == 0:
        return 0.0
    found = sum(np.sum(values[lag:] * values[:-lag]) for values in series) / power
    return found if abs(found) > UNLIKELY / np.sqrt(sum(map(len, series))) else 0.0


def correlation_time(series):
    """τ, from a list of arrays: one for each recording and joint."""
    tau = 1.0
    for lag in range(1, max(map(len, series), default=0) // 2):
        tau += 2 * abs(correlation(series, lag))
        if lag > 5 * tau:  # Sokal's window
            break
    return tau


def are_noise(series):
    """True if the signs and sizes of residuals over the noise are independent of those of the next ones; outliers may stand alone."""
    sizes = [np.log1p(abs(values)) for values in series]
    signed = [np.copysign(size, values) for size, values in zip(sizes, series)]
    return not any(correlation(one, lag) for one in (signed, sizes) for lag in range(1, LAGS))


class Deviations:
    """The deviations of a problem's solution. covariance: of all unknowns x. tau: as above. are_noise: if its residuals are. relative: those of
    each singular direction."""

    def __init__(self, problem, solution, samples, prior):
        self.problem, self.numbers = problem, problem.numbers
        rough = problem.jacobian(solution.x, samples, NARROW)
        samples = until_steep(problem, rough, samples)
        steepest = max(min(abs(rough).max(), STEEPEST), STEEP)
        joints = problem.joints_of(samples)
        weights = 1 / solution.noise[joints]
        residuals = np.nan_to_num(problem.residuals(solution.x, samples), nan=FAILED) * weights
        width = WIDTH * STEEP / steepest
        jacobian, other = (problem.jacobian(solution.x, samples, step) * weights[:, None] for step in (width, 2 * width))
        self.are_noise = are_noise(series_of(problem, residuals, samples))
        z = (residuals / LOSS) ** 2 if self.are_noise else np.zeros(len(residuals))  # what is systematic is no outlier
        slope = np.mean((1 + z) ** -1.5)
        free = max(len(residuals) - problem.size, 1)
        self.tau = correlation_time(series_of(problem, residuals / np.sqrt(1 + z), samples))
        self.spread = np.sqrt(max(np.sum(residuals ** 2 / (1 + z)), ROUNDED) / free) / slope * np.sqrt(self.tau)
        self.scales = np.array([number.scale for number in self.numbers])
        many = len(self.numbers)
        self.values = solution.x[:many] * self.scales
        self.sizes = np.maximum(abs(self.values), self.scales)
        self._jacobian = jacobian / self.spread
        self._find_directions(samples, (jacobian - other) / self.spread)
        information = self._jacobian.T @ self._jacobian
        information[range(many), range(many)] += 1 / prior ** 2
        size = 1 / np.sqrt(np.maximum(np.diag(information), NOT_ZERO))  # the inverse of a matrix with a diagonal of 1
        self.covariance = np.linalg.pinv(information * np.outer(size, size), hermitian=True) * np.outer(size, size)

    @property
    def deviations(self):
        """The standard deviations of the numbers, in their units."""
        return np.sqrt(np.maximum(np.diag(self.covariance)[:len(self.numbers)], 0)) * self.scales

    @property
    def open(self):
        """The paths of the numbers in the directions that are not seen."""
        return [number.path for number, size in zip(self.numbers, np.linalg.norm(self.lost, axis=0)) if size > SMALL]

    @property
    def correlations(self):
        many = len(self.numbers)
        covariance = self.covariance[:many, :many]
        size = np.sqrt(np.maximum(np.diag(covariance), NOT_ZERO))
        return covariance / np.outer(size, size)

    def most_correlated(self):
        """The indices of the two numbers that hang together most. None if there is one alone."""
        correlations = abs(np.triu(self.correlations, 1))
        return None if len(self.numbers) < 2 else np.unravel_index(correlations.argmax(), correlations.shape)

    def _find_directions(self, samples, doubt):
        """Singular directions of the numbers' relative changes, when the unknowns of each recording are free. doubt: an error of the
        Jacobian. A direction that lies within it is not seen: what the Jacobian has of it is taken out."""
        many = len(self.numbers)
        sizes = self.sizes / self.scales
        self._find_own(samples, doubt)
        left = []
        for rows, _, basis, _ in self._own:
            seen = self._jacobian[rows, :many] * sizes
            left.append(np.linalg.qr(seen - basis @ (basis.T @ seen), mode="r"))
        _, singular, directions = np.linalg.svd(np.vstack(left))
        self.singular = np.concatenate([singular, np.zeros(many - len(singular))])
        with np.errstate(divide="ignore"):
            self.relative = 1 / self.singular
        within = []
        for value, direction in zip(self.singular, directions):
            change = self._whole(direction * sizes)
            within.append(value < DOUBT * np.linalg.norm(doubt @ change))
            if within[-1]:
                self._jacobian = self._jacobian - np.outer(self._jacobian @ change, change) / (change @ change)
        self.lost = directions[(self.relative > NOT_TOLD) | within]  # each row: relative changes that leave the data as they are

    def _find_own(self, samples, doubt):
        """For each recording: its rows, its own unknowns, the directions of residuals that these reach, and the inverse of their
        columns. A direction within the doubt is left out: a state that does not close a chain is closed before it moves."""
        self._own, edge = [], 0
        for r, mask in enumerate(self.problem.measured(samples)):
            rows, own = slice(edge, edge + mask.sum()), self.problem.own(r)
            edge = rows.stop
            basis, values, unknowns = np.linalg.svd(self._jacobian[rows, own], full_matrices=False)
            seen = values > DOUBT * np.linalg.norm(doubt[rows, own] @ unknowns.T, axis=0)
            self._own.append((rows, own, basis[:, seen], unknowns[seen].T / values[seen]))

    def _whole(self, numbers):
        """The change of all unknowns: of these numbers, and what of each recording's own best undoes it."""
        many = len(self.numbers)
        change = np.concatenate([numbers, np.zeros(self.problem.size - many)])
        for rows, own, basis, inverse in self._own:
            change[own] = -inverse @ (basis.T @ (self._jacobian[rows, :many] @ numbers))
        return change


def series_of(problem, residuals, samples):
    edge, series = 0, []
    for mask in problem.measured(samples):
        indices = np.nonzero(mask)[1]
        own = residuals[edge:edge + len(indices)]
        edge += len(indices)
        series += [own[indices == j] for j in range(mask.shape[1])]
    return series
