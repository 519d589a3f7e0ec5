//! Branches of limit cycles that shrink to an equilibrium: where a pair of eigenvalues is imaginary, by closed forms.

use super::{over, value, with};
use chatter::analysis::periodic::{Branch, End, SpecialKind};

fn system(parameters: &str, (x, y): (&str, &str), section: &str, start: (f64, f64)) -> String {
    format!(
        "[parameters]\n{parameters}\n[flight]\nx = \"{x}\"\ny = \"{y}\"\n[section.s]\nsurface = \"{section}\"\ndirection = \"falling\"\n\
         [initial]\nx = {}\ny = {}\n",
        start.0, start.1
    )
}

fn of(branch: &Branch, kind: SpecialKind) -> Vec<f64> {
    let all = branch.special.iter().filter(|special| special.kind == kind);
    all.map(value).collect()
}

/// r = sqrt(mu), and x'' = (mu - x^2) x' - x, whose branch leaves mu = 0 upright: nothing but the point itself, at all steps.
#[test]
fn a_limit_cycle_ends_where_it_is_born() {
    let normal_form = ("mu*x - y - x*(x^2 + y^2)", "x + mu*y - y*(x^2 + y^2)");
    let van_der_pol = ("y", "(mu - x^2)*y - x");
    for (field, step) in [
        (normal_form, 0.01),
        (normal_form, 0.003),
        (van_der_pol, 0.02),
    ] {
        let model = with(&system("mu = 0.5", field, "y", (1.0, 0.0)), &[]);
        let found = over(&model, "mu", (-0.5, 1.0), (8, step));
        let branch = &found[0];
        assert_eq!(
            branch.ends,
            [End::Equilibrium, End::Range],
            "{field:?} {step}"
        );
        let [hopf] = &branch.special[..] else {
            panic!("{field:?} {step}: {}", branch.special.len());
        };
        assert_eq!(hopf.kind, SpecialKind::Hopf);
        assert!(
            value(hopf).abs() <= hopf.error && hopf.error < 1e-13,
            "{}",
            value(hopf)
        );
        assert!((hopf.point.period - core::f64::consts::TAU).abs() < 1e-12);
        assert!(hopf.point.state.iter().all(|x| x.abs() < 1e-12));
        // Each orbit once.
        let values: Vec<f64> = branch
            .points
            .iter()
            .map(|point| point.parameter())
            .collect();
        assert!(
            values.windows(2).all(|pair| pair[0] < pair[1]),
            "{field:?} {step}"
        );
    }
}

/// r' = mu r + r^3 (1 - r^2): a fold at r^2 = 1/2, mu = -1/4, and from there to mu = 0.
#[test]
fn a_limit_cycle_that_is_born_unstable_folds_once() {
    let x = "mu*x - y + x*(x^2 + y^2)*(1 - x^2 - y^2)";
    let y = "x + mu*y + y*(x^2 + y^2)*(1 - x^2 - y^2)";
    let model = with(&system("mu = 0.5", (x, y), "y", (1.0, 0.0)), &[]);
    let branch = &over(&model, "mu", (-0.5, 1.0), (8, 0.01))[0];
    assert_eq!(branch.ends, [End::Equilibrium, End::Range]);
    let (folds, hopfs) = (of(branch, SpecialKind::Fold), of(branch, SpecialKind::Hopf));
    assert_eq!((folds.len(), hopfs.len(), branch.special.len()), (1, 1, 2));
    assert!((folds[0] + 0.25).abs() < 1e-13 && hopfs[0].abs() < 1e-13);
}

/// FitzHugh and Nagumo: v^2 = 1 - eps b, w = (v + a)/b, I = w - v + v^3/3. The section goes through the equilibrium at the upper point alone; where
/// the orbit no longer crosses it, beyond a fold, it is told from planes across the flow.
#[test]
fn away_from_zero_the_point_is_where_eigenvalues_say() {
    let (eps, a, b) = (0.5_f64, 0.7, 0.8);
    let v = (1.0 - eps * b).sqrt();
    let expected = [-v, v].map(|v| (v + a) / b - v + v.powi(3) / 3.0);
    let field = ("x - x^3/3 - y + I", "0.5*(x + 0.7 - 0.8*y)");
    let section = format!("x - {v:?}");
    let model = with(&system("I = 0.8", field, &section, (1.0, 0.0)), &[]);
    for step in [0.01, 0.004] {
        let branch = &over(&model, "I", (0.2, 1.6), (8, step))[0];
        let both = [End::Equilibrium, End::Equilibrium];
        assert_eq!(branch.ends, both, "{step}: {:?}", branch.ends);
        let (hopfs, folds) = (of(branch, SpecialKind::Hopf), of(branch, SpecialKind::Fold));
        assert_eq!((hopfs.len(), folds.len()), (2, 2), "{step}");
        for (hopf, expected) in hopfs.iter().zip(expected) {
            assert!((hopf - expected).abs() < 1e-13, "{step}: {hopf} {expected}");
        }
    }
}

/// Roessler's limit cycle does not cross y = 0 where it is small: from there on it is told from planes across the flow. The equilibrium is
/// x = a s, y = -s, z = s with a s^2 - c s + b = 0.
#[test]
fn a_limit_cycle_that_leaves_its_section_is_followed_to_where_it_is_born() {
    let text = "[parameters]\na = 0.2\nb = 0.2\nc = 2.5\n[flight]\nx = \"-y - z\"\ny = \"x + a*y\"\nz = \"b + z*(x - c)\"\n\
                [section.y]\nsurface = \"y\"\ndirection = \"falling\"\n[initial]\nx = 2\ny = 1\nz = 0.1\n";
    // Routh and Hurwitz: of l^3 + p l^2 + q l + r a pair is imaginary where p q = r.
    let off = |a: f64| {
        let (b, c) = (0.2_f64, 2.5_f64);
        let s = (c - (c * c - 4.0 * a * b).sqrt()) / (2.0 * a);
        let d = a * s - c;
        let (p, q, r) = (-(a + d), a * d + 1.0 + s, -(d + a * s));
        (p * q - r, q)
    };
    let (mut low, mut high) = (0.02, 0.05);
    assert!(off(low).0 * off(high).0 < 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        match off(middle).0 * off(low).0 > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    for step in [0.02, 0.005] {
        let found = over(&with(text, &[]), "a", (-0.1, 0.2), (8, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Equilibrium, End::Range], "{step}");
        let [hopf] = &branch.special[..] else {
            panic!("{step}: {}", branch.special.len());
        };
        assert_eq!(hopf.kind, SpecialKind::Hopf);
        assert!(
            (value(hopf) - low).abs() <= hopf.error.max(1e-13),
            "{} {low}",
            value(hopf)
        );
        let period = core::f64::consts::TAU / off(low).1.sqrt();
        assert!(
            (hopf.point.period - period).abs() < 1e-10,
            "{}",
            hopf.point.period
        );
    }
}

/// Predators are harvested above a threshold y = 1.2: at m = 1/2 the equilibrium of both fields lies on it, x = 1, a focus from which the motion
/// spirals out below and into which it does above. The limit cycle comes to a point there, with no pair of eigenvalues that is imaginary.
#[test]
fn a_limit_cycle_that_shrinks_to_a_corner_ends_there() {
    let field = (
        "x*(1 - x/4) - x*y/(1 + 0.6*x)",
        "0.8*x*y/(1 + 0.6*x) - m*y - 0.3*max(y - 1.2, 0)",
    );
    let model = with(&system("m = 0.35", field, "1.2 - x", (1.0, 1.0)), &[]);
    let branch = &over(&model, "m", (0.2, 0.6), (8, 0.02))[0];
    let [End::Range, End::Shrunk(shrunk)] = &branch.ends else {
        panic!("{:?}", branch.ends);
    };
    let off = (shrunk.value - 0.5).abs();
    assert!(off <= shrunk.error && shrunk.error < 1e-10, "{shrunk:?}");
    let last = branch.points.last().unwrap();
    assert!(
        (last.parameter() - 0.5).abs() < 1e-3,
        "{}",
        last.parameter()
    );
    assert!(
        (last.state[0] - 1.0).hypot(last.state[1] - 1.2) < 1e-2,
        "{:?}",
        last.state
    );
}

/// On a canard of FitzHugh and Nagumo's neuron the parameter all but stands still, as where a period grows without bound; but the orbit does not
/// rest, and it does not.
#[test]
fn a_canard_is_no_period_without_bound() {
    let text = r#"
    [parameters]
    I = 0.5
    [flight]
    v = "v - v^3/3 - w + I"
    w = "0.08*(v + 0.7 - 0.8*w)"
    [section.v]
    surface = "v"
    direction = "rising"
    [initial]
    v = 1.0
    w = 0.0
    "#;
    let found = over(&with(text, &[]), "I", (0.3, 0.5), (4, 0.01));
    let ends = &found[0].ends;
    let unbounded = |end: &End| matches!(end, End::Unbounded(_) | End::Saddle(_));
    assert!(!ends.iter().any(unbounded), "{ends:?}");
}

/// A drill bit whose torque weakens with its rate: at rest against the table that turns it, w = Om, its slope is that of the torque, and a pair
/// is imaginary at c = W (1 - b) vf exp(-vf Om). The orbit leaves its section on the way there, and no fold is left of it.
#[test]
fn no_fold_is_told_where_nothing_is_left_of_an_orbit() {
    for ((om, vf, b, c), start, steps) in [
        (
            (2.486, 0.2527, 0.5432, 0.07564),
            "1.038",
            [0.01, 0.02, 0.05],
        ),
        (
            (2.264, 0.4766, 0.6374, 0.02482),
            "1.154",
            [0.003, 0.01, 0.02],
        ),
    ] {
        let expected = c / ((1.0 - b) * vf * f64::exp(-vf * om));
        let parameters = format!("W = {start}");
        let rate = format!(
            "ph + {c}*({om} - w) - W*({b} + {}*exp(-{vf}*abs(w)))*sign(w)",
            1.0 - b
        );
        let field = format!("{om} - y");
        let rate = rate.replace("ph", "x").replace('w', "y");
        let text = system(&parameters, (&field, &rate), "y - 1", (0.5, 0.5));
        let model = with(&text, &[]);
        for step in steps {
            let branch = &over(&model, "W", (0.3, 2.5), (8, step))[0];
            assert_eq!(branch.ends, [End::Equilibrium, End::Range], "{step}");
            assert_eq!(of(branch, SpecialKind::Fold), [0.0; 0], "{om} {step}");
            let [hopf] = of(branch, SpecialKind::Hopf)[..] else {
                panic!("{om} {step}")
            };
            assert!((hopf - expected).abs() < 1e-13, "{om} {step}: {hopf}");
        }
    }
}

/// Prey, and a predator that is caught above a threshold: over it x = (h K - 1)/(2 h) at the Hopf point, and the catch is what is left of growth
/// there. Long steps turn the plane that the orbit is told from by much.
#[test]
fn a_limit_cycle_is_followed_to_where_it_is_born_by_long_steps() {
    let (k, h, e, m) = (3.994, 0.5831, 0.7, 0.3084);
    let x = (h * k - 1.0) / (2.0 * h);
    let expected = e * x / (1.0 + h * x) - m;
    for (size, steps) in [
        (1e-3, &[0.1][..]),
        (1.0, &[0.01, 0.05, 0.1]),
        (1e3, &[0.05]),
    ] {
        let parameters = "q = 0.5236";
        let prey = format!("x*(1 - x/{k}) - x*y/(1 + {h}*x)");
        let predator = format!("{e}*x*y/(1 + {h}*x) - {m}*y - q*step(y - 0.6573)*y");
        // The same with predators in other units.
        let scaled = |rate: &str| rate.replace('y', &format!("(y/{size:?})"));
        let field = (scaled(&prey), format!("{size:?}*({})", scaled(&predator)));
        let text = system(
            parameters,
            (&field.0, &field.1),
            "x - 0.9",
            (1.0, 0.6 * size),
        );
        let text = text.replace("falling", "rising");
        for &step in steps {
            let found = over(&with(&text, &[]), "q", (0.1, 0.8), (8, step));
            let branch = &found[0];
            assert_eq!(branch.ends, [End::Range, End::Equilibrium], "{size} {step}");
            let [hopf] = of(branch, SpecialKind::Hopf)[..] else {
                panic!("{size} {step}")
            };
            assert!((hopf - expected).abs() < 1e-13, "{size} {step}: {hopf}");
        }
    }
}

/// Fields whose slopes have a corner at the equilibrium are linear there as smooth ones are: orbits shrink on two sides of a surface at once, with
/// p = 3 pi A/8 for y |y|, and as the square of A for x |x|. In all units of length and time.
#[test]
fn a_limit_cycle_on_a_corner_of_the_slopes_ends_where_it_is_born() {
    let resistance = "(p*y/T - x/T^2 - y*abs(y)/L)";
    let stiffness = "(p*y/T - x/T^2*(1 + abs(x)/L) - y*x^2/(L^2*T))";
    let cube = "(p*y/T - x/T^2 - sign(y)*abs(y)^3*T/L^2)";
    for (rate, step, length, time) in [
        (resistance, 0.02, 1.0, 1.0),
        (resistance, 0.01, 1e-3, 1e3),
        (stiffness, 0.02, 1.0, 1.0),
        (stiffness, 0.02, 1e3, 1e-3),
        (cube, 0.02, 1.0, 1.0),
    ] {
        let parameters = format!("p = 0.3\nL = {length:?}\nT = {time:?}");
        let text = system(&parameters, ("y", rate), "x", (0.0, 0.6 * length / time));
        let model = with(&text.replace("falling", "rising"), &[]);
        let range = if length > 1.0 {
            (-0.3, 0.5)
        } else {
            (-0.2, 0.6)
        };
        let found = over(&model, "p", range, (8, step));
        let (branch, told) = (&found[0], (rate, step, length, range));
        assert_eq!(branch.ends, [End::Equilibrium, End::Range], "{told:?}");
        let [hopf] = &branch.special[..] else {
            panic!("{told:?}: {}", branch.special.len());
        };
        assert_eq!(hopf.kind, SpecialKind::Hopf, "{told:?}");
        assert!(
            value(hopf).abs() <= hopf.error && hopf.error < 1e-13,
            "{told:?}: {}",
            value(hopf)
        );
        let period = core::f64::consts::TAU * time;
        assert!((hopf.point.period / period - 1.0).abs() < 1e-12, "{told:?}");
    }
}

/// Resistance as the square of a rate, and a second mode coupled: of (l^2 - p l + 1.3)(l^2 + 0.2 l + 2.3) - 0.09 a pair is imaginary
/// where c (a b - c) = a^2 d.
#[test]
fn of_several_modes_the_pair_that_is_imaginary_tells() {
    let text = "[parameters]\np = 0.3\n[flight]\nx = \"v\"\nv = \"p*v - x - v*abs(v) - 0.3*(x - y)\"\ny = \"w\"\n\
                w = \"-2*y - 0.2*w + 0.3*(x - y)\"\n[section.s]\nsurface = \"x\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0.6\ny = 0\nw = 0\n";
    let off = |p: f64| {
        let (a, b, c, d) = (0.2 - p, 3.6 - 0.2 * p, 0.26 - 2.3 * p, 2.9);
        c * (a * b - c) - a * a * d
    };
    let (mut low, mut high) = (0.0, 0.03);
    assert!(off(low) * off(high) < 0.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        match off(middle) * off(low) > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    for step in [0.02, 0.005] {
        let branch = &over(&with(text, &[]), "p", (-0.1, 0.6), (8, step))[0];
        assert_eq!(branch.ends, [End::Equilibrium, End::Range], "{step}");
        let [hopf] = of(branch, SpecialKind::Hopf)[..] else {
            panic!("{step}")
        };
        assert!((hopf - low).abs() < 1e-13, "{step}: {hopf} {low}");
        assert_eq!(branch.special.len(), 1, "{step}");
    }
}

/// A spline through cubes: its slope at the knot at zero, the same of both pieces, is -1/14.
#[test]
fn a_limit_cycle_at_the_knot_of_a_table_ends_where_it_is_born() {
    let text = system("p = 0.3", ("y", "p*y - x - f(y)"), "x", (0.0, 0.6));
    let table = "[table.f]\nx = [-4, -3, -2, -1, 0, 1, 2, 3, 4]\ny = [-64, -27, -8, -1, 0, 1, 8, 27, 64]\nkind = \"cubic\"\n";
    let text = text.replace("falling", "rising") + table;
    let branch = &over(&with(&text, &[]), "p", (-0.2, 0.6), (8, 0.02))[0];
    assert_eq!(branch.ends, [End::Equilibrium, End::Range]);
    let [hopf] = of(branch, SpecialKind::Hopf)[..] else {
        panic!()
    };
    assert!((hopf + 1.0 / 14.0).abs() < 1e-13, "{hopf}");
}

/// A pendulum whose pivot is shaken, against the square of its rate: doubled orbits shrink onto the state of rest where a multiplier of that is -1,
/// and are no more than touched nowhere.
#[test]
fn doubled_orbits_that_shrink_onto_a_state_of_rest_end_at_its_branch() {
    let damping = 0.1;
    // The trace and the determinant of what x'' = -(1 + h cos 2t) x - c x' does in a period.
    let off = |h: f64| {
        let rate = |t: f64, [x, v]: [f64; 2]| [v, -(1.0 + h * (2.0 * t).cos()) * x - damping * v];
        let steps = 1000;
        let dt = core::f64::consts::PI / f64::from(steps);
        let end = |mut at: [f64; 2]| {
            let by = |at: [f64; 2], k: [f64; 2], part: f64| {
                [at[0] + part * dt * k[0], at[1] + part * dt * k[1]]
            };
            for k in 0..steps {
                let t = f64::from(k) * dt;
                let a = rate(t, at);
                let b = rate(t + 0.5 * dt, by(at, a, 0.5));
                let c = rate(t + 0.5 * dt, by(at, b, 0.5));
                let d = rate(t + dt, by(at, c, 1.0));
                for i in 0..2 {
                    at[i] += dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
                }
            }
            at
        };
        let (first, second) = (end([1.0, 0.0]), end([0.0, 1.0]));
        // det(M + I).
        (first[0] + 1.0) * (second[1] + 1.0) - first[1] * second[0]
    };
    let (mut low, mut high) = (0.15, 0.25);
    assert!(off(low) * off(high) < 0.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        match off(middle) * off(low) > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    for (corner, size, step) in [
        ("v*abs(v)/L", 1.0, 0.02),
        ("v*abs(v)/L", 1e-3, 0.01),
        ("x*abs(x)/L", 1e3, 0.02),
    ] {
        let text = format!(
            "[parameters]\nh = 0.6\nL = {size:?}\n[flight]\nx = \"v\"\nv = \"-(1 + h*cos(2*t))*x - {damping}*v - {corner}\"\n\
             [section.s]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n[initial]\nx = {:?}\nv = {:?}\n",
            0.3 * size,
            0.2 * size
        );
        let branch = &over(&with(&text, &[]), "h", (0.1, 0.8), (8, step))[0];
        let told = (corner, size, step);
        assert_eq!(
            branch.ends,
            [End::Again(SpecialKind::BranchPoint), End::Range],
            "{told:?}"
        );
        let [met] = &branch.special[..] else {
            panic!("{told:?}: {}", branch.special.len());
        };
        assert_eq!(met.kind, SpecialKind::BranchPoint);
        assert!((value(met) - low).abs() < 1e-12, "{told:?}: {}", value(met));
    }
}

/// What an event takes away each time is linear, too: without it a pair would be imaginary at p = 0, and the motion grows as exp(p t/2) and loses
/// a tenth at each turn of x.
#[test]
fn where_jumps_are_linear_eigenvalues_of_the_flight_tell_no_birth() {
    let text = "[parameters]\np = 0.3\n[flight]\nx = \"y\"\ny = \"p*y - x - y*abs(y)\"\n\
                [[event]]\nname = \"e\"\nsurface = \"x\"\ndirection = \"either\"\nreset = { y = \"0.9*y\" }\n[initial]\nx = 0.1\ny = 0.6\n";
    let found = over(&with(text, &[]), "p", (-0.1, 0.6), (8, 0.02));
    let branch = &found[0];
    assert_eq!(of(branch, SpecialKind::Hopf), [0.0; 0]);
    let [End::Shrunk(shrunk), End::Range] = &branch.ends else {
        panic!("{:?}", branch.ends);
    };
    // Where 0.9 exp(p/2 pi/w) = 1 with w = sqrt(1 - p^2/4).
    let slope = -0.9_f64.ln() / core::f64::consts::PI;
    let off = (shrunk.value - 2.0 * slope / slope.hypot(1.0)).abs();
    assert!(off <= shrunk.error && shrunk.error < 1e-13, "{shrunk:?}");
}

/// A wheelset whose lateral and yawing motion are alike: with P = s^2 + (0.3 + 1/V) s + 1 its eigenvalues solve P^2 = -0.6 V. One pair is imaginary where
/// 0.3 + 1/V = sqrt(0.6 V) = d, with the frequency 1, and the other one is -d +- i: both have a multiplier of exp(-2 pi d).
#[test]
fn a_pair_with_the_frequency_of_the_orbit_has_a_real_multiplier_twice() {
    let text = r#"
    [parameters]
    V = 1.6
    [flight]
    y = "v"
    v = "-y - 0.3*v - (v/V - psi)"
    psi = "q"
    q = "-psi - 0.3*q - (q/V + 0.6*V*y) - 0.3*q^3"
    [section.mid]
    surface = "y"
    direction = "rising"
    [initial]
    y = 0.1
    v = 0
    psi = 0.1
    q = 0
    "#;
    let (mut low, mut high) = (1.4_f64, 1.7_f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match 0.3 + 1.0 / middle > (0.6 * middle).sqrt() {
            true => low = middle,
            false => high = middle,
        }
    }
    let other = (-core::f64::consts::TAU * (0.6 * low).sqrt()).exp();
    for start in ["1.55", "1.6"] {
        let found = over(&with(text, &[("V", start)]), "V", (1.5, 1.62), (4, 0.1));
        let hopf = found[0]
            .special
            .iter()
            .find(|s| s.kind == SpecialKind::Hopf);
        let hopf = hopf.unwrap();
        assert!((value(hopf) - low).abs() < 1e-12);
        let [own, pair @ ..] = &*hopf.point.multipliers else {
            panic!("no multipliers");
        };
        assert_eq!((own.re, own.im, pair.len()), (1.0, 0.0, 2));
        assert!((pair.iter()).all(|m| m.im == 0.0 && (m.re / other - 1.0).abs() < 1e-11));
    }
}

/// x'' = mu x' - x' |(x, x')| - x: 3 pi mu / 8 is the amplitude, to first order, and the slopes of the damping have no formula at the origin, wherever that is.
#[test]
fn a_limit_cycle_under_damping_by_a_length_ends_where_it_is_born() {
    for (length, at) in [
        ("hypot(x, y)", 0.0),
        ("sqrt(y^2 + x^2)", 0.0),
        ("hypot(x - 1, y)", 1.0),
    ] {
        let force = format!("mu*y - y*{length} - (x - {at:?})");
        let field = ("y", &*force);
        let section = format!("x - {at:?}");
        for step in [0.01, 0.04] {
            let model = with(&system("mu = 0.2", field, &section, (at + 0.2, 0.0)), &[]);
            let found = over(&model, "mu", (-0.1, 0.4), (8, step));
            let branch = &found[0];
            assert_eq!(
                branch.ends,
                [End::Equilibrium, End::Range],
                "{length} {step}"
            );
            let [hopf] = of(branch, SpecialKind::Hopf)[..] else {
                panic!("{length} {step}: {:?}", branch.special);
            };
            assert!(hopf.abs() < 1e-12, "{length} {step}: {hopf}");
            assert_eq!(branch.special.len(), 1, "{length} {step}");
            let special = &branch.special[0];
            assert!(special.error < 1e-12, "{special:?}");
            assert!((special.point.period - core::f64::consts::TAU).abs() < 1e-12);
            assert!((special.point.state[0] - at).abs() < 1e-12);
        }
    }
}
