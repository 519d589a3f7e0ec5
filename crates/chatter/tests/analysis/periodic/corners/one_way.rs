//! Elements that let through one way, as diodes: what comes to its end there stands still until it is driven on.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// The branch over w goes through its range without a special point, from these values and by these steps.
fn nothing_happens(text: &str, range: (f64, f64), runs: &[(&str, f64)]) {
    for &(start, step) in runs {
        let found = over(&with(text, &[("w", start)]), "w", range, (8, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{start} {step}");
        assert!(
            found[0].special.is_empty(),
            "{start} {step}: {:?}",
            found[0].special
        );
    }
}

/// A rectifier with choke and capacitor conducts once a period, and nothing happens to that along w. The current begins at the very instant at which the voltage
/// over the choke is there, from where it has stood since the last time: what rounding has left of it is no touch. Voltages by DOP853 with 1e-12.
#[test]
fn a_current_that_begins_where_it_has_stood_touches_nothing() {
    let forms = [
        "if(i > 0, e, max(e, 0))",
        "if(i > 0 or e > 0, e, 0)",
        "max(e, 0)*(1 - step(i)) + e*step(i)",
    ];
    for (form, step) in forms.into_iter().zip([0.01, 0.03, 0.03]) {
        let text = format!(
            "[parameters]\nw = 0.36\n[definitions]\ne = '2*sin(w*t) - 0.1*i - u'\n[flight]\ni = '{form}'\nu = 'i - u/5'\n\
             [section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\ni = 0.1\nu = 0.5\n"
        );
        let found = over(&with(&text, &[]), "w", (0.35, 0.365), (8, step)).swap_remove(0);
        assert_eq!(found.ends, [End::Range, End::Range], "{form}");
        assert!(found.special.is_empty(), "{form}: {:?}", found.special);
        let ends = [&found.points[0], &found.points[found.points.len() - 1]];
        for (point, voltage) in ends
            .into_iter()
            .zip([0.2109435051180794, 0.2430132843149097])
        {
            assert!(
                (point.state[1] - voltage).abs() < 1e-11,
                "{form}: {}",
                point.state[1]
            );
        }
    }
}

/// A chopper drives a load with a voltage of its own. Its current reaches the next pulse if E is below U (1 - a) b / (1 - a b), a and b what decays in a pulse
/// and between two; above that it ends before, and is held at zero until the pulse. A block that dry friction brings to rest between pulses does the like with
/// E + mu in place of E. From both sides the branch goes on.
#[test]
fn what_is_held_until_a_pulse_comes_in_where_that_lets_go_of_it_at_once() {
    let (r, d, friction) = (0.3_f64, 0.2_f64, 0.15);
    let pulse = core::f64::consts::PI - 2.0 * d.asin();
    let [a, b] = [pulse, core::f64::consts::TAU - pulse].map(|time| (-r * time).exp());
    let touch = (1.0 - a) * b / (1.0 - a * b);
    let current = ("if(i > 0, e, max(e, 0))", 0.0);
    let block = ("e - 0.15*sign(i)", friction);
    for (form, less) in [current, block] {
        let text = format!(
            "[parameters]\nE = 0.1\n[definitions]\ne = 'if(sin(t) > 0.2, 1, 0) - E - 0.3*i'\n[flight]\ni = '{form}'\n\
             [section.strobe]\nsurface = 'sin(t)'\ndirection = 'rising'\n[initial]\ni = 0.1\n"
        );
        let place = touch - less;
        for (off, step) in [(-0.02, 0.01), (-0.02, 0.1), (0.02, 0.01), (0.02, 0.1)] {
            let model = with(&text, &[("E", &(place + off).to_string())]);
            let found = over(&model, "E", (place - 0.03, place + 0.03), (8, step)).swap_remove(0);
            assert_eq!(found.ends, [End::Range, End::Range], "{form} {off} {step}");
            let [told] = &found.special[..] else {
                panic!("{form} {off} {step}: {:?}", found.special);
            };
            assert_eq!((told.kind, told.persists), (SpecialKind::Touch, Some(true)));
            assert!(
                (value(told) - place).abs() < 1e-15,
                "{form} {off}: {}",
                value(told)
            );
        }
    }
}

/// A full-wave rectifier's current ends just as the voltage passes zero, where that has a corner and nothing happens to the orbit: both halves of a period come there
/// at once.
#[test]
fn a_current_that_ends_with_a_corner_of_its_voltage_touches_nothing() {
    let text = "[parameters]\nw = 1\n[definitions]\ne = '2*abs(sin(w*t)) - 0.2*i - u'\n[flight]\ni = 'if(i > 0, e, max(e, 0))'\n\
                u = '(i - u/5)/2'\n[section.strobe]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\ni = 0.1\nu = 0.5\n";
    let runs = [("0.98", 0.03), ("0.987", 0.03), ("0.987", 0.1)];
    nothing_happens(text, (0.975, 0.99), &runs);
}

/// A milling cutter whose chip, which is not thinner than nothing, ends just as the tooth leaves the cut: with and without its end before that the force goes on as
/// it is, and neither the one nor the other orbit is told to touch anything.
#[test]
fn a_chip_that_ends_with_the_cut_is_no_touch() {
    let text = "[parameters]\nw = 1.455\n[flight]\nx = 'v'\n\
                v = '-x - 0.06*v + 0.8*if(sin(w*t) > 0, max(0.3 + 0.5*sin(w*t) - x, 0), 0)'\n[initial]\nx = 0.1\nv = 0\n";
    let runs = [("1.435", 0.01), ("1.455", 0.01), ("1.455", 0.1)];
    nothing_happens(text, (1.43, 1.46), &runs);
}

/// A ratchet wheel behind a torsion spring turns one way. Where its drive comes to be just enough once more in a period a short turn comes in, at
/// w = 0.754946520556 by an integration (DOP853, tolerance 1e-12) of its own: the branch goes on from either side, by all steps.
#[test]
fn a_ratchet_wheel_that_is_just_driven_turns_beyond() {
    let text = "[parameters]\nw = 0.8\n[definitions]\na = '2*(e - 0.15 - 0.1*q)'\n[flight]\ne = 'v - q'\nv = '0.8*cos(w*t) - e - 0.1*v'\n\
                q = 'if(q > 0, a, max(a, 0))'\n[initial]\ne = 0\nv = 0\nq = 0\n";
    for (start, step) in [
        ("0.8", 0.1),
        ("0.78", 0.03),
        ("0.765", 0.01),
        ("0.75", 0.03),
    ] {
        let found = over(&with(text, &[("w", start)]), "w", (0.74, 0.82), (8, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{start} {step}");
        let [told] = &found[0].special[..] else {
            panic!("{start} {step}: {:?}", found[0].special);
        };
        assert_eq!((told.kind, told.persists), (SpecialKind::Touch, Some(true)));
        assert!(
            (value(told) - 0.754946520556).abs() < 5e-12,
            "{start} {step}: {}",
            value(told)
        );
    }
}
