//! Searches for all orbits: each is found, and is one orbit wherever it is told from.

use crate::periodic::{HELD, PENDULUM, orbits_from, with};
use chatter::analysis::periodic::Orbit;
use chatter::numerics::Real;

fn found(text: &str, set: &[(&str, &str)], (periods, starts): (usize, u64)) -> Vec<Orbit> {
    orbits_from(&with(text, set), (periods, starts, 0))
}

fn without_section(text: &str) -> String {
    let (before, after) = text.split_once("[section.strobe]").unwrap();
    let (_, after) = after.split_once("[initial]").unwrap();
    format!("{before}[initial]{after}")
}

/// Just before the wall touches the pendulum that hangs at rest: rest, and two orbits with an impact.
#[test]
fn orbits_are_listed_once_and_rest_under_a_force_among_them() {
    for text in [PENDULUM, &without_section(PENDULUM)] {
        let found = found(text, &[("A", "0.0499")], (1, 60));
        let impacts: Vec<Option<u64>> = found.iter().map(|orbit| orbit.impacts).collect();
        assert_eq!(impacts, [Some(0), Some(1), Some(1)]);
        assert_eq!(
            found[0].start[..2]
                .iter()
                .map(|x| x.to_f64())
                .collect::<Vec<_>>(),
            [0.0, 0.0]
        );
        let tells = text.contains("strobe");
        assert!(found.iter().all(|orbit| orbit.section.is_some() == tells));
    }
}

/// What nothing happens to goes around twice as it does once.
#[test]
fn longer_loops_around_rest_are_not_listed() {
    let found = found(&without_section(PENDULUM), &[("A", "0.02")], (3, 20));
    let rest = found.iter().filter(|orbit| orbit.impacts == Some(0));
    assert_eq!(rest.count(), 1);
}

/// Where the motion from the initial state keeps to another orbit, starts still lead to rest in contact.
#[test]
fn rest_in_contact_is_found_from_flights() {
    let text = HELD.replace("x = 0\n", "x = 2\n");
    for text in [&text, &without_section(&text)] {
        let found = found(text, &[("a", "0.5")], (1, 10));
        assert_eq!(found.len(), 1, "{found:?}");
        assert_eq!(found[0].impacts, Some(0));
        assert!(found[0].multipliers.iter().all(|m| m.modulus() == 0.0));
    }
}

/// A soft stop has no impacts: orbits cross its surface.
#[test]
fn orbits_without_impacts_are_looked_for() {
    let text = "[flight]\nx = \"v\"\nv = \"4*cos(t) - 0.3*v - 30*(max(x - 2, 0) - max(-x - 2.6, 0))\"\n[initial]\nx = 0\nv = 0\n";
    let found = found(text, &[], (1, 100));
    assert!(found.iter().any(|orbit| !orbit.is_stable()), "{found:?}");
    assert!(found.iter().filter(|orbit| orbit.is_stable()).count() > 1);
}
