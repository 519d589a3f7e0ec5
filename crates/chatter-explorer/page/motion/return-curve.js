/** The curves that cobwebs are drawn on: that of a return map of one dimension, and that of the universal map near a border. */

import { collected } from "../asking/transport.js";

/** @typedef {import("../state.js").Store} Store */
/** @typedef {{ name: string, held: string, level: number, sweep: string }} Sampled how the curve of a return map of one dimension is
 *   sampled: its state, the one that its section holds and where, and the sweep over initial values */

/**
 * The curve of a return map of one dimension; none where it has more.
 * @param {import("../asking/transport.js").Ask} ask
 * @param {object} question about the motion, with the axes of its return map
 * @param {AbortSignal} signal
 * @returns {Promise<{ sampled: Sampled, curve: [number, number][] } | null>}
 */
export async function return_curve(ask, question, signal) {
    const { documents, columns: [x, next] } = await collected(ask("returns", question, signal));
    const sampled = /** @type {Sampled | null} */ (documents[0]);
    return sampled && { sampled, curve: Array.from(x, (value, place) => /** @type {[number, number]} */ ([value, next[place]])) };
}

/**
 * The universal map at the value that is looked at: z goes to Upsilon(K z + mu).
 * @param {Store} store
 */
export function universal_map(store) {
    const border = store.border();
    if (!border) return null;
    const { slope, unfolding_rate } = border.exact;
    const value = store.value(border.parameter);
    return { restitution: border.restitution, slope, mu: unfolding_rate * (value - border.value) };
}

/**
 * @param {import("../asking/transport.js").Ask} ask
 * @param {{ restitution: number, slope: number, mu: number }} map
 * @param {AbortSignal} signal
 */
export async function universal_curve(ask, map, signal) {
    const { documents, columns: [z, next, orbit] } = await collected(ask("universal", map, signal));
    return { range: /** @type {[number, number]} */ (documents[0].range), curve: Array.from(z, (value, place) => /** @type {[number, number]} */ ([value, next[place]])), orbit };
}
