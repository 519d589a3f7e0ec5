/** Special points of branches and of curves in two parameters: what they are called, and their colours. */

import { BLUE, GREEN, ORANGE, PURPLE, VERMILION } from "../drawing/palette.js";

const GREY = "#777777";

/** @type {Record<string, [string, string]>} */
const KINDS = {
    fold: ["fold", VERMILION],
    period_doubling: ["period doubling", GREEN],
    neimark_sacker: ["Neimark–Sacker", PURPLE],
    hopf: ["Hopf", VERMILION],
    branch_point: ["branch point", GREY],
    impact_graze: ["graze of an impact", BLUE],
    flight_graze: ["graze of a flight", BLUE],
    chatter_border: ["chatter border", ORANGE],
    touch: ["touch", GREY],
};

/** @param {string} kind @returns {[string, string]} name and colour */
export const special = (kind) => KINDS[kind] ?? [kind.replaceAll("_", " "), GREY];

/** Those that are followed in two parameters. */
const FOLLOWED = ["fold", "period_doubling", "neimark_sacker", "branch_point", "impact_graze", "flight_graze", "chatter_border"];

/** @param {string} kind */
export const is_followed = (kind) => FOLLOWED.includes(kind);
