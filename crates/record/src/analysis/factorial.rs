//! Effects and shares of variance in a full factorial design with one value per cell.
//!
//! G. E. P. Box, J. S. Hunter, W. G. Hunter, "Statistics for Experimenters", 2nd ed. 2005, chapters 5 and 9. In a full crossing all terms
//! are orthogonal. The sums of squares of main effects, two-factor interactions and the remainder therefore add up to the total exactly,
//! and no model has to be fitted.

/// A full crossing of factors. The last factor varies fastest.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Design {
    levels: Vec<usize>,
}

/// A factor, or a pair of factors: their indices, ascending.
pub type Term = Vec<usize>;

/// The effects and shares of variance of one response.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// For every term of [`Design::terms`], the effect of each combination of its levels; the last factor varies fastest. A main effect is
    /// a deviation from the mean over all cells. An interaction is the remaining deviation after both main effects.
    pub effects: Vec<Vec<f64>>,
    /// For every term, its share of the total sum of squares; the last entry is the share of all interactions of three and more factors.
    /// All entries are 0 when the cells do not differ.
    pub shares: Vec<f64>,
}

impl Design {
    /// A design with the given number of levels of each factor, at least one.
    pub const fn new(levels: Vec<usize>) -> Self {
        Self { levels }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.levels.iter().product()
    }

    /// Number of levels of a factor.
    pub fn levels(&self, factor: usize) -> usize {
        self.levels[factor]
    }

    /// Index of the cell at the given level of each factor.
    pub fn cell(&self, at: &[usize]) -> usize {
        at.iter().zip(&self.levels).fold(0, |cell, (level, levels)| cell * levels + level)
    }

    /// The level of a factor in a cell.
    pub fn level(&self, cell: usize, factor: usize) -> usize {
        cell / self.levels[factor + 1..].iter().product::<usize>() % self.levels[factor]
    }

    /// All factors, then all pairs of factors.
    pub fn terms(&self) -> Vec<Term> {
        let count = self.levels.len();
        let pairs = (0..count).flat_map(|f| (f + 1..count).map(move |g| vec![f, g]));
        (0..count).map(|f| vec![f]).chain(pairs).collect()
    }

    /// Decomposes a response, given as one value per cell.
    pub fn decompose(&self, response: &[f64]) -> Decomposition {
        let cells = self.cells() as f64;
        let mean = response.iter().sum::<f64>() / cells;
        let total: f64 = response.iter().map(|y| (y - mean).powi(2)).sum();
        let mut effects: Vec<Vec<f64>> = Vec::new();
        let mut squares = Vec::new();
        for term in self.terms() {
            let mut effect = self.margin(response, &term);
            let repeats = cells / effect.len() as f64;
            match term[..] {
                [f, g] => {
                    for (index, value) in effect.iter_mut().enumerate() {
                        let (i, j) = (index / self.levels[g], index % self.levels[g]);
                        *value -= mean + effects[f][i] + effects[g][j];
                    }
                }
                _ => effect.iter_mut().for_each(|value| *value -= mean),
            }
            squares.push(repeats * effect.iter().map(|e| e * e).sum::<f64>());
            effects.push(effect);
        }
        squares.push((total - squares.iter().sum::<f64>()).max(0.0));
        // Differences that are rounding alone must not be divided up.
        let is_flat = total <= 1e-24 * response.iter().map(|y| y * y).sum::<f64>();
        let shares = squares.iter().map(|square| if is_flat { 0.0 } else { square / total }).collect();
        Decomposition { effects, shares }
    }

    /// The mean response at every combination of a term's levels.
    fn margin(&self, response: &[f64], term: &[usize]) -> Vec<f64> {
        let size: usize = term.iter().map(|&f| self.levels[f]).product();
        let mut sums = vec![0.0; size];
        for (cell, y) in response.iter().enumerate() {
            let place = term.iter().fold(0, |place, &f| place * self.levels[f] + self.level(cell, f));
            sums[place] += y;
        }
        let repeats = (response.len() / size) as f64;
        sums.iter().map(|sum| sum / repeats).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn two_by_three_by_hand() {
        // Rows 1 2 3 and 3 4 11: mean 4; row means 2 and 6; column means 2, 3, 7.
        let design = Design::new(vec![2, 3]);
        let d = design.decompose(&[1.0, 2.0, 3.0, 3.0, 4.0, 11.0]);
        assert_eq!(d.effects[0], [-2.0, 2.0]);
        assert_eq!(d.effects[1], [-2.0, -1.0, 3.0]);
        // 1 - (4 - 2 - 2) = 1, 2 - (4 - 2 - 1) = 1, 3 - (4 - 2 + 3) = -2, and the opposite in the second row.
        assert_eq!(d.effects[2], [1.0, 1.0, -2.0, -1.0, -1.0, 2.0]);
        // Sums of squares: 3·8 = 24, 2·14 = 28, 12; the total 9 + 4 + 1 + 1 + 0 + 49 = 64.
        assert_eq!(d.shares, [24.0 / 64.0, 28.0 / 64.0, 12.0 / 64.0, 0.0]);
    }

    #[test]
    fn cells_count_with_the_last_factor_fastest() {
        let design = Design::new(vec![2, 3, 4]);
        assert_eq!((design.cells(), design.cell(&[1, 2, 3]), design.cell(&[0, 1, 0])), (24, 23, 4));
        for cell in 0..24 {
            assert_eq!(design.cell(&[0, 1, 2].map(|f| design.level(cell, f))), cell);
        }
    }

    #[test]
    fn what_takes_three_factors_is_the_rest() {
        // The product of three signs has neither main effects nor two-factor interactions.
        let design = Design::new(vec![2, 2, 2]);
        let response: Vec<f64> = (0..8_u32).map(|cell| if cell.count_ones() % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let d = design.decompose(&response);
        assert_eq!(d.shares, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert!(design.decompose(&[2.5; 8]).shares.iter().all(|share| *share == 0.0));
    }

    proptest! {
        #[test]
        fn shares_add_up_and_effects_cancel(y in prop::collection::vec(-5.0..5.0_f64, 36)) {
            let design = Design::new(vec![3, 2, 3, 2]);
            let d = design.decompose(&y);
            prop_assert!((d.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            for effect in &d.effects {
                prop_assert!(effect.iter().sum::<f64>().abs() < 1e-9);
            }
        }
    }
}
