/** The curves that cobwebs are drawn on: that of a return map of one dimension, and that of the universal map near a border. */

import { ROW, numbers } from "../asking/records.js";
import { sampled } from "../state.js";
import { collected } from "../asking/transport.js";

/** @typedef {import("../state.js").Store} Store */
/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {{ name: string, held: string, value: number, sweep: string }} OneDimension a return map of one dimension: its coordinate,
 *   the state that its section holds at a value, and the sweep over initial values that samples it */

/** Values at which the curve is sampled. */
const VALUES = 400;

/**
 * What a return map of one dimension is a map of: of a system of two states that is not forced, where the section holds one.
 * @param {Store} store
 * @param {Motion} motion
 * @param {number[]} places of the events at which orbits are sampled
 * @param {string} returned the quantity that is shown
 * @returns {OneDimension | null}
 */
export function one_dimension(store, motion, places, returned) {
    const { checked, state } = store;
    if (!checked || places.length < 2 || checked.states.length !== 2 || checked.states.some((one) => one.time)) return null;
    const [kind, name] = state.diagram.sampling.split(":");
    const on = kind === "section" ? checked.sections.find((section) => section.name === name)?.on : checked.gaps.length === 1 ? checked.gaps[0] : undefined;
    if (on?.length !== 1 || on[0] === returned) return null;
    const free = checked.states.find((one) => one.name !== on[0]);
    const values = motion.events.at.get(returned);
    const held = motion.events.at.get(on[0]);
    if (free?.name !== returned || !values || !held) return null;
    const known = places.map((place) => values[place]);
    const [low, high] = [Math.min(...known), Math.max(...known)];
    const room = high > low ? 0.15 * (high - low) : 0.15 * Math.abs(high) || 0.1;
    const end = (/** @type {number} */ value) => Number(value.toPrecision(6));
    return { name: returned, held: on[0], value: held[places[0]], sweep: `initial:${returned}=${end(low - room)}:${end(high + room)}:${VALUES}` };
}

/**
 * Points of the return map's curve, in order.
 * @param {import("../asking/transport.js").Ask} ask
 * @param {Store} store
 * @param {OneDimension} one
 * @param {AbortSignal} signal
 * @returns {Promise<[number, number][]>}
 */
export async function sampled_curve(ask, store, one, signal) {
    const model = store.model(true);
    const initial = model.initial.filter(([name]) => name !== one.name && name !== one.held);
    const question = {
        model: { ...model, initial: [...initial, [one.held, String(one.value)]] },
        runs: [[one.sweep]], ...sampled(store.state.diagram.sampling), observe: [one.name], transient: 0, keep: "1",
    };
    /** @type {[number, number][]} */
    const points = [];
    for await (const message of ask("diagram", question, signal)) {
        if (message.kind !== ROW) continue;
        const row = numbers(message);
        points.push([row[2], row.length > 8 ? row[8] : NaN]);
    }
    return points.sort((one, other) => one[0] - other[0]);
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
