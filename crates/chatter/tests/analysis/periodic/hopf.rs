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

/// FitzHugh and Nagumo: v^2 = 1 - eps b, w = (v + a)/b, I = w - v + v^3/3. The section goes through the equilibrium at the upper point alone; the other
/// end is where the orbit no longer crosses it.
#[test]
fn away_from_zero_the_point_is_where_eigenvalues_say() {
    let (eps, a, b) = (0.5_f64, 0.7, 0.8);
    let v = (1.0 - eps * b).sqrt();
    let expected = (v + a) / b - v + v.powi(3) / 3.0;
    let field = ("x - x^3/3 - y + I", "0.5*(x + 0.7 - 0.8*y)");
    let section = format!("x - {v:?}");
    let model = with(&system("I = 0.8", field, &section, (1.0, 0.0)), &[]);
    for step in [0.01, 0.004] {
        let branch = &over(&model, "I", (0.2, 1.6), (8, step))[0];
        assert_eq!(
            branch.ends[1],
            End::Equilibrium,
            "{step}: {:?}",
            branch.ends
        );
        let hopfs = of(branch, SpecialKind::Hopf);
        assert_eq!(hopfs.len(), 1, "{step}");
        assert!(
            (hopfs[0] - expected).abs() < 1e-13,
            "{step}: {} {expected}",
            hopfs[0]
        );
    }
}
