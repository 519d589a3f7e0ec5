/** What is seen of a diagram: its box. */

import { rounded } from "../drawing/ticks.js";

/** @typedef {import("../drawing/plot.js").Box} Box */

/**
 * @param {import("../state.js").Diagram} diagram
 * @param {Box} box
 */
export function look_at(diagram, { x0, x1, y0, y1 }) {
    Object.assign(diagram, { from: x0, to: x1 });
    if (diagram.second) Object.assign(diagram, { second_from: y0, second_to: y1 });
    else diagram.y = [y0, y1];
}

/**
 * A box whose numbers can be read and written down.
 * @param {Box} box
 */
export function readable({ x0, x1, y0, y1 }) {
    const [x, y] = [(x1 - x0) / 1e4, (y1 - y0) / 1e4];
    return { x0: rounded(x0, x), x1: rounded(x1, x), y0: rounded(y0, y), y1: rounded(y1, y) };
}
