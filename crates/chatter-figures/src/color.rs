//! Colours that the colour-blind can tell apart, and scales of colour of even lightness.

/// A colour with opacity, eight bits each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Color {
    /// Red.
    pub r: u8,
    /// Green.
    pub g: u8,
    /// Blue.
    pub b: u8,
    /// Opacity; 255 is opaque.
    pub a: u8,
}

impl Color {
    /// Black.
    pub const BLACK: Color = Color::rgb(0, 0, 0);
    /// White.
    pub const WHITE: Color = Color::rgb(255, 255, 255);
    /// Spines, ticks and text.
    pub const INK: Color = Color::rgb(26, 26, 26);
    /// Reference lines.
    pub const GREY: Color = Color::rgb(140, 140, 140);
    /// Bands behind curves.
    pub const BAND: Color = Color::rgb(222, 227, 234);
    /// Okabe and Ito's blue.
    pub const BLUE: Color = Color::rgb(0, 114, 178);
    /// Okabe and Ito's vermilion.
    pub const VERMILION: Color = Color::rgb(213, 94, 0);
    /// Okabe and Ito's bluish green.
    pub const GREEN: Color = Color::rgb(0, 158, 115);
    /// Okabe and Ito's reddish purple.
    pub const PURPLE: Color = Color::rgb(204, 121, 167);
    /// Okabe and Ito's orange.
    pub const ORANGE: Color = Color::rgb(230, 159, 0);
    /// Okabe and Ito's sky blue.
    pub const SKY: Color = Color::rgb(86, 180, 233);
    /// Points of a density: so dark that a faint shade of it is still seen.
    pub const NIGHT: Color = Color::rgb(8, 28, 66);

    /// An opaque colour.
    pub const fn rgb(r: u8, g: u8, b: u8) -> Self {
        Color { r, g, b, a: 255 }
    }

    /// The same colour with opacity `a` in 0 … 1.
    pub fn opacity(self, a: f64) -> Self {
        Color {
            a: to_byte(a),
            ..self
        }
    }
}

/// The colours of curves in turn (Okabe and Ito 2008, black and yellow left out: the one is the axes', the other pale).
pub const PALETTE: [Color; 6] = [
    Color::BLUE,
    Color::VERMILION,
    Color::GREEN,
    Color::PURPLE,
    Color::ORANGE,
    Color::SKY,
];

/// From a number to a colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Colormap {
    /// Dark blue over green to pale yellow, of evenly rising lightness.
    Sequential,
    /// Blue below the centre, white at it, vermilion above. Where numbers lie on both sides, each has a unit of its own:
    /// exponents of chaos are small beside those of periodic orbits.
    Diverging {
        /// The value that is drawn white.
        centre: f64,
    },
}

impl Colormap {
    /// The colour at `t` in 0 … 1 of the scale, 0.5 being the centre of a diverging one.
    pub fn color(self, t: f64) -> Color {
        let t = t.clamp(0.0, 1.0);
        match self {
            Colormap::Sequential => between(&SEQUENTIAL, t),
            Colormap::Diverging { .. } => between(&DIVERGING, t),
        }
    }

    /// Where `value` stands on the scale from `low` to `high`, 0 … 1.
    pub(super) fn place(self, value: f64, low: f64, high: f64) -> f64 {
        match self {
            Colormap::Sequential => (value - low) / (high - low),
            Colormap::Diverging { centre } if low < centre && centre < high => {
                let side = if value < centre {
                    centre - low
                } else {
                    high - centre
                };
                0.5 + 0.5 * (value - centre) / side
            }
            Colormap::Diverging { centre } => {
                let reach = (high - centre).abs().max((low - centre).abs());
                0.5 + 0.5 * (value - centre) / reach
            }
        }
    }

    /// What stands in the middle of the scale from `low` to `high`, if its sides have units of their own.
    pub(super) fn centre(self, low: f64, high: f64) -> Option<f64> {
        match self {
            Colormap::Diverging { centre } if low < centre && centre < high => Some(centre),
            _ => None,
        }
    }
}

/// Lightness, green–red and blue–yellow of Oklab (Ottosson 2020), in which equal steps look equal.
type Oklab = [f64; 3];

const SEQUENTIAL: [Oklab; 6] = [
    [0.24, 0.030, -0.110],
    [0.39, -0.020, -0.110],
    [0.54, -0.075, -0.045],
    [0.68, -0.110, 0.045],
    [0.82, -0.090, 0.130],
    [0.96, -0.020, 0.090],
];

const DIVERGING: [Oklab; 5] = [
    [0.38, -0.020, -0.130],
    [0.68, -0.045, -0.085],
    [0.985, 0.0, 0.0],
    [0.72, 0.095, 0.085],
    [0.46, 0.145, 0.085],
];

fn between(anchors: &[Oklab], t: f64) -> Color {
    let place = t * (anchors.len() - 1) as f64;
    let k = (place as usize).min(anchors.len() - 2);
    let s = place - k as f64;
    let mix = |i: usize| anchors[k][i] + s * (anchors[k + 1][i] - anchors[k][i]);
    from_oklab([mix(0), mix(1), mix(2)])
}

fn from_oklab([light, a, b]: Oklab) -> Color {
    let cube = |x: f64| x * x * x;
    let l = cube(light + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(light - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(light - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    Color::rgb(
        gamma(4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s),
        gamma(-1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s),
        gamma(-0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s),
    )
}

/// Linear light to an sRGB byte (IEC 61966-2-1).
fn gamma(linear: f64) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    to_byte(if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055
    })
}

fn to_byte(x: f64) -> u8 {
    (255.0 * x.clamp(0.0, 1.0)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (WCAG weights on the encoded values suffice for an order).
    fn luminance(c: Color) -> f64 {
        0.2126 * f64::from(c.r) + 0.7152 * f64::from(c.g) + 0.0722 * f64::from(c.b)
    }

    #[test]
    fn the_sequential_scale_grows_lighter_all_the_way() {
        let steps: Vec<f64> = (0..=50)
            .map(|k| luminance(Colormap::Sequential.color(f64::from(k) / 50.0)))
            .collect();
        assert!(steps.windows(2).all(|w| w[1] > w[0]), "{steps:?}");
        assert!(steps[0] < 50.0 && steps[50] > 220.0);
    }

    #[test]
    fn the_diverging_scale_is_palest_at_its_centre() {
        let map = Colormap::Diverging { centre: 0.0 };
        let at = |x| luminance(map.color(map.place(x, -1.0, 3.0)));
        assert!(at(0.0) > 245.0 && at(-1.0) < 120.0 && at(3.0) < 130.0);
        assert!(at(-0.5) > at(-1.0) && at(1.0) > at(2.0));
        // On one side only there is one unit.
        let one_sided = |x| luminance(map.color(map.place(x, 1.0, 4.0)));
        assert!(one_sided(1.0) > one_sided(2.0) && one_sided(4.0) < 130.0);
    }
}
