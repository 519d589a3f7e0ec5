//! What is asked of the universal map.

use super::job::UniversalJob;
use crate::options::{Counts, Decimal, Periods, SweepOption};
use crate::refusal::Refusal;
use chatter::analysis::diagram::{Exponent, Spec, Start, Swept};
use chatter::analysis::universal::UniversalError;

/// The map z -> Upsilon(K z + mu), and what is to be found out about it.
#[derive(Clone, Debug)]
pub struct Request {
    /// The coefficient of restitution.
    pub restitution: Decimal,
    /// The slope K.
    pub slope: Decimal,
    /// The offset mu, where it is not swept: 0 if not given.
    pub mu: Option<Decimal>,
    /// Where Upsilon is evaluated.
    pub at: Vec<Decimal>,
    /// Windows of fixed points.
    pub windows: Option<Counts>,
    /// Windows of orbits of these periods.
    pub periods: Option<Periods>,
    /// The basin of each window.
    pub basins: bool,
    /// Ratios from window to window.
    pub scaling: bool,
    /// Where there is chaos.
    pub chaos: bool,
    /// An orbit diagram.
    pub sweep: Option<SweepOption>,
    /// Iterates passed over for each of its values.
    pub transient: u64,
    /// Iterates kept.
    pub keep: u64,
    /// Lyapunov exponents of its orbits.
    pub lyapunov: bool,
    /// A cobweb at this offset.
    pub cobweb: Option<Decimal>,
}

impl Request {
    /// The orbit diagram, where one is asked for.
    ///
    /// # Errors
    /// The ends of the range are no numbers, or mu is given and swept.
    pub fn job(&self) -> Result<Option<UniversalJob>, Refusal> {
        let Some(sweep) = &self.sweep else {
            return Ok(None);
        };
        if self.mu.is_some() && sweep.name() == "mu" {
            let refusal = Refusal::input(
                "--mu gives the offset where it is not swept, and --sweep sweeps it",
            );
            return Err(refusal.help("leave out --mu, or sweep slope"));
        }
        Ok(Some(UniversalJob {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            restitution: self.restitution.to_f64(),
            slope: self.slope.to_f64(),
            mu: self.offset(),
            diagram: self.specification(sweep)?,
        }))
    }

    /// The offset mu, where it is not swept.
    pub fn offset(&self) -> f64 {
        self.mu.map_or(0.0, Decimal::to_f64)
    }

    fn specification(&self, sweep: &SweepOption) -> Result<Spec, Refusal> {
        let range = sweep.plain()?;
        Ok(Spec {
            start: match range.swept {
                Swept::Parameter => Start::CarryUp,
                Swept::Initial => Start::Fresh,
            },
            chunk: Some(Spec::quick_chunk(range.count)),
            exponent: if self.lyapunov {
                Exponent::Largest
            } else {
                Exponent::Skip
            },
            ..Spec::new(range, "z", self.transient, self.keep)
        })
    }
}

/// A restitution, slope or lap that is none.
pub fn refused(error: UniversalError) -> Refusal {
    Refusal::input(error)
}
