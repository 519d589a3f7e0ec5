//! Rows of bodies that rub on the ground and stick together: more modes than can be asked one after the other.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::flow::Occurrence;

/// Blocks on dry ground, each pulled by a spring and, with stiffness k, by its neighbours (Burridge and Knopoff), at rest first.
fn chain(stiffness: f64, places: &[f64]) -> String {
    let (mut field, mut initial) = (String::new(), String::new());
    for (k, place) in places.iter().enumerate() {
        let mut force = format!("0.1*t - x{k} - sign(v{k})");
        let mut pull = |other: usize| force += &format!(" + {stiffness}*(x{other} - x{k})");
        if k + 1 < places.len() {
            pull(k + 1);
        }
        if k > 0 {
            pull(k - 1);
        }
        field += &format!("x{k} = \"v{k}\"\nv{k} = \"{force}\"\n");
        initial += &format!("x{k} = {place:?}\nv{k} = 0\n");
    }
    format!("[flight]\n{field}[initial]\n{initial}")
}

fn places(count: usize) -> Vec<f64> {
    (0..count)
        .map(|k| 0.2 * libm::sin(1.7 * k as f64 + 0.3))
        .collect()
}

/// Blocks that do not pull each other move as each does alone.
#[test]
fn blocks_beside_each_other_stick_and_slip_as_alone() {
    let places = places(9);
    let all = run::<f64>(&chain(0.0, &places), 30.0);
    assert_eq!(all.outcome, Outcome::Horizon);
    for (k, &place) in places.iter().enumerate() {
        let alone = run::<f64>(&chain(0.0, &[place]), 30.0);
        for (i, &right) in alone.state[..2].iter().enumerate() {
            assert!((all.state[2 * k + i] - right).abs() < 1e-12, "{k} {i}");
        }
    }
}

/// Times at which seven blocks begin and cease to slip, from DOP853 with the law of friction decided by hand.
#[test]
fn a_chain_of_blocks_slips_when_it_should() {
    let right = [
        (0.730_005_287_7, 4, false),
        (1.118_522_880_8, 1, false),
        (1.277_122_646_5, 3, false),
        (2.311_271_415_4, 6, false),
        (2.854_665_886_5, 2, true),
        (2.858_340_652_5, 6, true),
        (3.028_127_750_1, 3, true),
        (6.003_758_975_0, 2, false),
        (6.158_456_500_3, 2, true),
    ];
    let run = run::<f64>(&chain(3.0, &places(7)), 9.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    assert_eq!(run.events.len(), right.len());
    for (event, (time, block, leaves)) in run.events.iter().zip(right) {
        assert!((event.time - time).abs() < 1e-9, "{}", event.time);
        let (surface, left) = match event.detail {
            Occurrence::Slide { surface } => (surface, false),
            Occurrence::Leave { surface, .. } => (surface, true),
            _ => panic!("{:?}", event.detail),
        };
        assert_eq!((surface, left), (block, leaves));
    }
}

/// Of two blocks that rub on the ground and on each other, one pulled by 0.1 t slips once that is more than what holds it: the ground,
/// and either the other block or what holds that. Which of the three frictions holds how much before is not determined, and does not
/// matter.
#[test]
fn blocks_that_rub_each_other_hold_as_much_as_both_can() {
    for unit in [1.0, 0.37, 123.4] {
        for (a, b, c) in [
            (0.5, 0.4, 0.3),
            (0.36, 0.545, 0.386),
            (0.2, 0.1, 0.7),
            (0.3, 0.9, 0.25),
        ] {
            let text = format!(
                "[flight]\nx = \"{unit}*u\"\nu = \"{unit}*(0.1*{unit}*t - {a}*sign(u) - {c}*sign(u - v))\"\n\
                y = \"{unit}*v\"\nv = \"{unit}*(-{b}*sign(v) + {c}*sign(u - v))\"\n[initial]\nx = 0\nu = 0\ny = 0\nv = 0\n"
            );
            let slips = 10.0 * (a + f64::min(b, c));
            let run = run::<f64>(&text, 1.2 * slips / unit);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let left = (run.events.iter())
                .rfind(|event| matches!(event.detail, Occurrence::Leave { .. }))
                .expect("one slips");
            assert!(
                (left.time * unit - slips).abs() < 1e-12 * slips,
                "{} {slips} {text}",
                left.time
            );
            // What moves then has no friction to wait for.
            let moved = run.state[0];
            let mass = if c < b { 1.0 } else { 2.0 };
            let rest: f64 = 0.2 * slips;
            let right = 0.1 * rest.powi(3) / 6.0 / mass;
            assert!(
                (moved - right).abs() < 1e-12 * right,
                "{moved} {right} {text}"
            );
        }
    }
}

/// Whether two surfaces change the field one by one does not depend on what numbers leave of what cancels in them.
#[test]
fn blocks_rest_in_every_unit_of_time() {
    for k in 0..40 {
        let unit = 0.013 * 1.37_f64.powi(k);
        let text = format!(
            "[flight]\nx = \"{unit:.6}*v\"\nv = \"{unit:.6}*(0.3*cos(1.3*{unit:.6}*t) - 0.31*x - 0.65*sign(v) - 0.65*sign(v - w))/1.17\"\n\
            y = \"{unit:.6}*w\"\nw = \"{unit:.6}*(-2.06*y + 0.65*sign(v - w))/0.67\"\n[initial]\nx = 0.2\nv = 0\ny = 0.1\nw = 0\n"
        );
        let run = run::<f64>(&text, 10.0 / unit);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        assert!(run.events.is_empty(), "{text}");
        assert_eq!(run.state[..4], [0.2, 0.0, 0.1, 0.0], "{text}");
    }
}

/// Two bodies that rub on a belt that swings, on the ground and on each other, the ground by a law with a small speed: alike in all units,
/// mirrored or not, though exp(-427 v) exceeds all else where v is negative. The end by implicit steps of Euler's, two of them for the order.
#[test]
fn bodies_that_rub_move_alike_in_all_units() {
    let end = |time: f64, [x, v, y, w]: [f64; 4]| {
        let [p, u, q, s] = [x, v, y, w].map(|unit| format!("({unit:?})"));
        let text = format!(
            "[flight]\nx = \"{time:?}/{p}*{u}*v\"\nv = \"{time:?}/{u}*(-2.16*({p}*x) + 1.11*cos(1.69*({time:?}*t)) \
             - 0.53*sign({u}*v - 0.2*sin({time:?}*t)) - 0.71*sign({u}*v - {s}*w))/0.61\"\n\
             y = \"{time:?}/{q}*{s}*w\"\nw = \"{time:?}/{s}*(-2.79*({q}*y) + 0.93*cos(1.95*({time:?}*t) + 1) \
             - 0.77*(0.6 + 0.4*exp(-abs({s}*w)))*sign({s}*w) - 7*max({q}*y - 0.3, 0) + 0.71*sign({u}*v - {s}*w))/1.7\"\n\
             [initial]\nx = \"-0.16/{p}\"\nv = 0\ny = \"0.4/{q}\"\nw = \"-0.67/{s}\"\n"
        );
        let run = run::<f64>(&text, 12.0 / time);
        assert_eq!(run.outcome, Outcome::Horizon, "{time} {x} {v} {y} {w}");
        [run.state[0] * x, run.state[2] * y]
    };
    let expected = end(1.0, [1.0; 4]);
    for (right, own) in IMPLICIT.iter().zip(expected) {
        assert!((right - own).abs() < 5e-6, "{own} {right}");
    }
    for (time, units) in [
        (
            59.952_167_356_205_52,
            [0.192_537_7, 23.669_339, -0.024_075_56, -426.836_093],
        ),
        (
            59.952_167_356_205_52,
            [0.192_537_7, 23.669_339, 0.024_075_56, 426.836_093],
        ),
        (0.037, [1.0, -3000.0, 0.5, 7e4]),
    ] {
        for (other, own) in end(time, units).into_iter().zip(expected) {
            assert!(
                (other - own).abs() < 1e-12,
                "{time} {units:?}: {other} {own}"
            );
        }
    }
}

/// Places of both bodies at t = 12, from steps of 1e-3 and 5e-4.
const IMPLICIT: [f64; 2] = [0.006_203_88, -0.084_133_58];

/// Two dry frictions hand over where their surfaces meet: v is monotone in what acts on it, so there is one motion. From pi/2 on it is
/// held along 0.2 cos t, as 0.25 - 0.4 - 0.8 l = -0.2 sin t has solutions |l| <= 1.
#[test]
fn frictions_hand_over_where_their_surfaces_meet() {
    let text = "[flight]\nv = \"0.25 - 0.8*sign(v - 0.2*cos(t)) - 0.4*sign(v - 0.3*cos(t))\"\n[initial]\nv = 0.3\n";
    for until in [2.0, 3.0, 4.0] {
        let run = run::<f64>(text, until);
        assert_eq!(run.outcome, Outcome::Horizon);
        assert!((run.state[0] - 0.2 * libm::cos(until)).abs() < 1e-15);
    }
    for k in 0..40 {
        let push = -1.0 + 0.05 * f64::from(k);
        let text = format!(
            "[flight]\nv = \"{push:?} - 0.8*sign(v - 0.2*cos(t)) - 0.2*sign(v - 0.3*cos(t))\"\n[initial]\nv = 0.25\n"
        );
        let run = run::<f64>(&text, 12.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{push}");
        assert!((run.state[0] - implicit(push, 12.0)).abs() < 2e-3, "{push}");
    }
}

/// The same by implicit steps: each is the zero of a function that rises.
fn implicit(push: f64, until: f64) -> f64 {
    const STEPS: u32 = 12_000;
    let h = until / f64::from(STEPS);
    let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
    (1..=STEPS).fold(0.25, |v, k| {
        let cosine = libm::cos(h * f64::from(k));
        let (mut low, mut high) = (v - 3.0 * h, v + 3.0 * h);
        for _ in 0..40 {
            let at = 0.5 * (low + high);
            let force = push - 0.8 * sign(at - 0.2 * cosine) - 0.2 * sign(at - 0.3 * cosine);
            if at - v - h * force > 0.0 {
                high = at;
            } else {
                low = at;
            }
        }
        0.5 * (low + high)
    })
}

/// Wagons that run onto each other as those in front brake harder: they stop together, and stand, each by its own brake or held by others,
/// whatever their masses and brakes.
#[test]
fn bodies_that_press_on_each_other_slide_to_rest_together() {
    let slope = 0.02;
    let mut stopped = 0;
    for k in 0..24 {
        let part = |i: u32| (f64::from(k * 5 + i) * 0.618_033_988_749_894_9).fract();
        let mass: [f64; 3] = core::array::from_fn(|i| 2.0 + part(i as u32));
        let least = [0.06, 0.11, 0.16];
        let brake: [f64; 3] = core::array::from_fn(|i| least[i] + 0.04 * part(3 + i as u32));
        let count = if k % 2 == 0 { 2 } else { 3 };
        let (mut field, mut contacts, mut initial) = (String::new(), String::new(), String::new());
        for i in 0..count {
            field += &format!(
                "x{i} = \"v{i}\"\nv{i} = \"9.81*{slope} - 9.81*{:?}*sign(v{i})\"\n",
                brake[i]
            );
            initial += &format!("x{i} = 0\nv{i} = 2\n");
            if i > 0 {
                contacts += &format!(
                    "[[contact]]\nname = \"buffer{i}\"\ngap = \"x{i} - x{}\"\nimpulse = {{ v{} = {:?}, v{i} = {:?} }}\nrestitution = 0.2\n",
                    i - 1,
                    i - 1,
                    -1.0 / mass[i - 1],
                    1.0 / mass[i],
                );
            }
        }
        let text = format!("[flight]\n{field}{contacts}[initial]\n{initial}");
        let run = run::<f64>(&text, 9.0);
        let of = |weigh: &dyn Fn(usize) -> f64| (0..count).map(weigh).sum::<f64>();
        let slows = 9.81 * of(&|i| mass[i] * (brake[i] - slope)) / of(&|i| mass[i]);
        let way = 2.0 * 2.0 / (2.0 * slows);
        if run.outcome == Outcome::Horizon {
            stopped += 1;
            for i in 0..count {
                let (x, v) = (run.state[2 * i], run.state[2 * i + 1]);
                assert!((x - way).abs() < 1e-11, "{k}: {x} {way}");
                assert!(v.abs() < 1e-13, "{k}: {v}");
            }
        }
    }
    assert_eq!(stopped, 24);
}

/// Crates that touch and stand, each by its own friction, are pushed by a force that grows: the first alone holds it, then those behind help, and
/// all go off at once when it exceeds what all hold.
#[test]
fn crates_that_touch_stand_until_the_push_exceeds_the_friction_of_all() {
    for k in 0..24 {
        let part = |i: u32| (f64::from(k * 7 + i) * 0.618_033_988_749_894_9).fract();
        let count = 2 + k as usize % 2;
        let (mut field, mut contacts, mut initial) = (String::new(), String::new(), String::new());
        let (mut mass, mut holds) = (0.0, 0.0);
        let mut before = 0.0;
        for i in 0..count {
            let (own, mu) = (1.0 + 2.0 * part(i as u32), 0.1 + 0.3 * part(3 + i as u32));
            let push = if i == 0 {
                format!("4*t/{own:?} - ")
            } else {
                "-".to_owned()
            };
            field += &format!("x{i} = \"v{i}\"\nv{i} = \"{push}9.81*{mu:?}*sign(v{i})\"\n");
            initial += &format!("x{i} = 0\nv{i} = 0\n");
            if i > 0 {
                contacts += &format!(
                    "[[contact]]\nname = \"touch{i}\"\ngap = \"x{i} - x{}\"\nimpulse = {{ v{} = {:?}, v{i} = {:?} }}\nrestitution = 0\n",
                    i - 1,
                    i - 1,
                    -1.0 / before,
                    1.0 / own,
                );
            }
            (mass, holds, before) = (mass + own, holds + own * mu * 9.81, own);
        }
        let text = format!("[flight]\n{field}{contacts}[initial]\n{initial}");
        let goes_off = holds / 4.0;
        let run = run::<f64>(&text, goes_off + 1.5);
        assert_eq!(run.outcome, Outcome::Horizon, "{k}");
        let way = 4.0 * 1.5_f64.powi(3) / (6.0 * mass);
        for i in 0..count {
            let off = run.state[2 * i] - way;
            assert!(off.abs() < 1e-11, "{k}: {off:e}");
        }
    }
}

/// Three wagons that touch, each with its own brake, are pushed by a force that rises as a t to a T and falls again. They move as one from
/// t1 = S/a on, S being all friction and M all mass, for 2 + sqrt(2) times D = T - t1, by a D^3 (1 + 2 sqrt(2)/3)/M. Before and after that
/// friction holds them, and what force is left between them ends unnoticed.
#[test]
fn wagons_that_touch_are_pushed_and_stop_together() {
    let sets = [
        ([0.69, 1.25, 1.4], [0.24, 0.39, 1.41], 0.61, 3.9),
        ([1.92, 1.43, 1.05], [0.86, 1.06, 0.56], 0.71, 5.22),
        ([1.03, 1.39, 0.85], [1.24, 1.33, 0.37], 1.2, 3.03),
        ([0.62, 1.84, 1.14], [0.39, 1.08, 0.46], 1.85, 1.26),
        ([0.55, 0.8, 1.02], [0.81, 1.38, 1.11], 1.01, 3.62),
        ([1.61, 0.79, 0.59], [0.98, 1.36, 0.24], 1.71, 1.8),
    ];
    for unit in [1.0, 0.37, 730.0, 1e-3, 25.4] {
        for (mass, brake, rise, top) in sets {
            let mut text = String::from("[flight]\n");
            for k in 0..3 {
                let push = match k {
                    0 => format!("max(0, min({rise}*t/{unit}, {rise}*(2*{top} - t/{unit})))"),
                    _ => "0".to_owned(),
                };
                let (m, f) = (mass[k], brake[k]);
                text += &format!(
                    "x{k} = \"v{k}/{unit}\"\nv{k} = \"({push} - {f}*sign(v{k}))/{m}/{unit}\"\n"
                );
            }
            for k in 0..2 {
                let (a, b) = (mass[k], mass[k + 1]);
                text += &format!(
                    "[[contact]]\nname = \"buffer{k}\"\ngap = \"x{} - x{k}\"\nimpulse = {{ v{k} = \"-1/{a}\", v{} = \"1/{b}\" }}\n\
                     restitution = 0\n",
                    k + 1,
                    k + 1
                );
            }
            text += "[initial]\nx0 = 0\nv0 = 0\nx1 = 0\nv1 = 0\nx2 = 0\nv2 = 0\n";
            let run = run::<f64>(&text, (2.0 * top + 1.0) * unit);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let (friction, all): (f64, f64) = (brake.iter().sum(), mass.iter().sum());
            let pushed = top - friction / rise;
            let moved = rise * pushed.powi(3) * (1.0 + 2.0 * 2.0_f64.sqrt() / 3.0) / all;
            for k in 0..3 {
                assert!(
                    (run.state[2 * k] - moved).abs() < 1e-13,
                    "{moved} {:?}",
                    run.state
                );
                assert_eq!(run.state[2 * k + 1], 0.0);
            }
        }
    }
}

/// Three wagons that touch are pushed by A sin(w t) at the first of them: as one, until they stop; then the first is pulled off, and the
/// others stay where they are. What lies between two wagons that both stand by their brakes has no force, and goes on to touch when the
/// wagon before it leaves.
#[test]
fn wagons_that_stand_touch_on_when_the_one_before_them_is_pulled_off() {
    let (mass, brake) = ([0.85, 1.36, 1.29], [4.28, 0.68, 5.86]);
    let (all, friction): (f64, f64) = (mass.iter().sum(), brake.iter().sum());
    let (push, rate) = (13.9_f64, 5.5_f64);
    // Speed and way of a mass under the push and a steady force since a time.
    let speed = |m: f64, f: f64, from: f64, t: f64| {
        (push / rate * ((rate * from).cos() - (rate * t).cos()) - f * (t - from)) / m
    };
    let way = |m: f64, f: f64, from: f64, t: f64| {
        let swing =
            (rate * from).cos() * (t - from) - ((rate * t).sin() - (rate * from).sin()) / rate;
        (push / rate * swing - f * (t - from).powi(2) / 2.0) / m
    };
    let starts = (friction / push).asin() / rate;
    let (mut before, mut after) = (starts + 0.2, 0.6);
    for _ in 0..100 {
        let middle = (before + after) / 2.0;
        match speed(all, friction, starts, middle) > 0.0 {
            true => before = middle,
            false => after = middle,
        }
    }
    let stand = way(all, friction, starts, before);
    let leaves = (std::f64::consts::PI + (brake[0] / push).asin()) / rate;
    let end = 1.2;
    assert!(speed(mass[0], -brake[0], leaves, end) < 0.0);
    let pulled = stand + way(mass[0], -brake[0], leaves, end);
    for unit in [1.0, 1e-3, 25.4, 730.0] {
        let mut text = String::from("[flight]\n");
        for k in 0..3 {
            let (m, f) = (mass[k], brake[k]);
            let push = if k == 0 {
                format!("{push}*sin({rate}*t/{unit})")
            } else {
                "0".to_owned()
            };
            text += &format!(
                "x{k} = \"v{k}/{unit}\"\nv{k} = \"({push} - {f}*sign(v{k}))/{m}/{unit}\"\n"
            );
        }
        for k in 0..2 {
            let (a, b, next) = (mass[k], mass[k + 1], k + 1);
            text += &format!(
                "[[contact]]\nname = \"buffer{k}\"\ngap = \"x{next} - x{k}\"\nimpulse = {{ v{k} = \"-1/{a}\", v{next} = \"1/{b}\" }}\n\
                 restitution = 0\n"
            );
        }
        text += "[initial]\nx0 = 0\nv0 = 0\nx1 = 0\nv1 = 0\nx2 = 0\nv2 = 0\n";
        let run = run::<f64>(&text, end * unit);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        for (k, expected) in [pulled, stand, stand].into_iter().enumerate() {
            let off = run.state[2 * k] - expected;
            assert!(off.abs() < 1e-13, "{unit} {k}: {off:e}");
        }
        let released: Vec<(usize, f64)> = (run.events.iter())
            .filter_map(|event| match event.detail {
                Occurrence::Release { contact } => Some((contact, event.time)),
                _ => None,
            })
            .collect();
        assert_eq!(released.len(), 1, "{released:?}");
        assert_eq!(released[0].0, 0);
        assert!((released[0].1 / unit - leaves).abs() < 1e-12);
    }
}

/// Two parcels that touch, each on its belt: the belt behind slows down and takes its parcel along, the one in front stays at its speed. They part
/// as both speeds are the same, with the acceleration of the belt behind.
#[test]
fn parcels_part_where_their_belts_do() {
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
        let speed = 0.8 * long / short;
        let rub = 5.0 * long / (short * short);
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-{rub:?}*sign(v - {speed:?}*(1 - 0.4*(t/{short:?} - 0.5)))\"\n\
             y = \"u\"\nu = \"-{rub:?}*sign(u - {speed:?})\"\n\
             [[contact]]\nname = \"g\"\ngap = \"y - x\"\nimpulse = {{ v = -1, u = 1 }}\nrestitution = 0.2\n\
             [initial]\nx = 0\nv = {:?}\ny = 0\nu = {:?}\n",
            1.2 * speed,
            1.2 * speed
        );
        let run = run::<f64>(&text, 2.0 * short);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        let behind = |t: f64| 0.8 * (t - 0.2 * ((t - 0.5) * (t - 0.5) - 0.25));
        for (place, right) in [(0, behind(2.0)), (2, behind(0.5) + 0.8 * 1.5)] {
            let off = run.state[place] / long - right;
            assert!(off.abs() < 1e-13, "{off:e} {text}");
        }
        let opened: Vec<f64> = (run.events.iter())
            .filter(|event| matches!(event.detail, Occurrence::Release { .. }))
            .map(|event| event.time / short)
            .collect();
        assert!(
            matches!(opened[..], [at] if (at - 0.5).abs() < 1e-13),
            "{opened:?} {text}"
        );
    }
}

/// One belt slows down behind the other's: two parcels in contact, each at rest on its belt, are pushed together from then on. The
/// one in front slides on its belt, pushed by the other, which its own belt holds as long as its friction is the greater; else the one
/// behind slides, held up by the one in front.
#[test]
fn parcels_that_belts_push_together_go_on_in_contact() {
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (25.4, 60.0), (1e3, 1.0)] {
        for (behind, ahead) in [(5.0, 4.0), (4.0, 5.0), (7.0, 0.5)] {
            let speed = 0.8 * long / short;
            let unit = long / (short * short);
            let text = format!(
                "[flight]\nx = \"v\"\nv = \"-{:?}*sign(v - {speed:?})\"\n\
                 y = \"u\"\nu = \"-{:?}*sign(u - {speed:?}*(1 - 0.4*max(t/{short:?} - 0.5, 0)))\"\n\
                 [[contact]]\nname = \"g\"\ngap = \"y - x\"\nimpulse = {{ v = -1, u = 1 }}\nrestitution = 0.2\n\
                 [initial]\nx = 0\nv = {speed:?}\ny = 0\nu = {speed:?}\n",
                behind * unit,
                ahead * unit
            );
            let run = run::<f64>(&text, 2.0 * short);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let front = 0.8 * (2.0 - 0.2 * 1.5 * 1.5);
            let right = if behind > ahead { 0.8 * 2.0 } else { front };
            for place in [0, 2] {
                let off = run.state[place] / long - right;
                assert!(off.abs() < 1e-13, "{off:e} {text}");
            }
            let is_parted = run.events.iter().any(|event| {
                matches!(
                    event.detail,
                    Occurrence::Release { .. } | Occurrence::Impact { .. }
                )
            });
            assert!(!is_parted, "{:?} {text}", run.events);
        }
    }
}
