/** Labels of quantities: as much of TeX as labels of models have, in Unicode. */

/** @type {Record<string, string>} */
const GREEK = {
    alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", zeta: "ζ", eta: "η", theta: "θ", kappa: "κ", lambda: "λ",
    mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ", tau: "τ", phi: "φ", chi: "χ", psi: "ψ", omega: "ω",
    Gamma: "Γ", Delta: "Δ", Theta: "Θ", Lambda: "Λ", Sigma: "Σ", Phi: "Φ", Psi: "Ψ", Omega: "Ω",
};
const LOW = "₀₁₂₃₄₅₆₇₈₉";

/** @param {string} text */
export function plain(text) {
    return text
        .replace(/\\([A-Za-z]+)/g, (_, name) => GREEK[name] ?? name)
        .replace(/_\{?(\d+)\}?/g, (_, digits) => [...digits].map((digit) => LOW[Number(digit)]).join(""))
        .replace(/_\{?(\w+)\}?/g, "$1")
        .replace(/[${}]/g, "");
}

/** @typedef {{ text: string | null, unit: string | null } | null} Label */

/**
 * What stands beside an axis.
 * @param {string} name
 * @param {Label | undefined} label
 */
export function axis_label(name, label) {
    const words = label?.text ? plain(label.text) : name;
    return label?.unit ? `${words}  [${plain(label.unit)}]` : words;
}
