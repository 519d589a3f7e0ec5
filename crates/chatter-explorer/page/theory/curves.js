/** Curves of special points in two parameters: asked for one by one, each until it is there or given up. */

import { special } from "./special.js";
import { Refused, collected, is_abort } from "../asking/transport.js";

/** @typedef {{ point: any, branch: number, place: number, number: number }} Found a special point: its branch, its place among those of
 *   its kind there, and its number in the table of all branches, from 1 */
/** @typedef {{ of: Found, question: any, curve: any }} Followed */

export class Curves {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {(message: string) => void} say
     * @param {() => void} changed
     */
    constructor(ask, store, say, changed) {
        this.ask = ask;
        this.store = store;
        this.say = say;
        this.changed = changed;
        /** @type {Followed[]} */
        this.found = [];
        /** @type {Map<number, AbortController>} by the number of the point */
        this.running = new Map();
    }

    clear() {
        for (const controller of this.running.values()) controller.abort();
        this.running.clear();
        this.found = [];
    }

    /** @param {number} number */
    has(number) {
        return this.running.has(number) || this.found.some(({ of }) => of.number === number);
    }

    latest() {
        return this.found.at(-1);
    }

    asked() {
        return this.latest()?.question ?? {};
    }

    words() {
        return this.found.map(({ of, curve }) => `${curve.points.period.length} points on the curve of ${special(of.point.kind)[0]}`);
    }

    /**
     * Follows a special point over what is seen of the second parameter; gives up or forgets one that is followed.
     * @param {Found} of
     * @param {any} asked for the branches
     * @param {number} height the value of the second parameter there
     */
    async follow(of, asked, height) {
        if (this.has(of.number)) {
            this.running.get(of.number)?.abort();
            this.running.delete(of.number);
            this.found = this.found.filter((one) => one.of.number !== of.number);
            this.changed();
            return;
        }
        const { over, second, second_from, second_to } = this.store.state.diagram;
        const { point } = of;
        const others = asked.model.set.filter((/** @type {[string, string]} */ [name]) => name !== over && name !== second);
        const question = {
            model: { ...asked.model, set: [...others, [over, String(point.value)], [second, String(height)]] },
            parameters: [over, second], from: second_from, to: second_to,
            ...(asked.section ? { section: asked.section } : {}),
            kind: point.kind, state: this.store.checked?.states.map(({ name }) => point.state[name]), orbit_period: point.period,
        };
        const controller = new AbortController();
        this.running.set(of.number, controller);
        this.changed();
        this.say(`following the ${special(point.kind)[0]} …`);
        let failed = "";
        try {
            const { documents } = await collected(this.ask("curve", question, controller.signal), this.say);
            this.found.push({ of, question, curve: documents[0].branches[0] });
        } catch (error) {
            if (is_abort(error)) return;
            failed = error instanceof Refused ? [error.message, error.refusal.help].filter(Boolean).join(". ") : String(error);
        } finally {
            if (this.running.get(of.number) === controller) this.running.delete(of.number);
        }
        this.changed();
        if (failed) this.say(failed);
    }
}
