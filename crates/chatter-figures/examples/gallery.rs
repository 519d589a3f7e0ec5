//! Draws one figure of each kind, as SVG, PDF and PNG, into the folder given (the current one by default).

use std::path::PathBuf;

use chatter_figures::Error;
use chatter_figures::*;

fn main() -> Result<(), Error> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| ".".to_string()));
    for (name, figure) in [
        ("history", history()),
        ("portrait", portrait()),
        ("diagram", diagram()),
        ("powers", powers()),
        ("offset", offset()),
        ("maps", maps()),
        ("kinds", kinds()),
    ] {
        for format in ["svg", "pdf", "png"] {
            figure.write(folder.join(format!("{name}.{format}")))?;
        }
    }
    Ok(())
}

struct History {
    t: Vec<f64>,
    x: Vec<f64>,
    v: Vec<f64>,
    rests: Vec<(f64, f64)>,
}

/// A ball that bounces to rest, is thrown up and bounces again: displacement and velocity with phases of contact.
fn bouncing() -> History {
    let (mut t, mut x, mut v) = (Vec::new(), Vec::new(), Vec::new());
    let mut rests = Vec::new();
    let mut now = 0.0;
    for _ in 0..3 {
        let mut up: f64 = 3.0;
        while up > 1e-3 {
            let flight = 2.0 * up;
            for k in 0..=200 {
                let s = flight * f64::from(k) / 200.0;
                t.push(now + s);
                x.push(up * s - 0.5 * s * s);
                v.push(up - s);
            }
            now += flight;
            up *= 0.6;
        }
        rests.push((now, now + 4.0));
        t.extend([now, now + 4.0]);
        x.extend([0.0, 0.0]);
        v.extend([0.0, 0.0]);
        now += 4.0;
    }
    History { t, x, v, rests }
}

fn history() -> Figure {
    let History { t, x, v, rests } = bouncing();
    let landings = rests.iter().map(|r| r.0).collect::<Vec<_>>();
    let zeros = vec![0.0; landings.len()];
    Figure::new()
        .sharing(Sharing::Horizontal)
        .panel(
            Panel::new(
                Axis::new("time $t$").tight(),
                Axis::new("displacement $y_1$"),
            )
            .with(Spans::new(rests.clone()).label("contact"))
            .with(Line::new(t.clone(), x).label("$y_1$"))
            .with(
                Markers::new(landings, zeros)
                    .marker(Marker::Circle)
                    .color(Color::VERMILION)
                    .label("accumulation"),
            ),
        )
        .panel(
            Panel::new(
                Axis::new("time $t$").tight(),
                Axis::new("velocity $\\dot{y}_1$"),
            )
            .with(Spans::new(rests))
            .with(Rule::horizontal(0.0))
            .with(Line::new(t, v)),
        )
}

fn portrait() -> Figure {
    let n = 200_000;
    let (mut x, mut v, mut t) = (0.3, 0.0, 0.0);
    let (mut xs, mut vs) = (Vec::new(), Vec::new());
    let h = 0.002;
    for _ in 0..n {
        let a = -0.1 * v - x + libm::cos(0.8 * t);
        v += h * a;
        x += h * v;
        t += h;
        if x > 0.5 && v > 0.0 {
            v *= -0.8;
        }
        if t > 150.0 {
            xs.push(x);
            vs.push(v);
        }
    }
    Figure::from(
        Panel::new(
            Axis::new("displacement $x$").unit("mm"),
            Axis::new("velocity $\\dot{x}$").unit("mm/s"),
        )
        .with(Rule::vertical(0.5).label("stop $x = \\sigma$"))
        .with(Line::new(xs, vs).width(0.6).label("attractor")),
    )
}

fn logistic(low: f64, high: f64) -> impl Iterator<Item = (f64, f64)> {
    (0..4000u32).flat_map(move |k| {
        let r = low + (high - low) * f64::from(k) / 3999.0;
        let mut x = 0.5;
        for _ in 0..500 {
            x = r * x * (1.0 - x);
        }
        (0..2500).map(move |_| {
            x = r * x * (1.0 - x);
            (r, x)
        })
    })
}

fn diagram() -> Figure {
    let mut density = Density::new((3.4, 4.0), (0.0, 1.0)).normalisation(Normalisation::Column);
    density.extend(logistic(3.4, 4.0));
    let mut zoom = Density::new((3.82, 3.86), (0.1, 1.0)).normalisation(Normalisation::Column);
    zoom.extend(logistic(3.82, 3.86));
    Figure::new()
        .height(110.0)
        .panel(Panel::new(Axis::new("$\\mu$").tight(), Axis::new("$z$").tight()).with(density))
        .panel(Panel::new(Axis::new("$\\mu$").tight(), Axis::new("$z$").tight()).with(zoom))
        .title("Orbit diagram")
        .caption("Logistic map, 4000 parameter values, 2500 iterates each after 500")
}

fn powers() -> Figure {
    let x: Vec<f64> = (0..60)
        .map(|k| libm::pow(10.0, -8.0 + 0.15 * f64::from(k)))
        .collect();
    let y = |p: f64| x.iter().map(|&x| libm::pow(x, p)).collect::<Vec<_>>();
    Figure::from(
        Panel::new(
            Axis::new("distance $\\mu - \\mu^*$").logarithmic(),
            Axis::new("$\\Upsilon(\\mu)$").logarithmic(),
        )
        .with(Line::new(x.clone(), y(1.2)).label("$\\mu^{6/5}$"))
        .with(
            Line::new(x.clone(), y(2.0))
                .dash(Dash::Dashed)
                .label("$\\mu^2$"),
        )
        .with(
            Markers::new(
                x.iter().copied().step_by(6).collect(),
                y(1.2).into_iter().step_by(6).collect(),
            )
            .label("computed"),
        ),
    )
}

fn offset() -> Figure {
    let x: Vec<f64> = (0..=1000).map(|k| 0.0203 + 1e-10 * f64::from(k)).collect();
    let y = x
        .iter()
        .map(|&q| 9.7 + 1e-5 * libm::sin(4e8 * (q - 0.0203)))
        .collect();
    Figure::from(
        Panel::new(
            Axis::new("flow rate $q$").tight(),
            Axis::new("pressure $y_3$"),
        )
        .with(Line::new(x, y)),
    )
}

fn maps() -> Figure {
    let x: Vec<f64> = (0..160).map(|k| f64::from(k) / 40.0 - 2.0).collect();
    let y: Vec<f64> = (0..120).map(|k| f64::from(k) / 40.0 - 1.5).collect();
    let mut values = Vec::new();
    let mut cells = Vec::new();
    for &b in &y {
        for &a in &x {
            values.push(libm::sin(3.0 * a) * libm::cos(2.0 * b) - 0.3 * a);
            cells.push((a * a + b * b > 0.1).then_some(((a * a + b * b) * 1.5) as usize % 4));
        }
    }
    let categories = vec![
        Category::new("period 1", Color::BLUE),
        Category::new("period 2", Color::SKY),
        Category::new("chaotic", Color::ORANGE),
        Category::new("complete chatter", Color::VERMILION),
    ];
    Figure::new()
        .columns(2)
        .width(178.0)
        .height(62.0)
        .panel(
            Panel::new(Axis::new("$\\omega$"), Axis::new("$\\sigma$").tight()).with(
                HeatMap::new(x.clone(), y.clone(), values)
                    .colormap(Colormap::Diverging { centre: 0.0 })
                    .axis(Axis::new("Lyapunov exponent $\\lambda$")),
            ),
        )
        .panel(
            Panel::new(
                Axis::new("$\\omega$").tight(),
                Axis::new("$\\sigma$").tight(),
            )
            .with(CategoryMap::new(x, y, cells, categories)),
        )
}

fn kinds() -> Figure {
    let mut panel = Panel::new(
        Axis::new("$x$").reversed(),
        Axis::new("large numbers $N$").unit("Pa"),
    )
    .title("Markers and dashes");
    let markers = [
        Marker::Disc,
        Marker::Circle,
        Marker::Square,
        Marker::Triangle,
        Marker::Diamond,
        Marker::Cross,
        Marker::Plus,
    ];
    for (k, marker) in (0u32..).zip(markers) {
        let x: Vec<f64> = (0..12).map(f64::from).collect();
        let y = x
            .iter()
            .map(|x| 1e6 * (f64::from(k) + 0.3 * libm::sin(*x)))
            .collect();
        panel.add(
            Markers::new(x, y)
                .marker(marker)
                .size(4.0)
                .label(format!("{marker:?}")),
        );
    }
    for (k, dash) in (0u32..).zip([Dash::Solid, Dash::Dashed, Dash::Dotted, Dash::DashDotted]) {
        let x = vec![0.0, 11.0];
        panel.add(
            Line::new(x, vec![-1e6 - 5e5 * f64::from(k); 2])
                .dash(dash)
                .label(format!("{dash:?}")),
        );
    }
    Figure::from(panel)
}
