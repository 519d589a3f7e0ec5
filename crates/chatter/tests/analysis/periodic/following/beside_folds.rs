//! Neimark-Sacker points beside a fold and a doubling that lie within one step.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::SpecialKind;

/// Fixed points x^2 = p of a map, the multiplier 1 + k x: with k = 1000 it runs from far below -1 to far above 1 within a small part of a step. Beside
/// it a pair whose modulus, rho, is above 1 where |x - c| < 3 w/4 alone, between fold and doubling or beside them: all of it is passed by
/// a step, at whose ends as many multipliers are outside.
#[test]
fn a_pair_that_passes_the_circle_beside_a_fold_and_comes_back_is_told() {
    let text = "[parameters]\np = 0.25\nc = 0\n[flight]\nclock = \"1\"\nx = \"0\"\ny = \"0\"\nz = \"0\"\n[definitions]\n\
        rho = \"sqrt(0.36 + 1/(1 + ((x - c)/0.001)^2))\"\n[[event]]\nname = \"step\"\nsurface = \"clock - 1\"\n\
        direction = \"rising\"\n[event.reset]\nclock = \"0\"\nx = \"x + 500*(x^2 - p)\"\n\
        y = \"rho*(cos(0.8)*y - sin(0.8)*z)\"\nz = \"rho*(sin(0.8)*y + cos(0.8)*z)\"\n\
        [initial]\nclock = 0\nx = -0.5\ny = 0\nz = 0\n";
    for (c, step) in [
        (-0.0012, 0.1),
        (-0.003, 0.1),
        (0.002, 0.1),
        (0.0005, 0.07),
        (-0.0012, 0.2),
    ] {
        let found = over(
            &with(text, &[("c", &*c.to_string())]),
            "p",
            (-0.5, 1.0),
            (8, step),
        );
        let mut expected = vec![
            0.0,
            4e-6,
            (c - 0.00075) * (c - 0.00075),
            (c + 0.00075) * (c + 0.00075),
        ];
        expected.sort_by(f64::total_cmp);
        let mut told: Vec<f64> = found[0].special.iter().map(value).collect();
        told.sort_by(f64::total_cmp);
        assert_eq!(told.len(), 4, "{c} {step} {told:?}");
        for (told, expected) in told.iter().zip(&expected) {
            assert!(
                (told - expected).abs() <= 1e-16,
                "{c} {step} {told:e} {expected:e}"
            );
        }
        let kind = |kind: SpecialKind| found[0].special.iter().filter(|s| s.kind == kind).count();
        let kinds = [
            SpecialKind::Fold,
            SpecialKind::PeriodDoubling,
            SpecialKind::NeimarkSacker,
        ]
        .map(kind);
        assert_eq!(kinds, [1, 1, 2], "{c} {step}");
    }
}

/// A map with the multipliers -1/2 - p, which passes -1 at p = 1/2, and three pairs about -0.9 that go to and fro beyond -1 within roundings of p, but
/// for p < 0.7. On either half of a way as many are beyond -1 as on the whole: halved again and again it is looked at for hours.
#[test]
fn what_rounding_does_to_multipliers_is_not_looked_at_ever_closer() {
    let names = ["a", "b", "c", "d", "e", "f"];
    let mut text = String::from(
        "[parameters]\np = 0.1\n[definitions]\nnoise = \"0.5/(1 + exp(200*(0.8 - p)))\"\n[flight]\nclock = \"1\"\nx = \"0\"\n",
    );
    for name in names {
        text += &format!("{name} = \"0\"\n");
    }
    text += "[[event]]\nname = \"step\"\nsurface = \"clock - 1\"\ndirection = \"rising\"\n[event.reset]\nclock = \"0\"\n\
        x = \"-(0.5 + p)*x\"\n";
    for (name, often) in names
        .iter()
        .zip([1e11, 1e11, 1.3e11, 1.3e11, 1.7e11, 1.7e11])
    {
        text += &format!("{name} = \"(noise*sin({often}*p) - 0.9)*{name}\"\n");
    }
    text += "[initial]\nclock = 0\nx = 0\n";
    for name in names {
        text += &format!("{name} = 0\n");
    }
    let found = over(&with(&text, &[]), "p", (0.0, 1.0), (8, 0.1));
    let told: Vec<f64> = found[0].special.iter().map(value).collect();
    let clean: Vec<&f64> = told.iter().filter(|value| **value < 0.7).collect();
    assert_eq!(clean.len(), 1, "{told:?}");
    assert!((clean[0] - 0.5).abs() < 1e-15, "{told:?}");
    assert!(told.len() < 100, "{}", told.len());
}
