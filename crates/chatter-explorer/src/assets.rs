//! The page: files that stand in `page/`, as they are.

/// One file of the page.
#[derive(Clone, Copy, Debug)]
pub struct Asset {
    /// Its address behind the token.
    pub path: &'static str,
    /// Its media type.
    pub kind: &'static str,
    /// What it holds.
    pub text: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";

macro_rules! page {
    ($($path:literal: $kind:ident,)*) => {
        &[$(Asset {
            path: $path,
            kind: $kind,
            text: include_str!(concat!("../page/", $path)),
        },)*]
    };
}

/// All of it.
pub const PAGE: &[Asset] = page! {
    "index.html": HTML,
    "icon.svg": PICTURE,
    "page.css": CSS,
    "style.css": CSS,
    "address.js": SCRIPT,
    "explorer.js": SCRIPT,
    "main.js": SCRIPT,
    "starts.js": SCRIPT,
    "state.js": SCRIPT,
    "widget.js": SCRIPT,
    "asking/commands.js": SCRIPT,
    "asking/records.js": SCRIPT,
    "asking/transport.js": SCRIPT,
    "diagram/box.js": SCRIPT,
    "diagram/classes.js": SCRIPT,
    "diagram/controls.js": SCRIPT,
    "diagram/lattice.js": SCRIPT,
    "diagram/place.js": SCRIPT,
    "diagram/plane.js": SCRIPT,
    "diagram/question.js": SCRIPT,
    "diagram/rows.js": SCRIPT,
    "diagram/view.js": SCRIPT,
    "drawing/axes.js": SCRIPT,
    "drawing/curves.js": SCRIPT,
    "drawing/input.js": SCRIPT,
    "drawing/labels.js": SCRIPT,
    "drawing/palette.js": SCRIPT,
    "drawing/plot.js": SCRIPT,
    "drawing/raster.js": SCRIPT,
    "drawing/ticks.js": SCRIPT,
    "elements/dom.js": SCRIPT,
    "elements/editor.js": SCRIPT,
    "elements/knobs.js": SCRIPT,
    "elements/panel.js": SCRIPT,
    "motion/history.js": SCRIPT,
    "motion/impacts.js": SCRIPT,
    "motion/mechanism.js": SCRIPT,
    "motion/motion.js": SCRIPT,
    "motion/portrait.js": SCRIPT,
    "motion/return-curve.js": SCRIPT,
    "motion/returns.js": SCRIPT,
    "motion/shapes.js": SCRIPT,
    "motion/sound.js": SCRIPT,
    "theory/curves.js": SCRIPT,
    "theory/drawing.js": SCRIPT,
    "theory/overlay.js": SCRIPT,
    "theory/special.js": SCRIPT,
};

/// What is at this address; at the empty one the page itself.
pub fn find(path: &str) -> Option<&'static Asset> {
    let path = if path.is_empty() { "index.html" } else { path };
    PAGE.iter().find(|asset| asset.path == path)
}
