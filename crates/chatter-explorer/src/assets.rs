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
    "commands.js": SCRIPT,
    "curves.js": SCRIPT,
    "diagram-classes.js": SCRIPT,
    "diagram-controls.js": SCRIPT,
    "diagram-rows.js": SCRIPT,
    "diagram-view.js": SCRIPT,
    "dom.js": SCRIPT,
    "editor.js": SCRIPT,
    "explorer.js": SCRIPT,
    "history-view.js": SCRIPT,
    "impacts-view.js": SCRIPT,
    "knobs.js": SCRIPT,
    "labels.js": SCRIPT,
    "lattice.js": SCRIPT,
    "main.js": SCRIPT,
    "mechanism-view.js": SCRIPT,
    "motion.js": SCRIPT,
    "overlay-curves.js": SCRIPT,
    "overlay-drawing.js": SCRIPT,
    "overlay.js": SCRIPT,
    "palette.js": SCRIPT,
    "panel.js": SCRIPT,
    "plane.js": SCRIPT,
    "plot.js": SCRIPT,
    "portrait-view.js": SCRIPT,
    "raster.js": SCRIPT,
    "records.js": SCRIPT,
    "return-curve.js": SCRIPT,
    "return-view.js": SCRIPT,
    "sound.js": SCRIPT,
    "special.js": SCRIPT,
    "starts.js": SCRIPT,
    "state.js": SCRIPT,
    "ticks.js": SCRIPT,
    "transport.js": SCRIPT,
    "widget.js": SCRIPT,
};

/// What is at this address; at the empty one the page itself.
pub fn find(path: &str) -> Option<&'static Asset> {
    let path = if path.is_empty() { "index.html" } else { path };
    PAGE.iter().find(|asset| asset.path == path)
}
