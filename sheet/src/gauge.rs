//! Whether a tester is good enough: repeatability and reproducibility beside the parts' own spread.

use identification::statistics::mean;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

/// Level above which a part–operator interaction is no more than chance, and joins the repeatability (AIAG, Measurement Systems
/// Analysis, 4th edition, 2010).
const INTERACTION_LEVEL: f64 = 0.25;
/// Categories per ratio of the parts' deviation to the gauge's (AIAG: √2, rounded).
const CATEGORIES: f64 = 1.41;
/// Deviations that the study variation spans (AIAG).
const STUDY: f64 = 6.0;

/// Who measured what.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Design {
    /// Every operator measured every part.
    Crossed,
    /// Every operator measured parts of their own.
    Nested,
}

/// A gauge study by analysis of variance (AIAG, Measurement Systems Analysis, 4th edition, 2010, III.B).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gauge {
    /// Who measured what.
    pub design: Design,
    /// Number of parts; of a nested design, of each operator.
    pub parts: usize,
    /// Number of operators.
    pub operators: usize,
    /// Times that an operator measured a part.
    pub trials: usize,
    /// Probability of as large an interaction by chance; `None` of a nested design.
    pub interaction_p_value: Option<f64>,
    /// Variance of an operator's repeats.
    pub repeatability_variance: f64,
    /// Variance between operators.
    pub operator_variance: f64,
    /// Variance of operators' differences from part to part; zero where it is no more than chance.
    pub interaction_variance: f64,
    /// Variance of the parts.
    pub part_variance: f64,
    /// %GRR: deviation of repeatability and reproducibility over that of everything, %.
    pub grr_percent: f64,
    /// Six deviations of repeatability and reproducibility over the distance of the limits, %; `None` without two limits.
    pub grr_tolerance_percent: Option<f64>,
    /// Number of distinct categories of parts; `None` for a gauge without any variance.
    pub ndc: Option<u64>,
}

/// Why there is no gauge study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GaugeError {
    /// Fewer than two of something.
    #[error("a gauge study needs at least two parts, two operators and two trials of each; it has {0}, {1} and {2}")]
    TooFew(usize, usize, usize),
    /// Some were measured more often than others.
    #[error("every operator must measure the same number of parts, each equally often")]
    Uneven,
}

impl Gauge {
    /// The study of values by operator, part and trial; `tolerance` is the distance of the limits. Parts of a crossed study stand
    /// in the same order for every operator.
    ///
    /// # Errors
    /// [`GaugeError`] for a study that is too small or uneven.
    pub fn of(values: &[Vec<Vec<f64>>], design: Design, tolerance: Option<f64>) -> Result<Self, GaugeError> {
        let operators = values.len();
        let parts = values.first().map_or(0, Vec::len);
        let trials = values.first().and_then(|parts| parts.first()).map_or(0, Vec::len);
        if operators < 2 || parts < 2 || trials < 2 {
            return Err(GaugeError::TooFew(parts, operators, trials));
        }
        if values.iter().any(|of| of.len() != parts || of.iter().any(|of| of.len() != trials)) {
            return Err(GaugeError::Uneven);
        }
        let squares = Squares::of(values, [operators, parts, trials]);
        let [repeatability, operator, interaction, part, p_value] = match design {
            Design::Crossed => squares.crossed(),
            Design::Nested => squares.nested(),
        };
        let [operator, interaction, part] = [operator, interaction, part].map(|variance| variance.max(0.0));
        let gauge = repeatability + operator + interaction;
        Ok(Self {
            design,
            parts,
            operators,
            trials,
            interaction_p_value: (design == Design::Crossed).then_some(p_value),
            repeatability_variance: repeatability,
            operator_variance: operator,
            interaction_variance: interaction,
            part_variance: part,
            grr_percent: 100.0 * (gauge / (gauge + part)).sqrt(),
            grr_tolerance_percent: tolerance.map(|width| 100.0 * STUDY * gauge.sqrt() / width),
            ndc: categories(part, gauge),
        })
    }
}

fn categories(part: f64, gauge: f64) -> Option<u64> {
    (gauge > 0.0).then(|| (CATEGORIES * (part.sqrt() / gauge.sqrt())) as u64)
}

/// Sums of squares: of operators, of parts, of cells about their operator, and within cells.
struct Squares {
    counts: [f64; 3],
    operator: f64,
    part: f64,
    cell_in_operator: f64,
    error: f64,
}

impl Squares {
    fn of(values: &[Vec<Vec<f64>>], counts: [usize; 3]) -> Self {
        let [o, p, r] = counts.map(|count| count as f64);
        let cells: Vec<Vec<f64>> = values.iter().map(|parts| parts.iter().map(mean).collect()).collect();
        let operators: Vec<f64> = cells.iter().map(mean).collect();
        let parts: Vec<f64> = (0..counts[1]).map(|part| mean(cells.iter().map(|cells| cells[part]))).collect();
        let grand = mean(&operators);
        let square = |value: f64, about: f64| (value - about).powi(2);
        let of_cells = cells.iter().zip(&operators);
        let of_trials = values.iter().flatten().zip(cells.iter().flatten());
        Self {
            counts: [o, p, r],
            operator: p * r * operators.iter().map(|mean| square(*mean, grand)).sum::<f64>(),
            part: o * r * parts.iter().map(|mean| square(*mean, grand)).sum::<f64>(),
            cell_in_operator: r * of_cells
                .flat_map(|(cells, mean)| cells.iter().map(|cell| square(*cell, *mean)))
                .sum::<f64>(),
            error: of_trials.flat_map(|(trials, mean)| trials.iter().map(|value| square(*value, *mean))).sum(),
        }
    }

    /// Variances of repeatability, operators, interaction and parts, and the interaction's p-value.
    fn crossed(&self) -> [f64; 5] {
        let [o, p, r] = self.counts;
        let interaction = (self.cell_in_operator - self.part).max(0.0);
        let (of_interaction, of_error) = ((p - 1.0) * (o - 1.0), p * o * (r - 1.0));
        let [operators, parts] = [self.operator / (o - 1.0), self.part / (p - 1.0)];
        let [both, error] = [interaction / of_interaction, self.error / of_error];
        let p_value = match FisherSnedecor::new(of_interaction, of_error) {
            Ok(distribution) if error > 0.0 => distribution.sf(both / error),
            // Without any error every interaction is real.
            _ => 0.0,
        };
        if p_value <= INTERACTION_LEVEL {
            [error, (operators - both) / (p * r), (both - error) / r, (parts - both) / (o * r), p_value]
        } else {
            let error = (interaction + self.error) / (of_interaction + of_error);
            [error, (operators - error) / (p * r), 0.0, (parts - error) / (o * r), p_value]
        }
    }

    /// The same where each operator measured other parts: the interaction cannot be estimated.
    fn nested(&self) -> [f64; 5] {
        let [o, p, r] = self.counts;
        let operators = self.operator / (o - 1.0);
        let parts = self.cell_in_operator / (o * (p - 1.0));
        let error = self.error / (o * p * (r - 1.0));
        [error, (operators - parts) / (p * r), 0.0, (parts - error) / r, 1.0]
    }
}
