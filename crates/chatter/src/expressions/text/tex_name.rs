//! Names of quantities in TeX.

const GREEK: [&str; 35] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
    "lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi",
    "omega", "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi",
    "Omega", "ell",
];

/// A name in TeX's mathematics mode: Greek letters by their command, `y1` and `y_1` with a subscript, a single letter
/// in italics, a word upright.
pub fn tex_name(name: &str) -> String {
    let (stem, subscript) = match name.split_once('_') {
        Some((stem, subscript)) if !stem.is_empty() && !subscript.is_empty() => (stem, subscript),
        _ => {
            let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
            (stem, &name[stem.len()..])
        }
    };
    let letter = |part: &str| {
        if GREEK.contains(&part) {
            format!(r"\{part}")
        } else if part.chars().count() == 1 && part != "_"
            || part.chars().all(|c| c.is_ascii_digit())
        {
            part.to_string()
        } else {
            format!(r"\mathrm{{{}}}", part.replace('_', r"\_"))
        }
    };
    if subscript.is_empty() {
        letter(stem)
    } else {
        format!("{}_{{{}}}", letter(stem), letter(subscript))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_look_as_in_print() {
        let check = |name: &str, expected: &str| assert_eq!(tex_name(name), expected, "{name}");
        check("x", "x");
        check("y1", "y_{1}");
        check("y_12", "y_{12}");
        check("kappa", r"\kappa");
        check("omega_0", r"\omega_{0}");
        check("omega0", r"\omega_{0}");
        check("c_eff", r"c_{\mathrm{eff}}");
        check("k_max_1", r"k_{\mathrm{max\_1}}");
        check("mass", r"\mathrm{mass}");
        check("κ", "κ");
        check("_", r"\mathrm{\_}");
        check("_a", r"\mathrm{\_a}");
    }
}
