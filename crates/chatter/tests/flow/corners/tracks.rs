//! Tracks and cams whose shape changes at the origin of what it is a function of: there a place is known to what rounding has left of it,
//! and a gap is a difference of next to nothing.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::numerics::{DoubleDouble, Real};

/// Pseudo-random numbers from zero to one.
fn random(seed: &mut u64) -> f64 {
    *seed = seed
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 53) as f64
}

struct Track {
    /// Its height over x.
    shape: &'static str,
    height: fn(f64, f64) -> f64,
    /// How fast x changes, and what it comes to.
    speed: &'static str,
    place: fn(f64, f64, f64) -> f64,
}

const FOOT: Track = Track {
    shape: "h*max(x, 0)^2",
    height: |h, x| h * x.max(0.0).powi(2),
    speed: "w",
    place: |x0, w, t| w * t - x0,
};
const TO_AND_FRO: Track = Track {
    speed: "w*cos(t)",
    place: |x0, w, t| w * t.sin() - x0,
    ..FOOT
};
const CUBES: Track = Track {
    shape: "h*abs(x)^3",
    height: |h, x| h * x.abs().powi(3),
    ..TO_AND_FRO
};
const DOWN: Track = Track {
    shape: "if(x > 0, -h*x^2, 0)",
    height: |h, x| -h * x.max(0.0).powi(2),
    ..FOOT
};

/// What slides along a track without leaving it: where it is, and no event but those of the corner.
fn stays<R: Real>(track: &Track, length: f64, seed: &mut u64) {
    let (w, x0) = (0.1 + 2.0 * random(seed), 0.05 + random(seed));
    let h = 0.05 + 0.3 * random(seed);
    let until = if track.speed == "w" {
        (x0 + 0.3) / w
    } else {
        6.0
    };
    // Lengths in another unit.
    let (g, h, w, x0) = (20.0 * length, h / length, w * length, x0 * length);
    let (h, cubed) = match track.shape.contains("^3") {
        true => (h / length, true),
        false => (h, false),
    };
    let (shape, speed) = (track.shape, track.speed);
    let y0 = (track.height)(h, -x0);
    let start = if cubed { "h*x0^3" } else { "0" };
    let rate = if cubed { "-3*h*x0^2*w" } else { "0" };
    let text = format!(
        "[parameters]\nw = {w:?}\nh = {h:?}\nx0 = {x0:?}\n[flight]\ny = \"v\"\nv = \"-{g:?}\"\nx = \"{speed}\"\n\
         [[contact]]\ngap = \"y - {shape}\"\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n\
         [initial]\ny = \"{start}\"\nv = \"{rate}\"\nx = \"-x0\"\n"
    );
    let run = run::<R>(&text, until);
    assert_eq!(run.outcome, Outcome::Horizon, "{text}");
    let counts = &run.counts;
    let others = [counts.impacts, counts.releases, counts.grazes];
    assert_eq!(others, [0; 3], "{text}");
    let expected = (track.height)(h, (track.place)(x0, w, until));
    let error = run.state[0].to_f64() - expected;
    let size = y0.abs().max(expected.abs()).max(1e-3 * length);
    assert!(error.abs() < 1e-13 * size, "{error:e}\n{text}");
}

#[test]
fn what_slides_along_a_track_stays_on_it_at_its_corner() {
    let mut seed = 8;
    for track in [FOOT, TO_AND_FRO, CUBES, DOWN] {
        for length in [1.0, 1e-3, 1e3] {
            for _ in 0..10 {
                stays::<f64>(&track, length, &mut seed);
            }
        }
        stays::<DoubleDouble>(&track, 1.0, &mut seed);
    }
}

/// A cam that an event turns back by a turn at a time, against which a spring presses a follower.
#[test]
fn a_cam_whose_angle_is_put_back_lifts_its_follower_turn_by_turn() {
    let mut seed = 3;
    for _ in 0..20 {
        let (w, h) = (
            1.0 + 2.0 * random(&mut seed),
            0.01 + 0.05 * random(&mut seed),
        );
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"-400*y - 20\"\nth = {w:?}\n[[contact]]\n\
             gap = \"y - {h:?}*if(th < 1.5, sin(pi*th/1.5)^2, 0)\"\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n\
             [[event]]\nsurface = \"th - 2*pi\"\ndirection = \"rising\"\nreset = {{ th = \"th - 2*pi\" }}\n\
             [initial]\ny = 0\nv = 0\nth = 5\n"
        );
        let run = run::<f64>(&text, 12.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        assert_eq!((run.counts.impacts, run.counts.releases), (0, 0), "{text}");
        let angle = (5.0 + 12.0 * w) % core::f64::consts::TAU;
        let lift = if angle < 1.5 {
            h * (core::f64::consts::PI * angle / 1.5).sin().powi(2)
        } else {
            0.0
        };
        let error = run.state[0] - lift;
        assert!(error.abs() < 1e-13, "{error:e}\n{text}");
    }
}
