//! Intervals and quantiles. They are this project's own code, because they decide the verdicts.
//!
//! - Wilson's score interval (Wilson 1927, Journal of the American Statistical Association 22) for rates.
//! - The rule of three for rates with no observed event: 0 of n is at most 3/n with 95 % confidence.
//! - Sample quantiles of type 7 (Hyndman and Fan 1996, The American Statistician 50).
//! - A percentile bootstrap of a mean. The spread of resamples of n values is too small by the factor √((n - 1)/n), and is itself uncertain.
//!   Deviations are therefore multiplied by √(n/(n - 1)), and by Student's t over the normal quantile, as in the expanded percentile interval
//!   (Hesterberg 2015, The American Statistician 69, section 4.3). Ratios of totals over clusters and launches are in [`super::totals`].

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Resamples of a bootstrap: enough that each end of a 95 % interval has 50 resamples beyond it.
pub const RESAMPLES: usize = 2000;

/// The 97.5 % quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// An estimate with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Formats as `1.014 [0.990, 1.039]`; without an interval, the estimate and the reason.
impl std::fmt::Display for Interval {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.low.is_nan() || self.high.is_nan() {
            return write!(f, "{:.3} (no interval)", self.value);
        }
        write!(f, "{:.3} [{:.3}, {:.3}]", self.value, self.low, self.high)
    }
}

impl Interval {
    /// An estimate without spread, because it is counted, not sampled.
    pub const fn exact(value: f64) -> Self {
        Self { value, low: value, high: value }
    }

    /// Applies an increasing function to the estimate and to both ends.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { value: f(self.value), low: f(self.low), high: f(self.high) }
    }

    /// The interval of the reciprocal; all numbers must be positive.
    pub fn reciprocal(self) -> Self {
        Self { value: 1.0 / self.value, low: 1.0 / self.high, high: 1.0 / self.low }
    }

    /// Whether the whole interval lies in `[low, high]`.
    pub fn is_within(&self, low: f64, high: f64) -> bool {
        low <= self.low && self.high <= high
    }
}

/// Wilson's 95 % interval for a rate `p` in `n` trials; `n` need not be an integer.
fn wilson_of(p: f64, n: f64) -> (f64, f64) {
    let z2 = Z_95 * Z_95;
    let centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

/// The `q` quantile (0 to 1) of sorted numbers, interpolated linearly (type 7); NaN without numbers.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

/// The median of numbers in any order; NaN without numbers.
pub fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_unstable_by(f64::total_cmp);
    quantile(&numbers, 0.5)
}

/// The arithmetic mean; NaN without numbers.
pub fn mean(numbers: &[f64]) -> f64 {
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// The `q` quantile of weighted numbers, sorted by number: the smallest number at which the cumulated weight reaches `q` of the total; NaN
/// without numbers.
pub fn weighted_quantile(sorted: &[(f64, f64)], q: f64) -> f64 {
    let target = q * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut cumulated = 0.0;
    for &(value, weight) in sorted {
        cumulated += weight;
        if cumulated >= target {
            return value;
        }
    }
    sorted.last().map_or(f64::NAN, |&(value, _)| value)
}

/// Student's 97.5 % quantile for at least 1 degree of freedom. Up to ten, degrees are rounded down to an integer; what lacks less than 1e-9
/// of one is that integer. Above ten, the expansion about the normal quantile is used (Abramowitz and Stegun 1964, 26.7.5), correct there to
/// three digits.
fn t_95(freedom: f64) -> f64 {
    const FEW: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    let z = Z_95;
    match (freedom + 1e-9).floor() as usize {
        0 => FEW[0],
        n @ 1..=10 => FEW[n - 1],
        _ => {
            z + (z.powi(3) + z) / (4.0 * freedom)
                + (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom.powi(2))
        }
    }
}

/// Student's 97.5 % quantile; at infinitely many degrees of freedom, the quantile of the normal distribution.
pub fn student_95(freedom: f64) -> f64 {
    if freedom.is_finite() { t_95(freedom) } else { Z_95 }
}

/// Probability that Student's t, with at least 1 degree of freedom, is farther from 0 than `t`. With t = √ν tan θ its density is
/// proportional to cos^(ν-1) θ.
pub fn student_tails(t: f64, freedom: f64) -> f64 {
    /// Number of integration steps; must be even. The result is correct to five digits at all degrees of freedom that occur.
    const STEPS: usize = 2000;
    // Beyond this the normal distribution is as good, and the density is too narrow for the steps.
    let freedom = freedom.min(10_000.0);
    let integral = |from: f64, to: f64| {
        let width = (to - from) / STEPS as f64;
        let at = |i: usize| (from + width * i as f64).cos().max(0.0).powf(freedom - 1.0);
        let inner = (1..STEPS).map(|i| if i % 2 == 1 { 4.0 * at(i) } else { 2.0 * at(i) });
        (at(0) + inner.sum::<f64>() + at(STEPS)) * width / 3.0
    };
    // Nearly all of the density lies within some deviations of 0.
    let end = std::f64::consts::FRAC_PI_2.min(40.0 / freedom.sqrt());
    let start = (t.abs() / freedom.sqrt()).atan();
    if start >= end { 0.0 } else { (integral(start, end) / integral(0.0, end)).min(1.0) }
}

/// The 95 % interval of a rate over lines, each given as (missed, contacts). The variance of a ratio over clusters (Cochran 1977, section
/// 3.12) gives the number of independent contacts that the observed ones are worth, at most their own number n. It is multiplied by
/// (t(n - 1)/t(k - 1))² for k lines with contacts, because the variance of few lines is uncertain, and is at least one. The interval is
/// Wilson's for that number (Korn and Graubard 1998, Survey Methodology 24). With none missed, the upper end is at most 3/m, where m is
/// [`equal_lines`]; without lines the interval is [0, 1]. Lines that all miss the same share show no variance, and count as m contacts.
pub fn clustered_rate(lines: &[(u64, u64)]) -> (f64, f64) {
    let (missed, contacts) = lines.iter().fold((0, 0), |(m, n), (x, y)| (m + x, n + y));
    if contacts == 0 {
        return (0.0, 1.0);
    }
    let most = equal_lines(lines);
    if missed == 0 {
        return (0.0, (3.0 / most).min(1.0));
    }
    let rate = missed as f64 / contacts as f64;
    let is_even = |(m, n): &(u64, u64)| u128::from(*m) * u128::from(contacts) == u128::from(missed) * u128::from(*n);
    if lines.iter().all(is_even) {
        return wilson_of(rate, most);
    }
    let count = lines.iter().filter(|(_, contacts)| *contacts > 0).count() as f64;
    let squares: f64 = lines.iter().map(|(m, n)| (*m as f64 - rate * *n as f64).powi(2)).sum();
    let variance = squares * count / (count - 1.0) / (contacts as f64).powi(2);
    // Contacts of one line never say more than as many of different lines.
    let independent = (rate * (1.0 - rate) / variance).min(contacts as f64);
    let certainty = (student_95(contacts as f64 - 1.0) / student_95(count - 1.0)).powi(2);
    wilson_of(rate, (independent * certainty).max(1.0))
}

/// The number of lines of equal contacts that bound a rate as well as these do: (Σ contacts)² / Σ contacts² (Kish 1965, Survey Sampling,
/// section 11.7). Of a line with most of the contacts little is known but that line. 0 without contacts.
pub fn equal_lines(lines: &[(u64, u64)]) -> f64 {
    let (sum, squares) =
        lines.iter().map(|(_, n)| *n as f64).fold((0.0, 0.0), |(sum, squares), n| (sum + n, squares + n * n));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Factor on the deviations of resamples that corrects for few clusters, by their degrees of freedom: √(n/(n - 1)) for n clusters, because
/// drawing them from themselves loses spread, times Student's t over the normal quantile. NaN without degrees of freedom, because a single
/// cluster shows no spread.
pub(super) fn expansion(freedom: f64) -> f64 {
    if freedom > 0.0 { ((freedom + 1.0) / freedom).sqrt() * t_95(freedom) / Z_95 } else { f64::NAN }
}

/// Degrees of freedom of a sum over strata (Satterthwaite 1946, Biometrics 2), the factor on the deviations of its resamples, and its variance.
/// A stratum is given as the variance of its part of the sum and its number n of clusters, at least 2; drawing clusters from themselves makes
/// that variance too small by the factor (n - 1)/n. `None` without any variance.
pub(super) fn over_strata(strata: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64, f64)> {
    let (mut sum, mut squares, mut drawn) = (0.0, 0.0, 0.0);
    for (variance, count) in strata {
        sum += variance;
        squares += variance * variance / (count - 1.0);
        drawn += variance * (count - 1.0) / count;
    }
    (sum > 0.0).then(|| (sum * sum / squares, (sum / drawn).sqrt(), sum))
}

/// A random generator fixed by the run's seed and a purpose, so that its stream does not depend on other analyses.
pub(super) fn generator(seed: u64, purpose: &str) -> Pcg64 {
    let hash = blake3::Hasher::new().update(&seed.to_le_bytes()).update(purpose.as_bytes()).finalize();
    Pcg64::from_seed(*hash.as_bytes())
}

/// A random number below `n`. The bias of the multiplication is below n / 2^32, negligible beside the resampling error.
#[inline]
pub(super) fn below(generator: &mut Pcg64, n: usize) -> usize {
    ((u64::from(generator.next_u32()) * n as u64) >> 32) as usize
}

/// The mean of values, each a cluster of its own, with a percentile interval from [`RESAMPLES`] resamples, expanded for few values. A single
/// value has no interval: its ends are NaN. `purpose` names the use: the same purpose and number of values give the same draws.
pub fn bootstrap_mean(values: &[f64], seed: u64, purpose: &str) -> Interval {
    let value = mean(values);
    let mut generator = generator(seed, purpose);
    let deviation = |_| {
        // The draw of the only launch, which keeps the draws of committed intervals.
        below(&mut generator, 1);
        let drawn = values.iter().map(|_| values[below(&mut generator, values.len())]);
        drawn.sum::<f64>() / values.len() as f64 - value
    };
    let mut deviations: Vec<f64> = (0..RESAMPLES).map(deviation).collect();
    deviations.sort_unstable_by(f64::total_cmp);
    let end = |q: f64| value + quantile(&deviations, q) * expansion(values.len() as f64 - 1.0);
    Interval { value, low: end(0.025), high: end(0.975) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::tests::{close, normal};

    /// z² = 3.8415; for 1 of 10: centre (0.1 + 0.19207) / 1.38415 = 0.21102, half 1.95996 / 1.38415 × √(0.009 + 0.0096037)
    /// = 0.19314.
    #[test]
    fn wilson_by_hand() {
        let (low, high) = wilson_of(0.1, 10.0);
        close(low, 0.017_88, 2e-5);
        close(high, 0.404_15, 2e-5);
        // Symmetric about a half; 5 of 10 is 0.5 ± 1.95996 / 1.38415 × √(0.025 + 0.0096037) = 0.5 ± 0.26341.
        let (low, high) = wilson_of(0.5, 10.0);
        close(low, 0.236_59, 2e-5);
        close(high, 0.763_41, 2e-5);
    }

    #[test]
    fn rates_at_the_ends() {
        close(wilson_of(1.0, 10.0).1, 1.0, 1e-12);
        // 0 of 10 by Wilson: z² / (n + z²) = 3.84146 / 13.84146.
        close(wilson_of(0.0, 10.0).1, 0.277_53, 1e-5);
    }

    #[test]
    fn quantiles_by_hand() {
        // Type 7 of 1, 2, 4, 8: place 3q.
        let x = [1.0, 2.0, 4.0, 8.0];
        for (q, expected) in [(0.0, 1.0), (0.5, 3.0), (0.25, 1.75), (0.9, 6.8), (1.0, 8.0)] {
            close(quantile(&x, q), expected, 1e-12);
        }
        assert!(quantile(&[], 0.5).is_nan());
        let weighted = [(1.0, 1.0), (2.0, 1.0), (3.0, 2.0)];
        assert_eq!([0.25, 0.5, 0.51, 1.0].map(|q| weighted_quantile(&weighted, q)), [1.0, 2.0, 3.0, 3.0]);
    }

    /// The numbers 0, 1, ..., n-1: the mean's standard error under resampling is √((n² - 1) / 12 / n), and the percentile interval is close to
    /// the normal one.
    #[test]
    fn bootstrap_of_a_mean_has_the_textbook_width() {
        let n = 100.0_f64;
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let mean = bootstrap_mean(&values, 7, "test");
        let error = (n.powi(2) / 12.0 / n).sqrt();
        close(mean.value, 49.5, 1e-12);
        // The ends are quantiles of 2000 draws: √(0.025 × 0.975 / 2000) / φ(1.96) = 0.06 standard errors uncertain; t at 99 is 1.984.
        close(mean.low, 49.5 - Z_95 * error, 0.2 * error);
        close(mean.high, 49.5 + Z_95 * error, 0.2 * error);
        assert_eq!(bootstrap_mean(&[1.0; 3], 1, "test"), Interval::exact(1.0));
        let single = bootstrap_mean(&[1.0], 1, "test");
        assert!(single.value == 1.0 && single.low.is_nan() && single.high.is_nan(), "{single:?}");
    }

    /// Few values, as in a quick sweep. Over 400 samples with mean 0 the interval must miss 0 about twenty times; without expansion it misses 60
    /// to 90 times.
    #[test]
    fn intervals_of_few_values_hold_what_they_promise() {
        let mut normal = normal(5);
        for count in [4, 5, 12] {
            let mut misses = |sample: u64| {
                let values: Vec<f64> = (0..count).map(|_| normal()).collect();
                let mean = bootstrap_mean(&values, sample, "test");
                usize::from(mean.low > 0.0 || mean.high < 0.0)
            };
            let missed = (0..400).map(&mut misses).sum::<usize>();
            assert!((6..=44).contains(&missed), "{count} values: {missed} of 400");
        }
    }

    /// Few lines of thirty contacts, each missed at a rate of its own, a third in the mean: the intervals of about 20 of 400 samples must miss it.
    /// Without Student's factor 105 miss it at two lines, 59 at four and 33 at eight.
    #[test]
    fn rates_over_few_lines_hold_what_they_promise() {
        let mut noise = generator(5, "noise");
        let mut uniform = || f64::from(noise.next_u32()) / 4_294_967_296.0;
        for count in [2, 4, 8] {
            let mut is_off = |_: u32| {
                let mut line = |_: u32| {
                    let rate = uniform().powi(2);
                    ((0..30).filter(|_| uniform() < rate).count() as u64, 30)
                };
                let lines: Vec<(u64, u64)> = (0..count).map(&mut line).collect();
                let (low, high) = clustered_rate(&lines);
                usize::from(low > 1.0 / 3.0 || high < 1.0 / 3.0)
            };
            let missed = (0..400).map(&mut is_off).sum::<usize>();
            assert!(missed <= 40, "{count} lines: {missed} of 400");
        }
    }

    /// Two lines that miss nearly the same share say little more than two lines that miss the same. Taken for 200 independent contacts, they would
    /// give an interval of 0.14.
    #[test]
    fn two_lines_that_nearly_agree_show_little() {
        let (same, near) = (clustered_rate(&[(50, 100), (50, 100)]), clustered_rate(&[(50, 100), (51, 100)]));
        assert!(near.1 - near.0 > 0.8 * (same.1 - same.0), "{near:?} {same:?}");
    }

    /// Checks tails of Student's t against its table and against the normal distribution.
    #[test]
    fn tails_by_the_table() {
        for (t, freedom, tails) in
            [(12.706, 1.0, 0.05), (4.303, 2.0, 0.05), (3.365, 5.0, 0.02), (2.042, 30.0, 0.05), (1.96, 1e9, 0.05)]
        {
            close(student_tails(t, freedom), tails, 2e-4);
            close(student_tails(-t, freedom), tails, 2e-4);
        }
        close(student_tails(0.0, 3.0), 1.0, 1e-9);
        assert!(student_tails(100.0, 50.0) < 1e-6);
    }

    /// 100 lines of one contact and one of 100: (200)² / (100 + 100²) = 3.96 equal lines, not 101. The upper end is 3/3.96, not 3/101.
    #[test]
    fn a_line_with_half_of_the_contacts_is_one_line() {
        let lines = [vec![(0, 1); 100], vec![(0, 100)]].concat();
        close(equal_lines(&lines), 40_000.0 / 10_100.0, 1e-12);
        close(clustered_rate(&lines).1, 3.0 * 10_100.0 / 40_000.0, 1e-12);
        assert_eq!(equal_lines(&[(0, 7), (0, 0), (0, 7)]), 2.0);
        assert_eq!(equal_lines(&[]), 0.0);
    }

    /// Ten lines of ten contacts each, each missed completely or not at all, are ten observations, not a hundred. So are lines that all
    /// miss the same share, and lines that are all missed: nothing shows that their contacts are independent.
    #[test]
    fn a_line_that_is_missed_as_a_whole_is_one_observation() {
        let lines: Vec<(u64, u64)> = (0..10).map(|line| if line < 3 { (10, 10) } else { (0, 10) }).collect();
        let (low, high) = clustered_rate(&lines);
        // Over n - 1 lines instead of n the variance is a ninth more: nine lines' worth, times (1.984 / 2.262)².
        let (few, many) = (wilson_of(0.3, 6.925), wilson_of(0.3, 100.0));
        assert!((few.0 - low).abs() < 1e-3 && (few.1 - high).abs() < 1e-3, "{low} {high} {few:?}");
        assert!(high - low > 1.8 * (many.1 - many.0));
        let even: Vec<(u64, u64)> = vec![(3, 10); 10];
        assert_eq!(clustered_rate(&even), wilson_of(0.3, 10.0));
        let (low, high) = clustered_rate(&[(10, 10); 10]);
        close(low, wilson_of(1.0, 10.0).0, 1e-12);
        close(high, 1.0, 1e-12);
        assert_eq!(clustered_rate(&[(4, 8)]), wilson_of(0.5, 1.0));
        assert_eq!(clustered_rate(&vec![(0, 15); 3000]), (0.0, 0.001));
        assert_eq!(clustered_rate(&[]), (0.0, 1.0));
    }

    /// Values of t from Student's table; above ten degrees of freedom, from its expansion.
    #[test]
    fn t_by_the_table() {
        for (freedom, t) in
            [(1.0, 12.706), (3.9, 3.182), (10.0, 2.228), (15.0, 2.131), (30.0, 2.042), (120.0, 1.980), (1e9, 1.960)]
        {
            close(t_95(freedom), t, 1e-3);
        }
    }

    #[test]
    fn an_interval_that_is_not_known_is_not_printed_as_one() {
        assert_eq!(Interval { value: 1.0144, low: 0.99, high: 1.039 }.to_string(), "1.014 [0.990, 1.039]");
        assert_eq!(Interval { value: 1.0144, low: f64::NAN, high: f64::NAN }.to_string(), "1.014 (no interval)");
    }

    #[test]
    fn the_draws_depend_on_seed_and_purpose_only() {
        let values: Vec<f64> = (0..30).map(|i| f64::from(i * i)).collect();
        let run = |seed, purpose| bootstrap_mean(&values, seed, purpose);
        assert_eq!(run(1, "a"), run(1, "a"));
        assert_ne!(run(1, "a"), run(2, "a"));
        assert_ne!(run(1, "a"), run(1, "b"));
    }
}
