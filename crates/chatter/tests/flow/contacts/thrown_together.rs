//! Bodies that lie on each other on a table which throws them: nothing parts them in the air.

use chatter::analysis::simulate::{Outcome, Spec, simulate};
use chatter::flow::Occurrence;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use std::ops::ControlFlow;

const GRAVITY: f64 = 9.81;

/// A table A sin(w t): when it throws what lies on it, and when that lands.
fn thrown_and_landed(amplitude: f64, frequency: f64) -> [f64; 2] {
    let (a, w) = (amplitude, frequency);
    let thrown = f64::asin(GRAVITY / (a * w * w)) / w;
    let gap = |t: f64| {
        let rest = t - thrown;
        a * (f64::sin(w * thrown) - f64::sin(w * t)) + a * w * f64::cos(w * thrown) * rest
            - GRAVITY / 2.0 * rest * rest
    };
    let mut landed = thrown + 0.02 * 6.0 / w;
    while gap(landed) > 0.0 {
        landed += 0.001 * 6.0 / w;
    }
    let (mut open, mut closed) = (landed - 0.001 * 6.0 / w, landed);
    for _ in 0..80 {
        let middle = (open + closed) / 2.0;
        *(if gap(middle) > 0.0 {
            &mut open
        } else {
            &mut closed
        }) = middle;
    }
    [thrown, open]
}

/// So many balls, times in units of `unit` seconds.
fn balls(count: usize, [amplitude, frequency]: [f64; 2], unit: f64) -> Model {
    let (frequency, gravity) = (frequency * unit, GRAVITY * unit);
    let (mut states, mut contacts, mut initial) = (String::new(), String::new(), String::new());
    for k in 0..count {
        states += &format!("x{k} = \"{unit}*v{k}\"\nv{k} = \"-{gravity}\"\n");
        let (place, rate) = (0.1 * k as f64, format!("{amplitude}*{frequency}/{unit}"));
        initial += &format!("x{k} = {place}\nv{k} = \"{rate}\"\n");
        let (gap, below) = match k {
            0 => (
                format!("x0 - {amplitude}*sin({frequency}*t)"),
                String::new(),
            ),
            _ => (
                format!("x{k} - x{} - 0.1", k - 1),
                format!("v{} = -1, ", k - 1),
            ),
        };
        contacts += &format!(
            "[[contact]]\nname = \"c{k}\"\ngap = \"{gap}\"\nimpulse = {{ {below}v{k} = 1 }}\nrestitution = 0.6\n"
        );
    }
    let text = format!("[flight]\n{states}{contacts}[initial]\n{initial}");
    Model::from_toml(&text, "balls").unwrap_or_else(|errors| panic!("{errors}"))
}

fn check<R: Real>(count: usize, table: [f64; 2], unit: f64) {
    let [thrown, landed] = thrown_and_landed(table[0], table[1]);
    let model = balls(count, table, unit);
    let spec = Spec::until(landed * 1.000_1 / unit);
    let run =
        simulate::<R>(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("a legal start");
    let at = format!("{count} {table:?} {unit:e}: {:?}", run.outcome);
    assert_eq!(run.outcome, Outcome::Horizon, "{at}");
    let mut events = run.events.iter();
    let [first, second] = [events.next(), events.next()].map(|event| event.expect(&at));
    let is_close = |time: R, right: f64| (time.to_f64() * unit - right).abs() < 1e-10 * right;
    assert!(
        matches!(first.detail, Occurrence::Release { contact: 0 }),
        "{at} {:?}",
        first.detail
    );
    assert!(is_close(first.time, thrown), "{at}");
    assert!(
        matches!(second.detail, Occurrence::Impact { contact: 0, .. }),
        "{at} {:?}",
        second.detail
    );
    assert!(is_close(second.time, landed), "{at}");
}

#[test]
fn what_lies_on_each_other_flies_together() {
    for count in 2..5 {
        for frequency in [1.0, 3.3, 20.0, 314.159] {
            for excess in [1.1, 1.5, 2.2] {
                let table = [excess * GRAVITY / (frequency * frequency), frequency];
                for unit in [1.0, 0.37, 1e-3, 60.0] {
                    check::<f64>(count, table, unit);
                }
                if count == 3 {
                    check::<DoubleDouble>(count, table, 0.37);
                }
            }
        }
    }
}
