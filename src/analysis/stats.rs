//! Intervals and quantiles. They are this project's own code, because they decide the verdicts.
//!
//! - Wilson's score interval (Wilson 1927, Journal of the American Statistical Association 22) for rates.
//! - The rule of three for rates with no observed event: 0 of n is at most 3/n with 95 % confidence.
//! - Sample quantiles of type 7 (Hyndman and Fan 1996, The American Statistician 50).
//! - A percentile bootstrap of a mean over cells that are crossed by launch and cluster (Owen 2007, Annals of Applied Statistics 1, the
//!   "pigeonhole" bootstrap). The clusters are the same poses in every launch, so a resample draws the clusters once for all its launches.
//!   Drawing them anew inside each launch would treat the same poses as fresh evidence and make the interval too narrow.
//! - Few clusters: the spread of resamples of n clusters is too small by the factor √((n - 1)/n), and is itself uncertain. Each resample's
//!   deviation is therefore multiplied by √(n/(n - 1)), and the interval by Student's t over the normal quantile, as in the expanded
//!   percentile interval (Hesterberg 2015, The American Statistician 69, section 4.3). Over several groups the degrees of freedom are the
//!   number of clusters minus the number of groups, as is usual for stratified samples (Korn and Graubard 1999, Analysis of Health Surveys,
//!   section 2.4).
//! - A group with a single cluster shows no spread. If there is one, the mean of each group counts as one cluster of a single group, which
//!   includes the differences between groups in the spread ("collapsed strata", Cochran 1977, Sampling Techniques, section 5A.12).

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

/// Wilson's 95 % interval for a rate of `successes` in `trials`; [0, 1] without trials.
pub fn wilson(successes: u64, trials: u64) -> (f64, f64) {
    if trials == 0 {
        return (0.0, 1.0);
    }
    let (low, high) = wilson_of(successes as f64 / trials as f64, trials as f64);
    // At the ends the formula gives 0 and 1 up to rounding; say so exactly.
    (if successes == 0 { 0.0 } else { low }, if successes == trials { 1.0 } else { high })
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

/// Student's 97.5 % quantile for at least 1 degree of freedom. Up to ten, degrees are rounded down to an integer. Above ten, the expansion
/// about the normal quantile is used (Abramowitz and Stegun 1964, 26.7.5), correct there to three digits.
fn t_95(freedom: f64) -> f64 {
    const FEW: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
    let z = Z_95;
    match freedom.floor() as usize {
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
/// 3.12) gives the number of independent contacts that the observed ones are worth; the interval is Wilson's for that number (Korn and
/// Graubard 1998, Survey Methodology 24). With none missed, the upper end is at most 3/m, where m is [`equal_lines`]; without lines the interval is
/// [0, 1]. Lines that all miss the same share show no variance, and count as m contacts.
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
    wilson_of(rate, (rate * (1.0 - rate) / variance).min(contacts as f64).max(1.0))
}

/// The number of lines of equal contacts that bound a rate as well as these do: (Σ contacts)² / Σ contacts² (Kish 1965, Survey Sampling,
/// section 11.7). Of a line with most of the contacts little is known but that line. 0 without contacts.
pub fn equal_lines(lines: &[(u64, u64)]) -> f64 {
    let (sum, squares) =
        lines.iter().map(|(_, n)| *n as f64).fold((0.0, 0.0), |(sum, squares), n| (sum + n, squares + n * n));
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// Factor on the deviations of resamples that corrects for few clusters, by their degrees of freedom. 1 for zero degrees of freedom,
/// because then nothing was drawn.
pub(super) fn expansion(freedom: f64) -> f64 {
    if freedom > 0.0 { lengthening(freedom) * t_95(freedom) / Z_95 } else { 1.0 }
}

/// Factor that restores the spread lost by drawing n clusters from themselves: √(n/(n - 1)), for n - 1 degrees of freedom.
fn lengthening(freedom: f64) -> f64 {
    if freedom > 0.0 { ((freedom + 1.0) / freedom).sqrt() } else { 1.0 }
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

/// The observations of one stratum, added up in cells: clusters by launches.
#[derive(Clone, Debug, Default)]
pub struct Group {
    launches: usize,
    /// Sum and number of observations, at index `cluster * launches + launch`.
    cells: Vec<(f64, f64)>,
}

impl Group {
    /// A group of empty cells.
    pub fn new(launches: usize, clusters: usize) -> Self {
        Self { launches, cells: vec![(0.0, 0.0); launches * clusters] }
    }

    /// Adds an observation.
    pub fn add(&mut self, launch: usize, cluster: usize, value: f64) {
        let cell = &mut self.cells[cluster * self.launches + launch];
        cell.0 += value;
        cell.1 += 1.0;
    }

    /// Number of clusters.
    pub fn clusters(&self) -> usize {
        self.cells.len().checked_div(self.launches).unwrap_or(0)
    }

    /// Number of observations.
    pub fn observations(&self) -> u64 {
        self.cells.iter().map(|cell| cell.1).sum::<f64>() as u64
    }

    /// The mean of all observations; NaN without observations.
    pub fn mean(&self) -> f64 {
        let (sum, count) = self.cells.iter().fold((0.0, 0.0), |(s, n), cell| (s + cell.0, n + cell.1));
        sum / count
    }

    /// Degrees of freedom of the mean: the number of clusters minus one.
    fn freedom(&self) -> f64 {
        (self.clusters() as f64 - 1.0).max(0.0)
    }

    /// The mean of one resample, given how often each launch was drawn; NaN when only empty cells were drawn.
    fn resample(&self, generator: &mut Pcg64, multiplicity: &[f64]) -> f64 {
        let clusters = self.clusters();
        let (mut sum, mut count) = (0.0, 0.0);
        for _ in 0..clusters {
            let first = below(generator, clusters) * self.launches;
            for (cell, times) in self.cells[first..first + self.launches].iter().zip(multiplicity) {
                sum += times * cell.0;
                count += times * cell.1;
            }
        }
        sum / count
    }
}

/// The mean of each group and the mean of the groups' means (every group weighted equally), with percentile intervals from [`RESAMPLES`]
/// resamples of launches and clusters, expanded for few clusters. `purpose` names the use: the same purpose and shape give the same draws.
/// All groups must have `launches` launches and at least one cluster.
pub fn bootstrap(groups: &[Group], launches: usize, seed: u64, purpose: &str) -> (Vec<Interval>, Interval) {
    let (each, all) = resampled(groups, launches, seed, purpose);
    if groups.len() < 2 || groups.iter().all(|group| group.clusters() > 1) {
        return (each, all);
    }
    (each, resampled(&[collapsed(groups, launches)], launches, seed, purpose).1)
}

/// One group in which each of `groups` is a cluster, represented by its mean in each launch.
fn collapsed(groups: &[Group], launches: usize) -> Group {
    let mut one = Group::new(launches, groups.len());
    for (cluster, group) in groups.iter().enumerate() {
        for launch in 0..launches {
            let cells = group.cells.iter().skip(launch).step_by(launches);
            let (sum, count) = cells.fold((0.0, 0.0), |(sum, count), cell| (sum + cell.0, count + cell.1));
            if count > 0.0 {
                one.add(launch, cluster, sum / count);
            }
        }
    }
    one
}

/// The result of [`bootstrap`] when every group has at least two clusters.
fn resampled(groups: &[Group], launches: usize, seed: u64, purpose: &str) -> (Vec<Interval>, Interval) {
    let freedoms: Vec<f64> = groups.iter().map(Group::freedom).collect();
    let means: Vec<f64> = groups.iter().map(Group::mean).collect();
    let mut generator = generator(seed, purpose);
    let mut draws: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); groups.len() + 1];
    let mut multiplicity = vec![0.0; launches];
    for _ in 0..RESAMPLES {
        multiplicity.fill(0.0);
        for _ in 0..launches {
            multiplicity[below(&mut generator, launches)] += 1.0;
        }
        let mut total = 0.0;
        for ((group, draws), (mean, freedom)) in groups.iter().zip(&mut draws).zip(means.iter().zip(&freedoms)) {
            let mean = mean + (group.resample(&mut generator, &multiplicity) - mean) * lengthening(*freedom);
            total += mean;
            draws.push(mean);
        }
        draws[groups.len()].push(total / groups.len() as f64);
    }
    let interval = |value: f64, freedom: f64, draws: &mut Vec<f64>| {
        draws.retain(|mean| mean.is_finite());
        draws.sort_unstable_by(f64::total_cmp);
        // A single cluster shows what differs between launches, and nothing else.
        let wider = if freedom > 0.0 { t_95(freedom) / Z_95 } else { 1.0 };
        let expanded = |end: f64| value + (end - value) * wider;
        Interval { value, low: expanded(quantile(draws, 0.025)), high: expanded(quantile(draws, 0.975)) }
    };
    let all = means.iter().sum::<f64>() / groups.len() as f64;
    let freedom = freedoms.iter().sum();
    let all = interval(all, freedom, &mut draws[groups.len()]);
    let each =
        means.iter().zip(&freedoms).zip(&mut draws).map(|((mean, freedom), draws)| interval(*mean, *freedom, draws));
    (each.collect(), all)
}

/// The mean of values, each a cluster of its own, with a percentile interval: [`bootstrap`] over one group in one launch.
pub fn bootstrap_mean(values: &[f64], seed: u64, purpose: &str) -> Interval {
    let mut group = Group::new(1, values.len());
    values.iter().enumerate().for_each(|(i, value)| group.add(0, i, *value));
    bootstrap(&[group], 1, seed, purpose).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} is not {b}");
    }

    /// z² = 3.8415; for 1 of 10: centre (0.1 + 0.19207) / 1.38415 = 0.21102, half 1.95996 / 1.38415 × √(0.009 + 0.0096037)
    /// = 0.19314.
    #[test]
    fn wilson_by_hand() {
        let (low, high) = wilson(1, 10);
        close(low, 0.017_88, 2e-5);
        close(high, 0.404_15, 2e-5);
        // Symmetric about a half; 5 of 10 is 0.5 ± 1.95996 / 1.38415 × √(0.025 + 0.0096037) = 0.5 ± 0.26341.
        let (low, high) = wilson(5, 10);
        close(low, 0.236_59, 2e-5);
        close(high, 0.763_41, 2e-5);
    }

    #[test]
    fn rates_at_the_ends() {
        assert_eq!(wilson(0, 0), (0.0, 1.0));
        assert_eq!(wilson(10, 10).1, 1.0);
        // 0 of 10 by Wilson: z² / (n + z²) = 3.84146 / 13.84146.
        close(wilson(0, 10).1, 0.277_53, 1e-5);
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

    /// One launch, clusters 0, 1, ..., n-1: the mean's standard error under resampling is √((n² - 1) / 12 / n), and the
    /// percentile interval is close to the normal one.
    #[test]
    fn bootstrap_of_a_mean_has_the_textbook_width() {
        let n = 100;
        let mut group = Group::new(1, n);
        (0..n).for_each(|i| group.add(0, i, i as f64));
        let (each, all) = bootstrap(&[group], 1, 7, "test");
        let error = ((n as f64).powi(2) / 12.0 / n as f64).sqrt();
        close(all.value, 49.5, 1e-12);
        // The ends are quantiles of 2000 draws: √(0.025 × 0.975 / 2000) / φ(1.96) = 0.06 standard errors uncertain; t at 99 is 1.984.
        close(all.low, 49.5 - Z_95 * error, 0.2 * error);
        close(all.high, 49.5 + Z_95 * error, 0.2 * error);
        assert_eq!(each[0].value, all.value);
    }

    /// Strata of two and three chunks, as in a quick run, with unequal spreads. Over 400 samples with mean 0 the interval must miss 0 about
    /// twenty times; unequal spreads add some ten. Without expansion it misses 60 to 90 times.
    #[test]
    fn intervals_of_few_clusters_hold_what_they_promise() {
        let mut noise = generator(5, "noise");
        // Twelve uniform numbers less six: near enough to normal.
        let mut normal = || (0..12).map(|_| f64::from(noise.next_u32()) / 4_294_967_296.0).sum::<f64>() - 6.0;
        let missed = |sizes: &[usize], normal: &mut dyn FnMut() -> f64| {
            let misses = |sample: u64| {
                let groups: Vec<Group> = sizes
                    .iter()
                    .zip(1..)
                    .map(|(&clusters, scale)| {
                        let mut group = Group::new(1, clusters);
                        (0..clusters).for_each(|c| group.add(0, c, f64::from(scale) * normal()));
                        group
                    })
                    .collect();
                let (_, all) = bootstrap(&groups, 1, sample, "test");
                usize::from(all.low > 0.0 || all.high < 0.0)
            };
            (0..400).map(misses).sum::<usize>()
        };
        for sizes in [&[2, 3, 3, 3][..], &[5], &[1, 1, 1, 1], &[12, 12]] {
            let missed = missed(sizes, &mut normal);
            assert!((6..=44).contains(&missed), "{sizes:?}: {missed} of 400");
        }
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
        let (few, many) = (wilson(3, 10), wilson(30, 100));
        // Over n - 1 lines instead of n the variance is a ninth more: nine lines' worth.
        assert!((few.0 - low).abs() < 0.02 && (few.1 - high).abs() < 0.02, "{low} {high} {few:?}");
        assert!(high - low > 1.8 * (many.1 - many.0));
        let even: Vec<(u64, u64)> = vec![(3, 10); 10];
        assert_eq!(clustered_rate(&even), wilson(3, 10));
        let (low, high) = clustered_rate(&[(10, 10); 10]);
        close(low, wilson(10, 10).0, 1e-12);
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

    /// A stratum of one cluster has no spread, so the means of the strata are used as clusters.
    #[test]
    fn groups_of_one_cluster_are_clusters_of_one_group() {
        let groups = [1.0, 2.0, 3.0, 4.0].map(|value| {
            let mut group = Group::new(1, 1);
            group.add(0, 0, value);
            group
        });
        let (each, all) = bootstrap(&groups, 1, 1, "test");
        assert_eq!(each[0], Interval::exact(1.0));
        assert_eq!(all.value, 2.5);
        // t at 3 times the standard error √(5/3/4) is 2.05; the percentiles of four values are a little coarser.
        close(all.high - 2.5, 2.05, 0.5);
        close(2.5 - all.low, 2.05, 0.5);
    }

    /// More launches of the same clusters are no new evidence about other clusters, so the interval must not shrink. (Drawing the clusters
    /// anew in each launch would halve it here.)
    #[test]
    fn launches_do_not_multiply_the_clusters() {
        let width = |launches: usize| {
            let mut group = Group::new(launches, 50);
            (0..50).for_each(|c| (0..launches).for_each(|l| group.add(l, c, c as f64)));
            let (_, all) = bootstrap(&[group], launches, 1, "test");
            all.high - all.low
        };
        close(width(4) / width(1), 1.0, 0.1);
    }

    /// Differences between launches must widen the interval even when clusters agree.
    #[test]
    fn launches_are_resampled() {
        let mut group = Group::new(2, 50);
        (0..50).for_each(|c| (0..2).for_each(|l| group.add(l, c, l as f64)));
        let (_, all) = bootstrap(&[group], 2, 1, "test");
        // Student's t at 49 degrees is 1.0253 times the normal quantile; deviations of fifty clusters are lengthened by 1.0102.
        assert_eq!(all.value, 0.5);
        close(all.low, 0.5 - 0.5 * 1.0357, 1e-3);
        close(all.high, 0.5 + 0.5 * 1.0357, 1e-3);
    }

    #[test]
    fn groups_weigh_the_same_whatever_their_size() {
        let (mut small, mut large) = (Group::new(1, 2), Group::new(1, 200));
        (0..2).for_each(|c| small.add(0, c, 1.0));
        (0..200).for_each(|c| large.add(0, c, 3.0));
        let (each, all) = bootstrap(&[small, large], 1, 1, "test");
        assert_eq!(each.iter().map(|i| i.value).collect::<Vec<_>>(), [1.0, 3.0]);
        assert_eq!(all, Interval::exact(2.0));
    }

    #[test]
    fn an_interval_that_is_not_known_is_not_printed_as_one() {
        assert_eq!(Interval { value: 1.0144, low: 0.99, high: 1.039 }.to_string(), "1.014 [0.990, 1.039]");
        assert_eq!(Interval { value: 1.0144, low: f64::NAN, high: f64::NAN }.to_string(), "1.014 (no interval)");
    }

    #[test]
    fn the_draws_depend_on_seed_and_purpose_only() {
        let mut group = Group::new(1, 30);
        (0..30).for_each(|c| group.add(0, c, (c * c) as f64));
        let run = |seed, purpose| bootstrap(&[group.clone()], 1, seed, purpose).1;
        assert_eq!(run(1, "a"), run(1, "a"));
        assert_ne!(run(1, "a"), run(2, "a"));
        assert_ne!(run(1, "a"), run(1, "b"));
    }
}
