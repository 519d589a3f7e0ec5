/** What the rows of a diagram are called, and which colours they have. */

import { make } from "../elements/dom.js";
import { OUTCOMES, PERIODS, attractor_color, class_of, rgb } from "../drawing/palette.js";
import { shown } from "../drawing/ticks.js";

/** @typedef {import("./rows.js").Rows} Rows */
/** @typedef {import("../state.js").Diagram} Diagram */

/**
 * Whether samples have the colours of the attractors that coexist.
 * @param {Rows} rows
 * @param {Diagram} diagram
 */
const by_attractor = (rows, { start, second }) => !second && start.startsWith("random") && rows.attractors.length > 0;

/**
 * On which layers samples are drawn.
 * @param {Rows} rows
 * @param {Diagram} diagram
 * @param {import("../drawing/palette.js").Theme} colors
 * @returns {import("../drawing/raster.js").Layers}
 */
export function layers(rows, diagram, colors) {
    const { attractors } = rows;
    if (by_attractor(rows, diagram)) {
        const places = new Map(attractors.map(({ attractor }, place) => [attractor, place]));
        return { colors: attractors.map(({ attractor }) => rgb(attractor_color(attractor, colors.dark))), of: (row) => places.get(row.attractor) ?? 0 };
    }
    if (diagram.start === "carry:both") return { colors: [colors.points, colors.second], of: (_, pass) => pass % 2 };
    return { colors: [colors.points], of: () => 0 };
}

/**
 * @param {Rows} rows
 * @param {string[]} outcomes
 * @param {Diagram} diagram
 * @param {import("../drawing/palette.js").Theme} colors
 * @returns {HTMLElement[]}
 */
export function legend(rows, outcomes, diagram, colors) {
    const item = (/** @type {string} */ name, /** @type {string} */ color) => make("span", { class: "key" }, make("i", { ".style": `background:${color}` }), name);
    if (diagram.second) {
        const present = new Set([...rows.plane.cells.values()].map((cell) => class_of(outcomes[cell.row.outcome], cell.row.period)[0]));
        const all = [...PERIODS.map(([, name, color]) => /** @type {[string, string]} */ ([name, color])), ...Object.values(OUTCOMES)];
        return all.filter(([name]) => present.has(name)).map(([name, color]) => item(name, color));
    }
    const last = (/** @type {number} */ number) => number || Infinity;
    if (by_attractor(rows, diagram)) return [...rows.attractors].sort((one, other) => last(one.attractor) - last(other.attractor)).map(({ attractor, label }) => item(label, attractor_color(attractor, colors.dark)));
    if (diagram.start === "carry:both") return [item("upwards", "var(--points)"), item("downwards", "var(--second)")];
    return [];
}

/**
 * @param {import("../drawing/raster.js").Row} row
 * @param {string[]} outcomes
 */
export function words(row, outcomes) {
    const outcome = outcomes[row.outcome] ?? "";
    const name = outcome === "periodic" ? `period ${row.period}` : (OUTCOMES[outcome]?.[0] ?? outcome);
    const words = [name];
    if (row.attractor) words.push(`attractor ${row.attractor}`);
    if (!Number.isNaN(row.impacts)) words.push(`${shown(row.impacts, 4)} impacts per return`);
    if (!Number.isNaN(row.exponent)) words.push(`exponent ${shown(row.exponent, 3)}`);
    return words;
}
