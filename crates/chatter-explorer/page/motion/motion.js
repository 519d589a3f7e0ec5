/** One motion, which several views show: asked again whenever something that it depends on changes. */

import { Latest, Refused, collected, is_abort } from "../asking/transport.js";

/**
 * @typedef {object} Motion
 * @property {any} about
 * @property {number | null} picked the value of the swept parameter that it is the motion of
 * @property {Map<string, Float64Array>} series by quantity, "time" among them
 * @property {{ time: Float64Array, kind: string[], place: string[], before: Float64Array, after: Float64Array,
 *   at: Map<string, Float64Array> }} events
 * @property {{ contact: number, start: number, end: number }[]} phases
 * @property {number[]} jumps samples before which the state jumps
 * @property {Float64Array[][]} drawn for each shape of the drawing its numbers over time
 * @property {[number, number, number, number]} [bounds] of all shapes over the whole time
 */

/** While a slider is dragged, an answer may take so long, in milliseconds, before it is given up for the next. */
const PATIENCE = 300;

export class Motions {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     */
    constructor(ask, store) {
        this.ask = ask;
        this.store = store;
        this.latest = new Latest(PATIENCE);
        /** @type {Motion | null} */
        this.motion = null;
        /** @type {((motion: Motion | null, error: string) => void)[]} */
        this.listeners = [];
    }

    /** @param {(motion: Motion | null, error: string) => void} listener */
    on(listener) {
        this.listeners.push(listener);
    }

    question() {
        const { from, to } = this.store.state;
        return { model: this.store.model(), until: String(to), window: `${from}:${to}` };
    }

    refresh() {
        const question = this.question();
        const { picked } = this.store.state;
        this.latest.run(async (signal) => {
            try {
                const { documents, columns } = await collected(this.ask("history", question, signal));
                this.tell({ ...motion_of(documents[0], columns), picked }, "");
            } catch (error) {
                if (is_abort(error)) return;
                this.tell(null, error instanceof Refused ? error.message : String(error));
            }
        });
    }

    /**
     * @param {Motion | null} motion
     * @param {string} error
     */
    tell(motion, error) {
        this.motion = motion;
        for (const listener of this.listeners) listener(motion, error);
    }
}

/**
 * @param {any} about
 * @param {Float64Array[]} columns
 * @returns {Omit<Motion, "picked">}
 */
function motion_of(about, columns) {
    const [samples, of_events] = about.columns;
    const names = ["time", ...about.quantities];
    const series = new Map(names.map((name, place) => [name, columns[place]]));
    const events = columns.slice(samples, samples + of_events);
    const phases = columns.slice(samples + of_events, samples + of_events + 3);
    const rest = columns.slice(samples + of_events + 3);
    const drawn = /** @type {number[]} */ (about.drawn ?? []).map((count) => rest.splice(0, count));
    const time = columns[0];
    const jumps = [];
    for (let k = 1; k < time.length; k += 1) {
        if (time[k] === time[k - 1] && columns.slice(1, samples).some((values) => values[k] !== values[k - 1])) jumps.push(k);
    }
    return {
        about,
        series,
        events: {
            time: events[0],
            kind: Array.from(events[1], (kind) => about.kinds[kind]),
            place: Array.from(events[2], (place) => about.places[place]),
            before: events[3],
            after: events[4],
            at: new Map(about.quantities.map((/** @type {string} */ name, /** @type {number} */ place) => [name, events[5 + place]])),
        },
        phases: Array.from(phases[0] ?? [], (contact, place) => ({ contact, start: phases[1][place], end: phases[2][place] })),
        jumps,
        drawn,
    };
}
