"""Ratios of totals with their intervals, as docs/methodology.md describes them under "Comparing two methods" and "The recipe"."""

import math
from dataclasses import dataclass, field

import numpy as np

RESAMPLES = 2000  # of the run
OURS = 10_000  # of this script: more, so that little of the difference is its own
Z = 1.959963984540054
FEW_T = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228]


def student(freedom):
    """Student's 97.5 % quantile as the recipe has it."""
    whole = math.floor(freedom + 1e-9)
    if whole <= 10:
        return FEW_T[max(whole, 1) - 1]
    if math.isinf(freedom):
        return Z
    return Z + (Z**3 + Z) / (4 * freedom) + (5 * Z**5 + 16 * Z**3 + 3 * Z) / (96 * freedom**2)


def student_tails(t, freedom):
    """Probability of a larger |t|: the density by Simpson's rule in the angle arctan(t / sqrt(freedom))."""
    freedom = min(freedom, 10_000.0)

    def integral(start, end, steps=20_000):
        weights = np.ones(steps + 1)
        weights[1:-1:2], weights[2:-1:2] = 4, 2
        angles = np.linspace(start, end, steps + 1)
        return float(np.sum(weights * np.clip(np.cos(angles), 0, None) ** (freedom - 1))) * (end - start) / steps / 3

    end = min(math.pi / 2, 40 / math.sqrt(freedom))
    start = math.atan(abs(t) / math.sqrt(freedom))
    return 0.0 if start >= end else min(1.0, integral(start, end) / integral(0, end))


@dataclass
class Ratio:
    """A ratio of totals; `deviations` are the logarithms of resamples over it, lengthened but not yet widened by Student's quantile."""

    value: float
    clusters: int
    freedom: float = 0.0
    wider: float = 1.0
    deviations: np.ndarray = field(default=None, repr=False)
    ends: tuple = None  # where the interval follows from a formula
    error: float = math.nan

    def p(self, threshold):
        """Probability of a ratio as far from the threshold, and by how much the resamples leave it open, relative to the error."""
        distance = math.log(self.value / threshold)
        if self.freedom < 1 or not math.isfinite(distance):
            return 1.0
        return float(distance == 0) if self.error == 0 else student_tails(distance / self.error, self.freedom)

    def reciprocal(self):
        """The ratio the other way round."""
        ends = self.ends and (1 / self.ends[1], 1 / self.ends[0])
        deviations = None if self.deviations is None else -self.deviations
        return Ratio(1 / self.value, self.clusters, self.freedom, self.wider, deviations, ends, self.error)


def over_launches(above, below):
    """Totals of launches, with Student's interval of the logarithm of their ratio."""
    above, below = np.asarray(above, float), np.asarray(below, float)
    value, count = above.sum() / below.sum(), len(above)
    if count < 2:
        return Ratio(value, count, ends=(math.nan, math.nan))
    error = math.sqrt(np.log(above / below).var(ddof=1) / count)
    half = student(count - 1) * error
    return Ratio(value, count, count - 1, ends=(value * math.exp(-half), value * math.exp(half)), error=error)


def repeated(by_launch, binaries):
    """Totals by launch, the last axis, as means by what is repeated at the highest level: binaries where there are several."""
    if not binaries:
        return by_launch
    return np.stack([by_launch[..., launches].mean(axis=-1) for launches in binaries], axis=-1)


class Draws:
    """Resamples by shape: as many clusters in each stratum; of launches, or of several binaries with their launches, one fewer than there
    are. Equal shapes share their draws."""

    def __init__(self, seed):
        self.seed, self.known = seed, {}

    def of(self, shape, launches, binaries=()):
        key = (tuple(shape), launches, tuple(map(tuple, binaries)))
        if key not in self.known:
            generator = np.random.default_rng([self.seed, launches, *shape])
            drawn = generator.multinomial(max(len(binaries) - 1, 1), [1 / len(binaries)] * len(binaries), size=OURS)
            launch = np.zeros((OURS, launches))
            for place, of_binary in enumerate(binaries):
                launch[:, of_binary] = drawn[:, [place]]
            cluster = [generator.multinomial(size, [1 / size] * size, size=OURS) for size in shape]
            self.known[key] = (launch, np.concatenate(cluster, axis=1).astype(float))
        return self.known[key]


def ratio(drawn_in, cluster, above, below, draws, binaries=()):
    """The ratio of totals of items, each with what it is drawn in, its cluster, and numerator and denominator by launch, NaN where it was not
    observed; draws are None where only the point is wanted. None of nothing."""
    seen = ~np.isnan(above).all(axis=1)
    if not seen.any():
        return None
    drawn_in, cluster, above, below = drawn_in[seen], cluster[seen], above[seen], below[seen]
    keys, at = np.unique(np.stack([drawn_in, cluster]), axis=1, return_inverse=True)
    count, launches = keys.shape[1], above.shape[1]
    if count < len(above):
        (above, below), items = [np.nan_to_num(totals) for totals in (above, below)], ~np.isnan(above)
        sums = [np.zeros((count, launches)) for _ in range(3)]
        for total, of in zip(sums, (above, below, items)):
            np.add.at(total, at.ravel(), of)
        above, below, seen = sums
    else:
        order = np.argsort(at.ravel())
        seen = ~np.isnan(above[order])
        above, below = (np.nan_to_num(totals[order]) for totals in (above, below))
    seen = (seen > 0).astype(float)
    shape = np.unique(keys[0], return_counts=True)[1].tolist()
    if min(shape) < 2:
        shape = [count]
    mean = [totals.sum(axis=1) / seen.sum(axis=1) for totals in (above, below)]
    value = mean[0].sum() / mean[1].sum()
    found = Ratio(value, count)
    if draws is None or not math.isfinite(value):
        return found
    found.freedom, lengthening, variance = satterthwaite(mean[0] - value * mean[1], shape)
    ran = np.flatnonzero(seen.any(axis=0)).tolist()
    binaries = [launches_of for launches_of in ([launch for launch in of if launch in ran] for of in binaries) if launches_of]
    # Launches of a single binary are what is repeated.
    binaries = binaries if len(binaries) > 1 else [[launch] for launch in ran]
    if len(binaries) > 1:
        variance /= mean[0].sum() ** 2
        logs = []
        for launches_of in binaries:
            weight = seen[:, launches_of].sum(axis=1)
            weight = np.divide(1.0, weight, out=np.zeros_like(weight), where=weight > 0)
            logs.append(math.log((above[:, launches_of].sum(axis=1) * weight).sum() / (below[:, launches_of].sum(axis=1) * weight).sum()))
        between = float(np.var(logs, ddof=1)) / len(logs)
        if variance + between > 0:
            squares = between**2 / (len(logs) - 1) + (variance**2 / found.freedom if variance > 0 else 0.0)
            found.freedom = (variance + between) ** 2 / squares
    found.wider = student(found.freedom) / Z if found.freedom > 0 else 1.0
    launch, cluster = draws.of(shape, launches, binaries)
    if seen.all():
        n = (cluster @ above * launch).sum(axis=1)
        d = (cluster @ below * launch).sum(axis=1)
    else:
        times = launch @ seen.T  # drawn launches in which the cluster was observed
        weight = np.divide(cluster, times, out=np.zeros_like(cluster), where=times > 0)
        n, d = (weight * (launch @ above.T)).sum(axis=1), (weight * (launch @ below.T)).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        deviations = np.log(n / d / value) * lengthening
    found.deviations = np.sort(deviations[np.isfinite(deviations)])
    found.error = math.sqrt(np.mean(found.deviations**2)) if len(found.deviations) else math.nan
    return found


def satterthwaite(errors, shape):
    """Degrees of freedom, what lengthens the deviations, and the variance of the sum, by the variances of the strata's sums of numerator - ratio x denominator."""
    total = squares = drawn = 0.0
    start = 0
    for size in shape:
        here = errors[start : start + size]
        start += size
        if size < 2:
            continue
        variance = size * here.var(ddof=1)
        total += variance
        squares += variance**2 / (size - 1)
        drawn += variance * (size - 1) / size
    if total > 0:
        return total**2 / squares, math.sqrt(total / drawn), total
    return float(len(errors) - len(shape)), 1.0, 0.0


def strictness(ends):
    """Standard errors that an end may be off: 4, or so many that one study in a thousand with as many ends is called wrong by chance."""
    low, high, wanted = 4.0, 12.0, 1e-3 / max(ends, 1)
    while high - low > 1e-6:
        middle = (low + high) / 2
        low, high = (middle, high) if math.erfc(middle / math.sqrt(2)) > wanted else (low, middle)
    return high


def distance(found, quantile, end):
    """How many standard errors of the bootstrap's quantiles the run's end is from ours. The share of our resamples beyond it is compared
    with the quantile; square roots' arcsines, since the variance of a small share depends on it."""
    deviations = found.deviations
    if not math.isfinite(end) or end <= 0:
        return math.inf
    deviation = math.log(end / found.value) / found.wider
    slack = 1e-9 * max(1.0, abs(deviation))
    low = np.searchsorted(deviations, deviation - slack, "left") / len(deviations)
    high = np.searchsorted(deviations, deviation + slack, "right") / len(deviations)
    share = min(max(quantile, low), high)
    error = 0.5 * math.sqrt(1 / RESAMPLES + 1 / len(deviations))
    return abs(math.asin(math.sqrt(share)) - math.asin(math.sqrt(quantile))) / error


def wilson(rate, count):
    """Wilson's 95 % interval of a rate in `count` trials, which need not be whole."""
    z2 = Z * Z
    centre = (rate + z2 / (2 * count)) / (1 + z2 / count)
    half = Z / (1 + z2 / count) * math.sqrt(rate * (1 - rate) / count + z2 / (4 * count * count))
    return max(0.0, centre - half), min(1.0, centre + half)


def rate_by_line(missed, contacts):
    """The 95 % interval of a rate over lines."""
    missed, contacts = np.asarray(missed, float), np.asarray(contacts, float)
    lines, n = len(contacts), contacts.sum()
    if n == 0:
        return 0.0, 1.0
    most = n**2 / (contacts**2).sum()  # lines of equal contacts that say as much
    if missed.sum() == 0:
        return 0.0, min(1.0, 3 / most)
    rate = missed.sum() / n
    if (missed * n == missed.sum() * contacts).all():
        return wilson(rate, most)
    variance = ((missed - rate * contacts) ** 2).sum() * lines / (lines - 1) / n**2
    independent = min(rate * (1 - rate) / variance, n)
    return wilson(rate, max(1.0, independent * (student(n - 1) / student(lines - 1)) ** 2))


def type7(values, quantile):
    """The quantile that is interpolated linearly."""
    return float(np.quantile(np.asarray(values, float), quantile))


def weighted(values, weights, quantile):
    """The smallest value at which the cumulated weight reaches the quantile."""
    order = np.argsort(values, kind="stable")
    cumulated = np.cumsum(np.asarray(weights, float)[order])
    place = np.searchsorted(cumulated, quantile * cumulated[-1] * (1 - 1e-12))
    return float(np.asarray(values, float)[order][min(place, len(order) - 1)])
