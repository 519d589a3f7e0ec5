//! Corners that a motion comes to at one instant: one event where they always come together, several where they do so by symmetry.

use crate::periodic::{orbit, over, settles, with};
use chatter::analysis::periodic::{End, MarginKind, Orbit, PeriodicError, Point};
use chatter::analysis::simulate;
use chatter::numerics::Real;
use core::f64::consts::TAU;
use core::ops::ControlFlow;

fn assert_multipliers(found: &Orbit, expected: &[(f64, f64)]) {
    assert_eq!(found.multipliers.len(), expected.len());
    for (re, im) in expected {
        let mut all = found.multipliers.iter();
        let is_near = |m: &chatter::numerics::Complex| (m.re - re).hypot(m.im - im) < 1e-9;
        assert!(all.any(is_near), "{re} {im}: {:?}", found.multipliers);
    }
}

/// Two square waves whose periods are as 3 to 1, in several units of time: both change their sign at one instant, and the motion beside
/// an orbit shrinks as it does without them.
#[test]
fn corners_of_two_clocks_are_one_event() {
    for unit in [1e-3_f64, 1.0, 1e3] {
        let w = 0.9 / unit;
        let text = format!(
            "[flight]\nx = 'v/{unit:?}'\nv = '(-x - 0.2*v + sign(sin({w:?}*t)) + 0.5*sign(sin(3*{w:?}*t)))/{unit:?}'\n\
             [initial]\nx = 0.4\nv = 0\n"
        );
        let found = orbit(&with(&text, &[]));
        assert!((found.period.to_f64() * w / TAU - 1.0).abs() < 1e-12);
        let (shrinks, turned) = ((-0.1 * TAU / 0.9).exp(), 0.99_f64.sqrt() * TAU / 0.9);
        let (re, im) = (shrinks * turned.cos(), shrinks * turned.sin());
        assert_multipliers(&found, &[(re, im), (re, -im)]);
    }
}

/// A spring that is written as two, which begin to push at one place, is one spring.
#[test]
fn two_names_of_one_place_are_one_event() {
    let of = |force: &str| {
        let text = format!(
            "[flight]\nx = 'v'\nv = '-x - 0.2*v - {force} + 2*cos(0.9*t)'\n[initial]\nx = 0.1\nv = 0\n"
        );
        orbit(&with(&text, &[]))
    };
    let two = of("3*max(x - 0.5, 0) - 2*max(0, min(2*x - 1, 30))");
    let one = of("7*max(x - 0.5, 0)");
    assert!((two.period - one.period).to_f64().abs() < 1e-14);
    let expected: Vec<(f64, f64)> = one.multipliers.iter().map(|m| (m.re, m.im)).collect();
    assert_multipliers(&two, &expected);
}

/// The force that holds a mass on its floor changes its sign at once: at that instant the floor lets go. The mass flies for half a period,
/// and falls; when and how fast it lands first is known by the flows in closed form.
#[test]
fn a_force_that_jumps_opens_a_contact() {
    let text = "[flight]\nx = 'v'\nv = '-1 - 0.1*v + 1.5*sign(sin(0.9*t)) - 0.5*x'\n[[contact]]\nname = 'floor'\ngap = 'x'\n\
                impulse = { v = 1 }\nrestitution = 0.4\n[initial]\nx = 0.1\nv = 0\n";
    let found = orbit(&with(text, &[]));
    assert!((found.period.to_f64() - TAU / 0.9).abs() < 1e-12);
    assert_eq!(found.impacts, None);
    assert!(found.start.iter().take(2).all(|x| x.to_f64() == 0.0));
    let mut margins = found.margins.iter();
    let first = margins.find(|margin| margin.kind == MarginKind::ImpactRate);
    let first = first.unwrap();
    assert!((first.time - 4.635_877_997_452_521).abs() < 1e-10);
    assert!((first.value - 2.974_877_162_491_91).abs() < 1e-10);
    assert_multipliers(&found, &[(0.0, 0.0), (0.0, 0.0)]);
}

/// Two masses on springs, with friction each, driven in phase: both turn at one instant.
fn in_phase(friction: &str) -> String {
    let mass = |x: &str, v: &str, other: &str, w: &str| {
        let friction = friction.replace("OTHER", &format!("sign({w})"));
        format!(
            "{x} = '{v}'\n{v} = '-{x} - 0.1*{v} - 0.35*({x} - {other}) + 2*cos(0.9*t) - {friction}*sign({v})'\n"
        )
    };
    let (one, two) = (mass("x", "u", "y", "v"), mass("y", "v", "x", "u"));
    format!("[flight]\n{one}{two}[initial]\nx = 0.1\nu = 0\ny = 0.1\nv = 0\n")
}

/// Friction of each is its own: motion in phase and out of phase shrinks by itself, the latter on a stiffer spring. By SciPy: the orbit of
/// one mass by shooting, multipliers by exponentials of both flows with the jump of rates where they turn.
#[test]
fn masses_that_turn_at_one_instant_have_multipliers_of_their_own() {
    let found = orbit(&with(&in_phase("0.3"), &[]));
    assert!(
        (found.period.to_f64() - TAU / 0.9).abs() < 1e-12,
        "{:?}",
        found.period
    );
    let of_one = (0.503_222_840_981_955, 0.406_806_841_791_574);
    let apart = (-0.611_633_750_621_197, 0.211_256_217_223_1);
    let both = [of_one, apart].map(|(re, im)| [(re, im), (re, -im)]);
    assert_multipliers(&found, &both.concat());
}

/// Where the friction of one depends on which way the other goes, the order in which they turn matters.
#[test]
fn corners_whose_order_matters_are_refused() {
    let found = settles(&with(&in_phase("(0.3 + 0.1*OTHER)"), &[]));
    assert!(
        matches!(found, Err(PeriodicError::OrderOfCorners { .. })),
        "{found:?}"
    );
}

/// A block on a shaken floor, which an event slows down where its corner changes: volumes shrink by r^2 at each, in flight not at all.
#[test]
fn a_jump_at_a_corner_is_kept() {
    let text = include_str!("../../../../../../models/rocking_block.toml");
    let found = orbit(&with(text, &[("r", "0.9")]));
    let product = found.multipliers.iter().fold((1.0, 0.0), |(re, im), m| {
        (re * m.re - im * m.im, re * m.im + im * m.re)
    });
    assert!((product.0 - 0.9_f64.powi(4)).abs() < 1e-12, "{product:?}");
    assert!(product.1.abs() < 1e-12, "{product:?}");
}

/// A pendulum that an event kicks where its dry friction changes sides, told from a section that is that very surface, or from elsewhere.
#[test]
fn a_section_at_the_corner_of_an_event_tells_the_same_orbit() {
    let of = |section: &str| {
        let text = format!(
            "[flight]\nx = 'v'\nv = '-x - 0.05*v - 0.1*sign(x)'\n[[event]]\nsurface = 'x'\ndirection = 'rising'\n\
             reset = {{ v = 'v + 0.1' }}\n[initial]\nx = 1\nv = 0\n[section.s]\nsurface = '{section}'\ndirection = 'rising'\n"
        );
        let found = orbit(&with(&text, &[]));
        let [only] = found.multipliers[..] else {
            panic!("{:?}", found.multipliers)
        };
        (found.period.to_f64(), only.re)
    };
    let (period, multiplier) = of("v");
    for section in ["x", "2*x", "-v"] {
        let (other, same) = of(section);
        assert!((other / period - 1.0).abs() < 1e-12, "{section}: {other}");
        assert!((same - multiplier).abs() < 1e-11, "{section}: {same}");
    }
}

/// What a clock resets while a ramp ends and a square wave turns round: the orbit is told from a state that comes back.
#[test]
fn an_orbit_is_told_from_after_all_that_happens_at_an_instant() {
    for damping in ["0.0283124", "0.03", "0.0371", "0.041"] {
        let from = |x: f64, v: f64, t: f64| {
            format!(
                "[flight]\nx = 'v'\nv = '0.4*sign(sin(t)) + 0.2*mod(t/(2*pi), 1) - x - {damping}*v'\n[[event]]\nsurface = 'sin(t)'\n\
                 direction = 'rising'\nreset = {{ v = '-0.8*v' }}\n[initial]\nx = {x:?}\nv = {v:?}\nt = {t:?}\n"
            )
        };
        let found = orbit(&with(&from(0.1, 0.2, 0.0), &[]));
        let [x, v, t] = [0, 1, 2].map(|k| found.start[k].to_f64());
        let again = with(&from(x, v, t), &[]);
        let spec = simulate::Spec::until(t + found.period.to_f64());
        let run = simulate::simulate::<f64>(&again, &spec, &mut |_| ControlFlow::Continue(()));
        let state = run.expect("a motion").state;
        let off = (state[0] - x).abs().max((state[1] - v).abs());
        assert!(off < 1e-10, "{damping}: {off:e}");
    }
}

/// A clock that pushes to the other side and resets at one instant, twice a period, with a section there: which of them is told first is rounding.
#[test]
fn what_is_reset_at_a_corner_of_the_clock_goes_round_once() {
    for damping in ["0.05", "0.0457985", "0.031", "0.043", "0.062"] {
        for section in ["sin(t)", "cos(t)"] {
            let text = format!(
                "[flight]\nx = 'v'\nv = '0.3*sign(sin(t)) - x - {damping}*v'\n[[event]]\nsurface = 'sin(t)'\ndirection = 'either'\n\
                 reset = {{ v = '0.8*v - 0.2*x' }}\n[section.s]\nsurface = '{section}'\ndirection = 'either'\n[initial]\nx = 0\nv = 0\n"
            );
            let found = orbit(&with(&text, &[]));
            let period = found.period.to_f64();
            assert!(
                (period / TAU - 1.0).abs() < 1e-12,
                "{damping} {section}: {period}"
            );
        }
    }
}

/// Events written as multiples of the surface at which dry friction turns, in several units: each period has one of either, at which volumes shrink
/// by the square of the restitution.
#[test]
fn events_beside_the_corner_of_friction_come_once_a_period() {
    for (w, c, r) in [
        (1.05666, 0.03259, 0.53546_f64),
        (1.35689, 0.04849, 0.59466),
        (1.2826, 0.0395, 0.606834),
    ] {
        for unit in [1e-3, 1.0, 1e3] {
            let text = format!(
                "[flight]\nx = 'v/{unit:?}'\nv = '(cos({w}*t/{unit:?}) - x - 0.3*sign(x) - {c}*v)/{unit:?}'\n[[event]]\nname = 'up'\n\
                 surface = '2*x'\ndirection = 'rising'\nreset = {{ v = '{r}*v' }}\n[[event]]\nname = 'down'\nsurface = '-x'\n\
                 direction = 'rising'\nreset = {{ v = '{r}*v' }}\n[section.s]\nsurface = 'v'\ndirection = 'falling'\n\
                 [initial]\nx = 0.3\nv = 0\n"
            );
            let found = orbit(&with(&text, &[]));
            let period = TAU / w;
            let turns = found.period.to_f64() / (period * unit);
            assert!((turns - 1.0).abs() < 1e-12, "{w} {unit}: {turns}");
            let [a, b] = found.multipliers[..] else {
                panic!("{:?}", found.multipliers)
            };
            let product = a.re * b.re - a.im * b.im;
            let expected = r.powi(4) * f64::exp(-c * period);
            assert!((product - expected).abs() < 1e-11, "{w} {unit}: {product}");
        }
    }
}

/// A ball that the floor throws back while gravity changes, in units of time and length: which force at which time has an orbit that lands just
/// as a corner of it comes is known in closed form. The state that it begins in is that of the orbit.
fn thrown_back(
    (restitution, rate): (f64, f64),
    force: &str,
    by: &str,
) -> Vec<Result<Orbit, PeriodicError>> {
    let units = [(1.0, 1.0), (1e-3, 1e3), (1e3, 1e-3), (0.37, 25.4)];
    let of = |(unit, length): (f64, f64)| {
        let floor = match by {
            "contact" => format!(
                "[[contact]]\nname = 'floor'\ngap = 'x'\nimpulse = {{ v = 1 }}\nrestitution = {restitution:?}\n"
            ),
            _ => format!(
                "[[event]]\nname = 'floor'\nsurface = 'x'\ndirection = 'falling'\nreset = {{ v = '-{restitution:?}*v' }}\n"
            ),
        };
        let force = force.replace("TIME", &format!("(t/{unit:?})"));
        let text = format!(
            "[flight]\nx = 'v/{unit:?}'\nv = '({length:?}*({force}))/{unit:?}'\n{floor}\
             [initial]\nx = 0\nv = {:?}\nt = 0\n",
            rate * length
        );
        settles(&with(&text, &[]))
    };
    units.map(of).into()
}

/// Struck at the switch of a square wave, or where a ramp begins anew: just before, gravity is another one than just after, and of displaced
/// motion that lands sooner and that lands later the derivatives have traces 2.75 and -0.25.
#[test]
fn an_impact_at_a_jump_of_the_force_has_no_one_derivative() {
    for (laws, force) in [
        ((0.5, 2.0 / 3.0), "-1 + 2/3*sign(sin(pi*TIME))"),
        ((0.8, 4.0 / 3.0), "-1 - mod(TIME/2, 1)"),
    ] {
        for by in ["contact", "event"] {
            for found in thrown_back(laws, force, by) {
                let is_refused = matches!(found, Err(PeriodicError::OrderOfCorners { .. }));
                assert!(is_refused, "{force} {by}");
            }
        }
    }
}

/// Where the force goes on without a jump at its corner, it does not matter which comes first: the matrix of one impact by gravity 0.1 and of a
/// flight for a time of 2 has the trace 2*(1.5*0.1/0.4) - 2*0.5.
#[test]
fn an_impact_at_a_corner_of_the_force_has_one_derivative() {
    for by in ["contact", "event"] {
        for found in thrown_back((0.5, 0.2), "-0.1 - 0.2*pi*max(-sin(pi*TIME), 0)", by) {
            let found = found.unwrap();
            let im = (0.25_f64 - 0.125 * 0.125).sqrt();
            assert_multipliers(&found, &[(-0.125, im), (-0.125, -im)]);
        }
    }
}

/// A ball that is kicked by a clock just as it lands: either order leads to one state, since both are multiples of its rate, and yet what lands a
/// little sooner is kicked after the impact, and what lands later before it, when it is faster. No such orbit is told.
#[test]
fn an_impact_at_the_kick_of_a_clock_has_no_one_derivative() {
    let mut refused = 0;
    for unit in [1e-3, 1.0, 1e3] {
        let text = format!(
            "[flight]\nx = 'v/{unit:?}'\nv = '-1/{unit:?}'\n[[contact]]\nname = 'floor'\ngap = 'x'\nimpulse = {{ v = 1 }}\n\
             restitution = 0.8\n[[event]]\nsurface = 'sin(pi*t/{unit:?})'\ndirection = 'rising'\nreset = {{ v = '1.25*v' }}\n\
             [initial]\nx = 2\nv = 0\nt = 0\n"
        );
        match settles(&with(&text, &[])) {
            Err(PeriodicError::OrderOfCorners { .. }) => refused += 1,
            // By a rounding it comes to rest, which is another one.
            found => assert_eq!(found.unwrap().impacts, Some(0), "{unit}"),
        }
    }
    assert!(refused > 0);
}

/// A clock throws a ball up that has chattered to rest, as fast as a third state says, which it changes, too: that state alone is remembered.
/// The throw opens the contact, which is no event of its own.
#[test]
fn an_event_that_opens_a_contact_ends_complete_chatter() {
    for (unit, length) in [(1e-3, 1.0), (1.0, 1e3), (1e3, 1e-3)] {
        let text = format!(
            "[flight]\ny = 'v/{unit:?}'\nv = '-{length:?}/{unit:?}'\nz = '-0.3*z/{unit:?}'\nc = '1/{unit:?}'\n\
             [[contact]]\nname = 'floor'\ngap = 'y'\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
             [[event]]\nname = 'throw'\nsurface = 'c - 6'\ndirection = 'rising'\n\
             reset = {{ c = 0, v = '{length:?}*(1 + 0.2*z)', z = '0.5*z + 1' }}\n[initial]\ny = {length:?}\nv = 0\nz = 1\nc = 0\n"
        );
        let found = orbit(&with(&text, &[]));
        assert_eq!(found.impacts, None);
        assert!((found.period.to_f64() / unit - 6.0).abs() < 1e-12);
        let kept = (-1.8_f64).exp();
        let after = 1.0 / (1.0 - 0.5 * kept);
        let start: Vec<f64> = found.start.iter().map(|x| x.to_f64()).collect();
        assert!((start[2] - after).abs() < 1e-13, "{start:?}");
        assert!((start[1] / length - 1.0 - 0.2 * kept * after).abs() < 1e-13);
        assert_multipliers(&found, &[(0.5 * kept, 0.0), (0.0, 0.0), (0.0, 0.0)]);
    }
}

/// A platform rises slowly with a ball that rests on it, and is let down at once: the ball falls by its height, 0.5, and chatters to rest
/// before the next time.
#[test]
fn what_rests_after_chatter_may_lose_its_ground() {
    for unit in [1e-3, 1.0, 1e3] {
        let text = format!(
            "[parameters]\ng = 1\n[flight]\ny = 'v/{unit:?}'\nv = '-g/{unit:?}'\nh = '0.05/{unit:?}'\n[[contact]]\nname = 'platform'\n\
             gap = 'y - h'\nimpulse = {{ v = 1 }}\nrestitution = 0.5\n\
             [[event]]\nsurface = 'h - 0.5'\ndirection = 'rising'\nreset = {{ h = 'h - 0.5' }}\n[initial]\ny = 1\nv = 0\nh = 0\n"
        );
        let found = orbit(&with(&text, &[]));
        assert!((found.period.to_f64() / unit - 10.0).abs() < 1e-12);
        assert_eq!(found.impacts, None);
        // The rate of a gap is one of the model's time.
        let rates = found.margins.iter();
        let mut rates = rates.filter(|margin| margin.kind == MarginKind::ImpactRate);
        assert!(rates.any(|margin| (margin.value * unit - 1.0).abs() < 1e-12));
        assert_multipliers(&found, &[(0.0, 0.0), (0.0, 0.0)]);

        // Over gravity it keeps its period.
        let branches = over(&with(&text, &[]), "g", (0.8, 1.2), (8, 0.5));
        let [branch] = &branches[..] else {
            panic!("{unit}");
        };
        let keeps = |point: &Point| {
            point.is_stable()
                && point.impacts.is_none()
                && (point.period / unit - 10.0).abs() < 1e-10
        };
        assert!(branch.points.iter().all(keeps));
        assert_eq!(branch.ends, [End::Range, End::Range]);
    }
}
