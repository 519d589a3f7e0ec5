//! A border orbit rounded to another number type.

use super::normal_form::exact::{Exact, Memory};
use super::normal_form::leading_order::LeadingOrder;
use super::orbit::{Border, FirstImpact};
use super::release::equations::ReleasePoint;
use super::release::forcing::Turn;
use crate::analysis::universal::Constants;
use crate::numerics::Estimate;
use crate::numerics::{DoubleDouble, Real, Scalar};

type Wide = DoubleDouble;

fn each<R: Real>(values: &[Wide]) -> Vec<R> {
    values.iter().map(|&x| R::from_double_double(x)).collect()
}

fn pair<R: Real>(values: [Wide; 2]) -> [R; 2] {
    values.map(R::from_double_double)
}

impl Estimate<Wide> {
    /// The error is at least that of rounding.
    pub(crate) fn rounded<R: Real>(self) -> Estimate<R> {
        let rounding = R::ROUNDOFF * self.value.abs().to_f64();
        Estimate {
            value: R::from_double_double(self.value),
            error: self.error.max(rounding),
        }
    }
}

impl Border<Wide> {
    /// The same in another number type.
    pub(crate) fn rounded<R: Real>(&self) -> Border<R> {
        Border {
            parameter: self.parameter.clone(),
            value: self.value.rounded(),
            constants: constants(&self.constants),
            release: release(&self.release),
            first_impact: FirstImpact {
                time: R::from_double_double(self.first_impact.time),
                state: each(&self.first_impact.state),
                rate_before: R::from_double_double(self.first_impact.rate_before),
            },
            period: self.period.rounded(),
            turns: self.turns.iter().map(turn).collect(),
            sequence_begins: self.sequence_begins,
            long_flights: self.long_flights,
            impacts: self.impacts,
            section: self.section.clone(),
            exact: exact(&self.exact),
            leading_order: (self.leading_order.as_ref())
                .map(leading_order)
                .map_err(Clone::clone),
        }
    }
}

fn constants<R: Real>(from: &Constants<Wide>) -> Constants<R> {
    let to = R::from_double_double;
    Constants {
        restitution: to(from.restitution),
        chatter_fixed_point: to(from.chatter_fixed_point),
        flight_root: to(from.flight_root),
        lambda: to(from.lambda),
        eta: to(from.eta),
        one_minus_lambda: to(from.one_minus_lambda),
        one_minus_eta: to(from.one_minus_eta),
        ln_lambda: to(from.ln_lambda),
        ln_eta: to(from.ln_eta),
        exponent: to(from.exponent),
    }
}

fn release<R: Real>(from: &ReleasePoint<Wide>) -> ReleasePoint<R> {
    let to = R::from_double_double;
    ReleasePoint {
        contact: from.contact,
        state: each(&from.state),
        free: from.free.clone(),
        directions: from.directions.iter().map(|d| each(d)).collect(),
        slope: each(&from.slope),
        jerk: to(from.jerk),
        restitution: to(from.restitution),
        restitution_slope: to(from.restitution_slope),
        restitution_by: each(&from.restitution_by),
        jerk_slope: to(from.jerk_slope),
        field: each(&from.field),
        field_slope: each(&from.field_slope),
        jump: each(&from.jump),
    }
}

fn turn<R: Real>(from: &Turn<Wide>) -> Turn<R> {
    Turn {
        state: from.state,
        period: R::from_double_double(from.period),
        period_slope: R::from_double_double(from.period_slope),
        count: from.count,
    }
}

fn exact<R: Real>(from: &Exact<Wide>) -> Exact<R> {
    Exact {
        slope: from.slope.rounded(),
        unfolding_rate: from.unfolding_rate.rounded(),
        amplitude: from.amplitude.rounded(),
        first_impact_by_upsilon: estimates(&from.first_impact_by_upsilon),
        first_impact_by_parameter: estimates(&from.first_impact_by_parameter),
        flight: from.flight.iter().map(|row| estimates(row)).collect(),
        offset: estimates(&from.offset),
        covector: estimates(&from.covector),
        covector_parameter: from.covector_parameter.rounded(),
        memory: from.memory.as_ref().map(Memory::rounded),
    }
}

impl<S: Real> Memory<S> {
    /// The same in another number type.
    pub(crate) fn rounded<R: Real>(&self) -> Memory<R> {
        let to = |x: S| R::from_double_double(x.to_double_double());
        let each = |values: &Vec<S>| values.iter().map(|&x| to(x)).collect();
        let rows = |rows: &[Vec<S>]| rows.iter().map(each).collect();
        Memory {
            states: self.states.clone(),
            returns: rows(&self.returns),
            by_upsilon: each(&self.by_upsilon),
            by_parameter: each(&self.by_parameter),
            covector: each(&self.covector),
            slope: to(self.slope),
            doubling_slope: to(self.doubling_slope),
            first_impact_by_upsilon: each(&self.first_impact_by_upsilon),
            first_impact_by_memory: rows(&self.first_impact_by_memory),
        }
    }
}

fn estimates<R: Real>(from: &[Estimate<Wide>]) -> Vec<Estimate<R>> {
    from.iter().map(|estimate| estimate.rounded()).collect()
}

fn leading_order<R: Real>(from: &LeadingOrder<Wide>) -> LeadingOrder<R> {
    LeadingOrder {
        section: from.section.clone(),
        crossing: pair(from.crossing),
        a: from.a.iter().map(|&row| pair(row)).collect(),
        b: pair(from.b),
        c: each(&from.c),
        d: R::from_double_double(from.d),
        e: pair(from.e),
        f: each(&from.f),
        slope: R::from_double_double(from.slope),
        unfolding_rate: R::from_double_double(from.unfolding_rate),
    }
}
