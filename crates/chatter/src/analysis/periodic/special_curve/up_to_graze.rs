//! The motion read from some event of an orbit up to where it grazes, and no further: after a graze it is that orbit only to the root of what it is off
//! by, so that a lap through it need not close.

use super::follower::Follower;
use super::past_break::Beside;
use super::past_touch::holds;
use super::start::{Begun, solved};
use crate::analysis::continuation::Condition as Row;
use crate::analysis::periodic::branch::legal;
use crate::analysis::periodic::condition::Condition;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step, read};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::cycle::trace::Tracer;
use crate::flow::leg::LegKind;
use core::ops::ControlFlow;

/// The motion is followed up to this part of the leg before the graze.
const BEFORE: f64 = 1e-2;

impl Follower {
    /// The orbits that the motion shows between an event after the graze and the next one: from the first event on, and from the best.
    pub(super) fn up_to_graze(&self, own: &Beside) -> Vec<Begun> {
        let Some((_, grazing, _)) = own.grazed else {
            return Vec::new();
        };
        let shooting = &own.shooting;
        let after = shooting.after(grazing);
        let first = shooting.after(after);
        let nodes = [Some(first), own.best_node().filter(|&node| node != first)];
        let is_free = |node: &usize| *node != after && !shooting.steps[*node].is_at_once();
        let nodes = nodes.into_iter().flatten().filter(is_free);
        nodes
            .filter_map(|node| self.up_to_graze_from(own, node))
            .collect()
    }

    fn up_to_graze_from(&self, own: &Beside, node: usize) -> Option<Begun> {
        let (_, grazing, _) = own.grazed?;
        let (shooting, at) = (&own.shooting, &own.at);
        let workshop = &shooting.workshop;
        let free = shooting.free(at).to_vec();
        let parameters = workshop.parameters(&free);
        let mut steps = shooting.current_steps(at);
        let count = steps.len();
        let closed = shooting.closed_before(node);
        if node > 0 {
            let cycle = (&mut *steps, &*shooting.counts);
            rotate(workshop, &parameters, cycle, node).ok()?;
        }
        let last = (grazing + count - node) % count;
        let Passage::Leg(kind) = steps[last].passage else {
            return None;
        };
        let state = legal(workshop, &free, (closed, &steps[0].start))?;
        let mut tracer = Tracer::new(&workshop.system, &parameters, &state, None).ok()?;
        let mut instants = vec![tracer.start(&state)];
        let lasts: f64 = steps[..=last].iter().map(|step| step.duration).sum();
        let end = instants[0].time + lasts;
        let until = end - BEFORE * steps[last].duration;
        let mut quiet = |_: f64| ControlFlow::Continue(());
        let most = usize::MAX / 2;
        (tracer.follow((until, most), &mut instants, &mut quiet)).ok()?;
        let mut all = read((&workshop.system, &parameters), &instants).ok()?;
        let latest = &instants[instants.len() - 1];
        let graze = Step {
            passage: Passage::Leg(LegKind {
                mode: latest.mode_after,
                ..kind
            }),
            start: latest.state.clone(),
            duration: end - latest.time,
            told: Vec::new(),
            ..steps[last].clone()
        };
        let grazing = all.len();
        all.push(graze);
        all.extend_from_slice(&steps[last + 1..]);
        let (beyond, at) = shooting.like(all, at).ok()?;
        let condition = (Condition::Monitor(grazing), Some(grazing));
        let solved = |held: &[Row<f64>]| {
            let begun = solved((beyond.clone(), at.clone()), condition, self.kind, held).ok()?;
            let mut shooting = begun.shooting.clone();
            holds(&mut shooting, &begun.at, begun.grazing).then_some(begun)
        };
        // The curve may turn back in the parameter there. What has come in as the sequence changed lasts but for a moment, which grows.
        let places = (0..beyond.steps.len()).filter_map(|index| beyond.duration_place(index));
        let shortest = places.min_by(|&a, &b| at[a].total_cmp(&at[b]))?;
        let of_parameter = solved(&Row::held(&at, at.len() - 1..at.len()));
        of_parameter.or_else(|| solved(&[Row::fixed(at.len(), shortest, at[shortest])]))
    }
}
