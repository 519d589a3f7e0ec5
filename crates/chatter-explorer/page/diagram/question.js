/** What is asked about a diagram. */

import { sampled } from "../state.js";

/** @typedef {import("../state.js").Store} Store */

/**
 * All but the sweeps.
 * @param {Store} store
 * @param {string[]} bounds of random starts
 */
export function question(store, bounds) {
    const { diagram } = store.state;
    const model = store.model(false);
    model.set = model.set.filter(([name]) => name !== diagram.over && name !== diagram.second);
    return {
        model,
        ...sampled(diagram.sampling),
        observe: [diagram.observe],
        transient: diagram.transient,
        keep: String(diagram.keep),
        start: diagram.start,
        bounds,
        exponent: diagram.exponent,
    };
}

/**
 * The sweep that a file is made of: what is seen.
 * @param {import("../state.js").Diagram} diagram
 * @param {number} size how many columns, or rows of a map, it has
 */
export function whole({ over, from, to, second, second_from, second_to }, size) {
    const first = `${over}=${from}:${to}:${size}`;
    return second ? [first, `${second}=${second_from}:${second_to}:${size}`] : [first];
}
