//! Ratios of totals with their uncertainty: the one estimator of protocol 2. A mean time is the total time divided by the number of poses.
//! Two methods are compared by the ratio of their totals over the same items.
//!
//! - Poses: a percentile bootstrap that draws clusters of poses within each stratum and draws launches for all clusters together (Owen
//!   2007, Annals of Applied Statistics 1). A cluster is drawn with all its observations, and counts in all drawn launches, because its
//!   poses are the same in each.
//! - Few clusters: deviations are multiplied by √(n/(n - 1)) in a stratum of n clusters, and by Student's t over the normal quantile (the
//!   expanded percentile interval: Hesterberg 2015, The American Statistician 69, section 4.3). The degrees of freedom of the strata are
//!   combined by Satterthwaite (1946, Biometrics 2). If a stratum has a single cluster, all strata are merged into one, which includes the
//!   differences between strata in the spread.
//! - Launches: a resample draws one launch fewer than there are, which gives the variance of their mean without bias (Rao and Wu 1988,
//!   Journal of the American Statistical Association 83). The degrees of freedom of the launches are combined with those of the clusters.
//! - Several binaries: binaries, each with all its launches, take the place of launches. The spread of the binaries includes the differences
//!   between binaries and between launches; drawing launches again would count these twice (Davison and Hinkley 1997, Bootstrap Methods and
//!   their Application, section 3.8).
//! - Whole programs: their poses are not a sample, so only launches vary. The interval is Student's for the logarithm over launches, or
//!   over the means of binaries if there are several (Kalibera and Jones 2013, ISMM, section 9: repeat at the highest level). A single
//!   launch gives no interval.

use super::grouped;
use super::stats::{Interval, RESAMPLES, below, generator, over_strata, quantile, student_95, student_tails};
use rand_pcg::Pcg64;
use std::collections::{BTreeMap, BTreeSet};

/// A ratio of totals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The ratio with its 95 % interval.
    pub interval: Interval,
    /// Standard error of its logarithm.
    pub error: f64,
    /// Degrees of freedom of that error; 0 when they are unknown.
    pub freedom: f64,
    /// Number of resampled units: clusters of poses, launches, binaries or blocks.
    pub clusters: u64,
}

impl Estimate {
    /// A ratio that is counted without sampling.
    pub const fn exact(value: f64) -> Self {
        Self { interval: Interval::exact(value), error: 0.0, freedom: f64::INFINITY, clusters: 0 }
    }

    /// The estimate of the reciprocal.
    pub fn reciprocal(self) -> Self {
        Self { interval: self.interval.reciprocal(), ..self }
    }

    /// Two-sided p-value: probability of a ratio at least as far from `threshold` if the true ratio were `threshold`.
    pub fn p_value(&self, threshold: f64) -> f64 {
        let distance = (self.interval.value / threshold).ln();
        match self.freedom {
            _ if !distance.is_finite() || self.freedom < 1.0 => 1.0,
            _ if self.error == 0.0 => f64::from(u8::from(distance == 0.0)),
            freedom => student_tails(distance / self.error, freedom),
        }
    }
}

/// Numerators and denominators, by stratum, cluster and launch.
#[derive(Clone, Debug)]
pub struct Totals {
    launches: usize,
    strata: Vec<Vec<Cluster>>,
    /// What is repeated: the launches of each binary, or each launch alone when all ran one binary.
    repeats: Vec<Vec<usize>>,
}

/// The binary of each launch, indexed by the number of the launch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Binaries(Vec<Option<u32>>);

impl Binaries {
    /// Records that a launch ran a binary; `false` when it is already recorded with another binary.
    pub fn note(&mut self, launch: u32, binary: u32) -> bool {
        let launch = launch as usize;
        if self.0.len() <= launch {
            self.0.resize(launch + 1, None);
        }
        *self.0[launch].get_or_insert(binary) == binary
    }

    /// The launches of each binary that occurs, in the order of the binaries' numbers.
    pub fn launches(&self) -> Vec<Vec<usize>> {
        let known = self.0.iter().enumerate().filter_map(|(launch, binary)| Some(((*binary)?, launch)));
        grouped(known).into_values().collect()
    }

    /// The binary that a launch ran; 0 for an unknown launch.
    pub fn of(&self, launch: u32) -> u32 {
        self.0.get(launch as usize).copied().flatten().unwrap_or(0)
    }

    /// Adds up observations, each of a launch, by the highest repeated level: by binary, or by launch when there is a single binary.
    pub fn added_up(&self, observations: impl Iterator<Item = (u32, f64, f64)>) -> Vec<(f64, f64)> {
        let mut by_launch: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
        let mut by_binary = by_launch.clone();
        for (launch, numerator, denominator) in observations {
            for (sums, key) in [(&mut by_launch, launch), (&mut by_binary, self.of(launch))] {
                let (n, d) = sums.entry(key).or_default();
                (*n, *d) = (*n + numerator, *d + denominator);
            }
        }
        let repeated = if by_binary.len() > 1 { by_binary } else { by_launch };
        repeated.into_values().collect()
    }

    /// The mean of pairs of numbers at the highest repeated level: of each binary, or of each launch when there is a single binary.
    pub fn repeated(&self, by_launch: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let binaries = self.launches();
        if binaries.len() < 2 {
            return by_launch.to_vec();
        }
        let sum = |launches: &Vec<usize>| {
            let known = launches.iter().filter_map(|&launch| by_launch.get(launch));
            let (n, d) = known.fold((0.0, 0.0), |(n, d), (x, y)| (n + x, d + y));
            (n / launches.len() as f64, d / launches.len() as f64)
        };
        binaries.iter().map(sum).collect()
    }
}

/// Numerator and denominator of a cluster in each launch; `None` where it was not observed.
type Cluster = Vec<Option<(f64, f64)>>;

/// The cluster of each chunk, from the chunk and the line of every pose: chunks that share a line, directly or through others, have the smallest
/// of their numbers.
pub(super) fn clusters<L: Ord>(poses: impl IntoIterator<Item = (u32, L)>) -> BTreeMap<u32, u32> {
    let mut of_line: BTreeMap<L, BTreeSet<u32>> = BTreeMap::new();
    for (chunk, line) in poses {
        of_line.entry(line).or_default().insert(chunk);
    }
    let mut clusters: BTreeMap<u32, u32> = of_line.values().flatten().map(|&chunk| (chunk, chunk)).collect();
    loop {
        let mut changed = false;
        for chunks in of_line.values() {
            let least = chunks.iter().map(|chunk| clusters[chunk]).min().expect("a line has a pose");
            for &chunk in chunks {
                changed |= clusters.insert(chunk, least) != Some(least);
            }
        }
        if !changed {
            return clusters;
        }
    }
}

/// One observation of a ratio's numerator and denominator.
#[derive(Clone, Copy, Debug)]
pub struct Observation {
    /// Number of the stratum; strata are resampled separately.
    pub stratum: u32,
    /// Number of the cluster; its observations are drawn together.
    pub cluster: u32,
    /// Launch.
    pub launch: u32,
    /// Amount added to the numerator.
    pub numerator: f64,
    /// Amount added to the denominator.
    pub denominator: f64,
}

impl Totals {
    /// Adds up observations; `None` without observations.
    pub fn of(observations: impl IntoIterator<Item = Observation>) -> Option<Self> {
        let mut sorted: Vec<Observation> = observations.into_iter().collect();
        sorted.sort_by_key(|o| (o.stratum, o.cluster, o.launch));
        let launches = sorted.iter().map(|o| o.launch as usize + 1).max()?;
        let mut strata: Vec<Vec<Cluster>> = Vec::new();
        let mut last = None;
        for Observation { stratum, cluster, launch, numerator, denominator } in sorted {
            if last.is_none_or(|(s, _)| s != stratum) {
                strata.push(Vec::new());
            }
            let clusters = strata.last_mut().expect("one was pushed");
            if last != Some((stratum, cluster)) {
                clusters.push(vec![None; launches]);
            }
            last = Some((stratum, cluster));
            let cell = &mut clusters.last_mut().expect("one was pushed")[launch as usize];
            let (n, d) = cell.unwrap_or((0.0, 0.0));
            *cell = Some((n + numerator, d + denominator));
        }
        if strata.iter().any(|clusters| clusters.len() < 2) {
            strata = vec![strata.concat()];
        }
        let is_seen = |launch: &usize| strata.iter().flatten().any(|cluster| cluster[*launch].is_some());
        let repeats = (0..launches).filter(is_seen).map(|launch| vec![launch]).collect();
        Some(Self { launches, strata, repeats })
    }

    /// The same totals, with launches that ran several binaries.
    pub fn of_binaries(mut self, binaries: &Binaries) -> Self {
        let seen: Vec<usize> = self.repeats.concat();
        let known = |launches: Vec<usize>| launches.into_iter().filter(|launch| seen.contains(launch)).collect();
        let binaries: Vec<Vec<usize>> = binaries.launches().into_iter().map(known).collect();
        let binaries: Vec<Vec<usize>> = binaries.into_iter().filter(|launches| !launches.is_empty()).collect();
        if binaries.len() > 1 {
            self.repeats = binaries;
        }
        self
    }

    /// Number of clusters.
    pub fn clusters(&self) -> usize {
        self.strata.iter().map(Vec::len).sum()
    }

    /// Number of repetitions: binaries, or launches of a single one.
    pub fn repeats(&self) -> usize {
        self.repeats.len()
    }

    /// The ratio of the totals; every cluster counts with its mean over the launches in which it was observed.
    pub fn ratio(&self) -> f64 {
        self.ratio_of(&vec![1.0; self.launches])
    }

    /// The ratio of the totals with weighted launches.
    fn ratio_of(&self, weights: &[f64]) -> f64 {
        let (n, d) = self.sums(weights);
        n / d
    }

    fn sums(&self, weights: &[f64]) -> (f64, f64) {
        let all = self.strata.iter().flatten().filter_map(|cluster| mean(cluster, weights));
        all.fold((0.0, 0.0), |(n, d), (x, y)| (n + x, d + y))
    }

    /// Variance of the mean over binaries, or launches, of the logarithm of the ratio; 0 for a single one.
    fn variance_of_repeats(&self) -> f64 {
        let logs: Vec<f64> = self
            .repeats
            .iter()
            .map(|launches| {
                let mut weights = vec![0.0; self.launches];
                launches.iter().for_each(|&launch| weights[launch] = 1.0);
                self.ratio_of(&weights).ln()
            })
            .collect();
        let count = logs.len() as f64;
        if logs.len() < 2 {
            return 0.0;
        }
        let middle = logs.iter().sum::<f64>() / count;
        logs.iter().map(|log| (log - middle).powi(2)).sum::<f64>() / (count - 1.0) / count
    }

    /// Degrees of freedom of the ratio `r` from clusters and binaries, or launches, together, and the factor on the deviations of resamples.
    fn freedom(&self, r: f64) -> (f64, f64) {
        let (of_clusters, lengthening, variance) = self.freedom_of_clusters(r);
        let of_repeats = self.variance_of_repeats();
        if self.repeats.len() < 2 || of_repeats.is_nan() || of_repeats + variance == 0.0 {
            return (of_clusters, lengthening);
        }
        let squares = if variance > 0.0 { variance * variance / of_clusters } else { 0.0 };
        let squares = squares + of_repeats * of_repeats / (self.repeats.len() as f64 - 1.0);
        ((variance + of_repeats).powi(2) / squares, lengthening)
    }

    /// For the ratio `r`: its degrees of freedom, the factor on the deviations of resamples, and the variance of its logarithm. All follow
    /// from the variances of numerator - r · denominator in each stratum.
    fn freedom_of_clusters(&self, r: f64) -> (f64, f64, f64) {
        let weights = vec![1.0; self.launches];
        let of_stratum = |stratum: &Vec<Cluster>| {
            let errors = stratum.iter().filter_map(|cluster| mean(cluster, &weights)).map(|(n, d)| n - r * d);
            let errors: Vec<f64> = errors.collect();
            let count = errors.len() as f64;
            let middle = errors.iter().sum::<f64>() / count;
            (errors.iter().map(|e| (e - middle).powi(2)).sum::<f64>() * count / (count - 1.0), count)
        };
        let strata = self.strata.iter().filter(|stratum| stratum.len() > 1).map(of_stratum);
        if let Some((freedom, lengthening, variance)) = over_strata(strata) {
            let (n, _) = self.sums(&weights);
            return (freedom, lengthening, variance / (n * n));
        }
        // No spread at all: as many as there are.
        ((self.clusters() - self.strata.len()) as f64, 1.0, 0.0)
    }

    /// Draws launches, or binaries with their launches: one fewer than there are.
    fn draw_launches(&self, generator: &mut Pcg64, weights: &mut [f64]) {
        weights.fill(0.0);
        for _ in 0..(self.repeats.len() - 1).max(1) {
            let drawn = &self.repeats[below(generator, self.repeats.len())];
            drawn.iter().for_each(|&launch| weights[launch] += 1.0);
        }
    }

    /// The ratio with its uncertainty. `purpose` names the use: the same purpose and shape give the same draws.
    pub fn estimate(&self, seed: u64, purpose: &str) -> Estimate {
        let value = self.ratio();
        let clusters = self.clusters();
        let (freedom, lengthening) = self.freedom(value);
        let mut generator = generator(seed, purpose);
        let mut weights = vec![0.0; self.launches];
        let mut deviations = Vec::with_capacity(RESAMPLES);
        for _ in 0..RESAMPLES {
            self.draw_launches(&mut generator, &mut weights);
            let (mut n, mut d) = (0.0, 0.0);
            for stratum in &self.strata {
                for _ in 0..stratum.len() {
                    if let Some((x, y)) = mean(&stratum[below(&mut generator, stratum.len())], &weights) {
                        (n, d) = (n + x, d + y);
                    }
                }
            }
            let deviation = (n / d / value).ln() * lengthening;
            if deviation.is_finite() {
                deviations.push(deviation);
            }
        }
        deviations.sort_unstable_by(f64::total_cmp);
        let error = (deviations.iter().map(|x| x * x).sum::<f64>() / deviations.len().max(1) as f64).sqrt();
        // A single cluster shows what differs between launches, and nothing else.
        let wider = if freedom > 0.0 { student_95(freedom) / student_95(f64::INFINITY) } else { 1.0 };
        let end = |q: f64| {
            let deviation = quantile(&deviations, q);
            if deviation.is_finite() { value * (wider * deviation).exp() } else { value }
        };
        let interval = Interval { value, low: end(0.025), high: end(0.975) };
        Estimate { interval, error, freedom, clusters: clusters as u64 }
    }
}

/// Weighted mean of a cluster over the launches in which it was observed; `None` when it was observed in none.
fn mean(cluster: &Cluster, weights: &[f64]) -> Option<(f64, f64)> {
    let (mut n, mut d, mut total) = (0.0, 0.0, 0.0);
    for (cell, weight) in cluster.iter().zip(weights) {
        if let Some((x, y)) = cell {
            (n, d, total) = (n + weight * x, d + weight * y, total + weight);
        }
    }
    (total > 0.0).then(|| (n / total, d / total))
}

/// The ratio of the totals of launches, each (numerator, denominator), with Student's interval of the logarithm over launches. `None`
/// without launches.
pub fn over_launches(launches: &[(f64, f64)]) -> Option<Estimate> {
    let (n, d) = launches.iter().fold((0.0, 0.0), |(n, d), (x, y)| (n + x, d + y));
    let value = n / d;
    let count = launches.len() as f64;
    if launches.is_empty() || !value.is_finite() {
        return None;
    }
    let logs: Vec<f64> = launches.iter().map(|(x, y)| (x / y).ln()).collect();
    let mean = logs.iter().sum::<f64>() / count;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0) / count;
    let (freedom, error) = if launches.len() > 1 { (count - 1.0, variance.sqrt()) } else { (0.0, f64::NAN) };
    let half = if freedom > 0.0 { student_95(freedom) * error } else { f64::NAN };
    let interval = Interval { value, low: value * (-half).exp(), high: value * half.exp() };
    Some(Estimate { interval, error, freedom, clusters: launches.len() as u64 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::tests::{close, normal};

    const Z_95: f64 = 1.959_963_984_540_054;

    fn observation(stratum: u32, cluster: u32, launch: u32, numerator: f64, denominator: f64) -> Observation {
        Observation { stratum, cluster, launch, numerator, denominator }
    }

    /// Totals 300 over 3 and 10 over 1: the mean of the ratios would be 55; the ratio of the totals is 310/4.
    #[test]
    fn it_is_the_ratio_of_the_totals() {
        let totals = Totals::of([observation(0, 0, 0, 300.0, 3.0), observation(0, 1, 0, 10.0, 1.0)]).unwrap();
        assert_eq!(totals.ratio(), 77.5);
    }

    /// A cluster that was observed in one launch of two counts as much as one observed in both: (10 + 20) / 2. The mean over cells would be
    /// (10 + 10 + 20) / 3.
    #[test]
    fn clusters_weigh_the_same_however_often_they_were_timed() {
        let cells = [observation(0, 0, 0, 10.0, 1.0), observation(0, 0, 1, 10.0, 1.0), observation(0, 1, 0, 20.0, 1.0)];
        assert_eq!(Totals::of(cells).unwrap().ratio(), 15.0);
    }

    /// Clusters of three strata with a common effect of 1: the intervals of about 15 of 300 samples miss it.
    #[test]
    fn intervals_hold_what_they_promise() {
        let mut normal = normal(5);
        for clusters in [4, 20] {
            let mut missed = 0;
            for sample in 0..300 {
                let mut cells = Vec::new();
                for stratum in 0..3_u32 {
                    let size = 10_f64.powi(stratum.cast_signed());
                    for cluster in 0..clusters {
                        let factor = (0.1 * normal()).exp();
                        cells.push(observation(stratum, cluster, 0, size * factor, size));
                    }
                }
                let interval = Totals::of(cells).unwrap().estimate(sample, "test").interval;
                // The mean of exp(0.1 z) is exp(0.005).
                missed += u32::from(interval.low > 1.005 || interval.high < 1.005);
            }
            assert!((3..=33).contains(&missed), "{clusters} clusters: {missed} of 300");
        }
    }

    /// Launches with a common effect of 1 that differ by 2 %, on 30 clusters that differ by 1 %: the intervals of about 22 of 400 samples miss
    /// the effect, 43 at two launches, whose own variance is uncertain. As many draws as launches, with the clusters' degrees of freedom alone,
    /// miss it about 156 times at two launches, 91 at three and 56 at five.
    #[test]
    fn few_launches_hold_what_they_promise() {
        let mut normal = normal(7);
        for (launches, most) in [(2_u32, 68), (3, 42), (5, 42)] {
            let mut missed = 0;
            for sample in 0..400 {
                let of_launch: Vec<f64> = (0..launches).map(|_| 0.02 * normal()).collect();
                let of_cluster: Vec<f64> = (0..30).map(|_| 0.01 * normal()).collect();
                let cell = |launch: u32, cluster: u32| {
                    let effect = of_launch[launch as usize] + of_cluster[cluster as usize];
                    observation(0, cluster, launch, effect.exp(), 1.0)
                };
                let cells = (0..launches).flat_map(|launch| (0..30).map(move |cluster| (launch, cluster)));
                let totals = Totals::of(cells.map(|(launch, cluster)| cell(launch, cluster))).unwrap();
                let interval = totals.estimate(sample, "test").interval;
                missed += u32::from(interval.low > 1.0 || interval.high < 1.0);
            }
            assert!(missed <= most, "{launches} launches: {missed} of 400");
        }
    }

    /// Two launches at 1.00 and 1.10 on 50 clusters that agree: one launch is drawn, and the interval is Student's at one degree of freedom.
    #[test]
    fn launches_are_resampled() {
        let cells =
            (0..50).flat_map(|cluster| [(0, 1.0), (1, 1.1)].map(|(launch, n)| observation(0, cluster, launch, n, 1.0)));
        let estimate = Totals::of(cells).unwrap().estimate(1, "test");
        close(estimate.interval.value, 1.05, 1e-12);
        close(estimate.freedom, 1.0, 1e-9);
        // Deviations of fifty clusters are lengthened by up to 1.0102.
        let ends = [(estimate.interval.high, 1.1_f64), (estimate.interval.low, 1.0)];
        for (end, drawn) in ends {
            let wider = (end / 1.05).ln() / (drawn / 1.05).ln() / (12.706 / Z_95);
            assert!((0.999..1.011).contains(&wider), "{estimate:?}");
        }
    }

    /// More launches of the same clusters are no new evidence about other clusters, so the interval must not shrink. (Drawing the clusters
    /// anew in each launch would halve it here.)
    #[test]
    fn launches_do_not_multiply_the_clusters() {
        let width = |launches: u32| {
            let cells = (0..50).flat_map(|cluster| (0..launches).map(move |launch| (cluster, launch)));
            let cells = cells.map(|(cluster, launch)| observation(0, cluster, launch, f64::from(cluster + 50), 1.0));
            let interval = Totals::of(cells).unwrap().estimate(1, "test").interval;
            interval.high - interval.low
        };
        close(width(4) / width(1), 1.0, 0.1);
    }

    /// Five binaries of two launches with a common effect of 1 and a spread of 2 % between binaries, on 30 clusters that agree: the
    /// intervals of about 10 of 200 samples miss the effect. If launches are taken as independent, about 40
    /// intervals miss the effect.
    #[test]
    fn binaries_are_what_is_repeated() {
        let mut normal = normal(6);
        let mut binaries = Binaries::default();
        assert!((0..10).all(|launch| binaries.note(launch, launch % 5)));
        assert!(!binaries.note(3, 4), "launch 3 ran binary 3");
        let (mut missed, mut missed_alone) = (0, 0);
        for sample in 0..200 {
            let effects: Vec<f64> = (0..5).map(|_| 0.02 * normal()).collect();
            let mut cells = Vec::new();
            for launch in 0..10_u32 {
                let effect = effects[launch as usize % 5] + 0.002 * normal();
                cells.extend((0..30).map(|cluster| observation(0, cluster, launch, effect.exp(), 1.0)));
            }
            let totals = Totals::of(cells).unwrap();
            let is_off = |interval: Interval| u32::from(interval.low > 1.0 || interval.high < 1.0);
            missed_alone += is_off(totals.estimate(sample, "test").interval);
            missed += is_off(totals.of_binaries(&binaries).estimate(sample, "test").interval);
        }
        assert!(
            (2..=20).contains(&missed) && missed_alone > 2 * missed,
            "{missed} of 200, {missed_alone} without binaries"
        );
    }

    /// Launches 0 and 2 ran one binary, and launch 1 another; the sums are by binary.
    #[test]
    fn launches_are_added_up_by_binary() {
        let mut binaries = Binaries::default();
        [(0, 7), (1, 9), (2, 7)].into_iter().for_each(|(launch, binary)| assert!(binaries.note(launch, binary)));
        let launches = [(1.0, 10.0), (2.0, 20.0), (3.0, 30.0)];
        assert_eq!(binaries.repeated(&launches), [(2.0, 20.0), (2.0, 20.0)]);
        assert_eq!(Binaries::default().repeated(&launches), launches);
        let observations = || (0..).zip(launches).map(|(launch, (n, d))| (launch, n, d));
        assert_eq!(binaries.added_up(observations()), [(4.0, 40.0), (2.0, 20.0)]);
        assert_eq!(
            binaries.added_up(observations().step_by(2)),
            [(1.0, 10.0), (3.0, 30.0)],
            "one binary, two launches"
        );
    }

    /// Variation that all pairs share cancels in the ratio, so the interval is a point.
    #[test]
    fn pairs_in_one_proportion_leave_no_doubt() {
        let totals =
            Totals::of((0..9).map(|i| observation(0, i, 0, 2.0 * f64::from(i + 1), f64::from(i + 1)))).unwrap();
        let estimate = totals.estimate(1, "test");
        close(estimate.interval.low, 2.0, 1e-12);
        close(estimate.interval.high, 2.0, 1e-12);
        assert!(estimate.p_value(1.9) < 1e-12, "{estimate:?}");
    }

    /// Two launches with ratios 1.0 and 1.1: the mean of the logarithm is 0.04766, its error 0.04766, and Student's t at one degree of
    /// freedom 12.706.
    #[test]
    fn two_launches_promise_little() {
        let estimate = over_launches(&[(100.0, 100.0), (110.0, 100.0)]).unwrap();
        close(estimate.interval.value, 1.05, 1e-12);
        close(estimate.interval.high / estimate.interval.value, (12.706 * 0.047_655_f64).exp(), 1e-2);
        let one = over_launches(&[(100.0, 100.0)]).unwrap();
        assert!(one.freedom == 0.0 && one.interval.high.is_nan() && one.p_value(0.5) == 1.0);
        assert!(over_launches(&[]).is_none());
    }
}
