//! Figs. 2, 3 and 4: the universal function and the orbits of its map.

use super::{Advance, Plate, WIDTH, sweep};
use crate::diagram::InMemory;
use crate::failure::Failure;
use crate::parallel;
use crate::universal::picture;
use chatter::analysis::diagram::{Range, Spec, Start};
use chatter::analysis::universal::{Universal, UniversalMap};
use chatter_figures::{Figure, Panel};

/// The paper's slope CAB in Figs. 3 and 4.
const SLOPE: f64 = 1.0;
/// Iterates passed over and shown for each mu, as in the paper.
const TRANSIENT: u64 = 500;
const SHOWN: u64 = 500;
/// Upper ends of mu in the panels of Fig. 3. The paper prints no numbers on its axes that survive; a decade from panel to
/// panel shows the scaling best.
const RANGES: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
/// Values of mu in a panel of Fig. 3, and in Fig. 4.
const COLUMNS: u64 = 2000;
const FINE_COLUMNS: u64 = 3000;
/// Fig. 4: from before the end of one chaotic attractor to within the chaos of the next.
const ENLARGED: (f64, f64) = (0.0047, 0.0056);

/// Upsilon.
pub fn fig2(universal: &Universal<f64>) -> Plate {
    let [lap, whole] = picture::upsilon_panels(universal);
    Plate {
        name: "fig2",
        label: "Fig. 2",
        caption: "The universal function for $r = 0.8$. (a) $(g - 1/2) P^2$ over $Q$ for $u_1$ from $g^{-1}(3/8)$ to \
                  $3/8$, one lap; the slope at its end is infinite. (b) $\\Upsilon(x)$ over all laps, down to laps too \
                  narrow to be seen. Evaluated by power series on each lap, 401 points a lap, crowded at its end."
            .to_owned(),
        figure: Figure::new()
            .panel(lap)
            .panel(whole)
            .columns(2)
            .width(WIDTH)
            .title("Fig. 2: the universal function"),
    }
}

fn panel(
    map: &UniversalMap<f64>,
    (from, to): (f64, f64),
    columns: u64,
    advance: &Advance,
) -> Result<Panel, Failure> {
    let spec = Spec {
        start: Start::CarryUp,
        // The last iterate is carried through the whole range, as in the paper.
        ..Spec::new(
            Range::linear("mu", from, to, columns),
            "z",
            TRANSIENT,
            SHOWN,
        )
    };
    let (sweep, rows) = sweep(map, &spec, advance)?;
    let source = &mut InMemory::new(&sweep, &rows);
    picture::orbit_panel(&sweep, source)
}

fn map(universal: &Universal<f64>) -> Result<UniversalMap<f64>, Failure> {
    UniversalMap::new(universal.clone(), SLOPE, 0.0).map_err(Failure::input)
}

/// Orbit diagrams over four ranges of mu.
pub fn fig3(universal: &Universal<f64>, advance: &Advance) -> Result<Plate, Failure> {
    let map = map(universal)?;
    let panels = parallel::each(&RANGES, |&to| {
        panel(&map, (0.0, to), COLUMNS, &|part| {
            advance(part / RANGES.len() as f64);
        })
    })?;
    let figure = Figure::new().columns(2).width(WIDTH);
    let figure = panels.into_iter().fold(figure, Figure::panel);
    Ok(Plate {
        name: "fig3",
        label: "Fig. 3",
        caption: format!(
            "Orbits of $z \\to \\Upsilon(K z + \\mu)$ with $K = 1$, $r = 0.8$, over four ranges of $\\mu$ that decrease \
             by tens. For each of {COLUMNS} values of $\\mu$ a panel, {SHOWN} iterates after {TRANSIENT}; $\\mu$ \
             increases from 0 and the last iterate is carried on. As $\\mu$ decreases $n$ grows, $\\Upsilon$ gets \
             flatter, and fixed points take the place of chaos."
        ),
        figure: figure.title("Fig. 3: orbits of the universal map"),
    })
}

/// An enlargement of the first panel of Fig. 3.
pub fn fig4(universal: &Universal<f64>, advance: &Advance) -> Result<Plate, Failure> {
    let panel = panel(&map(universal)?, ENLARGED, FINE_COLUMNS, advance)?;
    let (from, to) = ENLARGED;
    Ok(Plate {
        name: "fig4",
        label: "Fig. 4",
        caption: format!(
            "Enlargement of Fig. 3 (a), $\\mu$ from {from} to {to}: {FINE_COLUMNS} values, {SHOWN} iterates after \
             {TRANSIENT} for each, the last one carried on. At the left the chaotic attractor of one $n$ ends where an \
             unstable periodic orbit grazes; the fixed point of the next doubles its period, again and again, into \
             chaos with periodic windows."
        ),
        figure: Figure::from(panel)
            .width(WIDTH)
            .title("Fig. 4: enlargement of Fig. 3 (a)"),
    })
}
