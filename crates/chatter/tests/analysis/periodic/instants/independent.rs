//! Contacts that do not feel each other: what one of them does beside the other is nothing that happens to the orbit.

use crate::periodic::{nearest, over, value, with};
use chatter::analysis::border::BorderSpec;
use chatter::analysis::border_search::border_near;
use chatter::analysis::periodic::{End, SpecialKind};
use chatter::model::Model;

/// A ball on a shaken table, which comes to rest on it in each period, and others beside it: they are all thrown at one instant, and hit it again at another.
fn balls(restitutions: &[&str]) -> Model {
    let mut text =
        "[parameters]\nG = 1.06\n[section.strobe]\nsurface = 'sin(t)'\ndirection = 'rising'\n"
            .to_owned();
    let mut initial = "[initial]\n".to_owned();
    let mut flight = "[flight]\n".to_owned();
    for (k, restitution) in restitutions.iter().enumerate() {
        flight += &format!("y{k} = 'v{k}'\nv{k} = -1\n");
        initial += &format!("y{k} = {}\nv{k} = 0\n", 1.0 + 0.4 * k as f64);
        text += &format!(
            "[[contact]]\nname = 'ball{k}'\ngap = 'y{k} - G*sin(t)'\nimpulse = {{ v{k} = 1 }}\nrestitution = {restitution}\n"
        );
    }
    with(&format!("{text}{flight}{initial}"), &[])
}

#[test]
fn balls_on_one_table_are_followed_as_each_of_them_is() {
    for (second, start, range, longest) in [
        ("0.35", "1.06", (1.05, 1.3), 0.1),
        ("0.2", "1.06", (1.05, 1.1), 0.3),
        ("0.1", "1.08", (1.05, 1.1), 0.1),
    ] {
        let mut model = balls(&["0.5", second]);
        model.set_parameter("G", start).unwrap();
        let found = over(&model, "G", range, (8, longest));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{second}");
        assert!(found[0].special.is_empty(), "{second} {:?}", found[0]);
    }
}

#[test]
fn a_ball_beside_another_has_its_own_border() {
    let mut model = balls(&["0.5", "0.35"]);
    model.set_parameter("G", "1.3").unwrap();
    let found = over(&model, "G", (1.29, 1.62), (8, 0.1));
    let border = nearest(&found, &[SpecialKind::ChatterBorder], 1.6);
    let alone = border_near::<f64>(&balls(&["0.5"]), &BorderSpec::new("G"), 1.6).unwrap();
    let off = (value(&border) - alone.value.value).abs();
    assert!(off <= border.error, "{border:?} {alone:?}");
}
