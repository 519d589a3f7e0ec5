/** Colours: Okabe and Ito's, which the colour-blind can tell apart, as in the figures. */

export const BLUE = "#0072b2";
export const VERMILION = "#d55e00";
export const GREEN = "#009e73";
export const PURPLE = "#cc79a7";
export const ORANGE = "#e69f00";
export const SKY = "#56b4e9";

/** @typedef {{ dark: boolean, ink: string, muted: string, grid: string, surface: string, band: string, curve: string,
 *   jump: string, points: [number, number, number], second: [number, number, number], accent: string }} Theme */

/** @type {Theme} */
const LIGHT = {
    dark: false, ink: "#1a1f26", muted: "#5d6673", grid: "#e9ecf0", surface: "#ffffff", band: "#dfe6ee", curve: BLUE,
    jump: "#9aa3ae", points: [8, 28, 66], second: [213, 94, 0], accent: VERMILION,
};

/** @type {Theme} */
const DARK = {
    dark: true, ink: "#e4e8ee", muted: "#98a2b0", grid: "#262d38", surface: "#151a22", band: "#29374a", curve: SKY,
    jump: "#6b7684", points: [214, 228, 246], second: [240, 150, 80], accent: "#f0934a",
};

/** @returns {Theme} */
export function theme() {
    const chosen = document.documentElement.dataset.theme;
    const dark = chosen ? chosen === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    return dark ? DARK : LIGHT;
}

/** What orbits settle to, as in maps of the figures; periods have colours of their own. */
export const PERIODS = /** @type {[number, string, string][]} */ ([
    [1, "period 1", BLUE], [2, "period 2", SKY], [3, "period 3", GREEN], [4, "period 4", PURPLE],
    [8, "period 5 to 8", ORANGE], [Infinity, "longer period", "#f0e442"],
]);

/** @type {Record<string, [string, string]>} */
export const OUTCOMES = {
    periodic: ["periodic", BLUE],
    chaotic: ["chaotic", "#fadec8"],
    quasiperiodic: ["quasi-periodic", "#ccecd6"],
    complete_chatter: ["complete chatter", "#081c42"],
    unsettled: ["unsettled", "#bebebe"],
    no_return: ["no return", "#ebebeb"],
    left_domain: ["left the domain", "#78503c"],
    no_start: ["no start", "#ffffff"],
    undetermined: ["undetermined", "#000000"],
    not_finite: ["not finite", "#a03c78"],
};

/**
 * @param {string} outcome
 * @param {number} period
 * @returns {[string, string]} its name and colour
 */
export function class_of(outcome, period) {
    if (outcome === "periodic") {
        const found = PERIODS.find(([longest]) => period <= longest) ?? PERIODS[5];
        return [found[1], found[2]];
    }
    return OUTCOMES[outcome] ?? [outcome, "#bebebe"];
}

/** Of attractors, by number, as in the figures; those beyond have one colour together, and what settled to none another. */
const ATTRACTORS = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY];

/**
 * @param {number} number
 * @param {boolean} dark
 */
export const attractor_color = (number, dark) => (number === 0 ? (dark ? "#5b6470" : "#bebebe") : (ATTRACTORS[number - 1] ?? (dark ? DARK : LIGHT).ink));

/**
 * @param {string} color as "#rrggbb"
 * @returns {[number, number, number]}
 */
export const rgb = (color) => /** @type {[number, number, number]} */ ([1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)));
