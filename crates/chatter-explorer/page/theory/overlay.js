/** What theory says, over the diagram: branches of periodic orbits with their special points, their curves in two parameters,
 * border orbits and the windows beside them. */

import { Curves } from "./curves.js";
import { draw_borders, draw_branches, draw_curves, draw_special_points } from "./drawing.js";
import { make } from "../elements/dom.js";
import { ORANGE } from "../drawing/palette.js";
import { gifts } from "../elements/panel.js";
import { is_followed, special } from "./special.js";
import { shown } from "../drawing/ticks.js";
import { Refused, collected, is_abort } from "../asking/transport.js";

/** @typedef {import("../drawing/plot.js").Plot} Plot */
/** @typedef {import("../drawing/palette.js").Theme} Theme */

/** Something is met within so many pixels. */
const REACH = 7;

export class Overlay {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     * @param {() => void} changed
     */
    constructor(ask, store, commands, say, changed) {
        this.ask = ask;
        this.store = store;
        this.changed = changed;
        /** @type {any} */
        this.branches = null;
        /** @type {any} what was asked for them */
        this.asked = null;
        /** @type {Record<string, AbortController>} */
        this.running = {};
        this.status = make("output", { class: "status" });
        this.list = make("ul", { class: "special", "aria-label": "Special points and borders" });
        this.curves = new Curves(ask, store, (message) => (this.status.textContent = message), () => this.tell());
        this.buttons = {
            branches: make("button", { type: "button", "aria-pressed": "false", onclick: () => void this.toggle("branches") }, "Periodic orbits"),
            border: make("button", { type: "button", "aria-pressed": "false", onclick: () => void this.toggle("border") }, "Chatter borders"),
        };
        this.menus = {
            branches: gifts(ask, {
                name: "branches", short: "Export orbits",
                files: () => ({ asked: "branches", question: this.asked ?? this.question("branches") }),
                command: () => commands.branches(this.asked),
                python: () => commands.python_branches(this.asked),
            }, say),
            curve: gifts(ask, {
                name: "curve", short: "Export curve",
                files: () => ({ asked: "curve", question: this.curves.asked() }),
                command: () => commands.curve(this.asked, this.curves.latest()),
                python: () => commands.python_curve(this.asked, this.curves.latest()),
            }, say),
            border: gifts(ask, {
                name: "border", short: "Export border",
                files: () => ({ asked: "border", question: { ...this.question("border"), near: this.border()?.value } }),
                command: () => commands.border(this.border()),
                python: () => commands.python_border(this.border()),
            }, say),
        };
        this.element = make(
            "div", { class: "overlay" },
            make("div", { class: "row" }, make("span", { class: "quiet" }, "Over it"), this.buttons.branches, this.buttons.border, ...Object.values(this.menus), this.status),
            this.list,
        );
        this.show_menus();
        store.on((change) => {
            if (change === "model" || change === "values") this.clear();
            else if (change === "view" && this.branches) this.tell();
        });
    }

    clear() {
        for (const controller of Object.values(this.running)) controller.abort();
        this.branches = null;
        this.store.borders = null;
        this.curves.clear();
        for (const button of Object.values(this.buttons)) button.setAttribute("aria-pressed", "false");
        this.status.textContent = "";
        this.list.replaceChildren();
        this.show_menus();
    }

    show_menus() {
        this.menus.branches.hidden = !this.branches;
        this.menus.curve.hidden = !this.curves.latest();
        this.menus.border.hidden = !this.border();
    }

    /** The border orbit that is nearest to what is looked at. */
    border() {
        return this.store.border();
    }

    /** @param {"branches" | "border"} what */
    question(what) {
        const { diagram } = this.store.state;
        const question = { model: this.store.model(false), parameter: diagram.over, from: diagram.from, to: diagram.to };
        const [kind, name] = diagram.sampling.split(":");
        return what === "branches" && kind === "section" ? { ...question, section: name } : question;
    }

    /** @param {"branches" | "border"} what */
    async toggle(what) {
        const button = this.buttons[what];
        const on = button.getAttribute("aria-pressed") !== "true";
        button.setAttribute("aria-pressed", String(on));
        this.running[what]?.abort();
        if (!on) {
            this.take(what, null, null);
            return;
        }
        const controller = new AbortController();
        this.running[what] = controller;
        this.status.textContent = what === "branches" ? "following the branch …" : "looking for borders …";
        const question = this.question(what);
        try {
            const { documents } = await collected(this.ask(what, question, controller.signal), (message) => (this.status.textContent = message));
            this.take(what, documents[0], question);
        } catch (error) {
            if (is_abort(error)) return;
            button.setAttribute("aria-pressed", "false");
            this.status.textContent = error instanceof Refused ? [error.message, error.refusal.help].filter(Boolean).join(". ") : String(error);
        }
    }

    /**
     * @param {"branches" | "border"} what
     * @param {any} document
     * @param {any} question
     */
    take(what, document, question) {
        if (what === "branches") {
            this.branches = document;
            this.asked = question;
            this.curves.clear();
        } else {
            this.store.borders = document;
        }
        this.tell();
        if (what === "border") this.store.change("look", () => {});
    }

    /** Special points of all branches, numbered as in their table. */
    points() {
        const branches = /** @type {any[]} */ (this.branches?.branches ?? []);
        return branches.flatMap((branch, place) => branch.special.map((/** @type {any} */ point, /** @type {number} */ index) => {
            const before = branch.special.slice(0, index).filter((/** @type {any} */ other) => other.kind === point.kind);
            return { point, branch: place, place: before.length };
        })).map((one, index) => ({ ...one, number: index + 1 }));
    }

    /** The second parameter's value on the branches; none where there is no second. */
    height() {
        const { second } = this.store.state.diagram;
        const value = this.branches?.parameters?.[second];
        return second && typeof value === "number" ? value : null;
    }

    tell() {
        const { over, second } = this.store.state.diagram;
        const go = (/** @type {number} */ value) => () => this.store.change("motion", (state) => Object.assign(state, { picked: value, through: null }));
        const height = this.height();
        const items = this.points().map((found) => {
            const { point } = found;
            const [name, color] = special(point.kind);
            const follows = height !== null && is_followed(point.kind);
            const title = follows ? `follow it in ${over} and ${second}` : null;
            const button = make("button", { type: "button", title, "aria-pressed": follows ? String(this.curves.has(found.number)) : null, onclick: follows ? () => void this.follow(found) : go(point.value) },
                make("i", { ".style": `background:${color}` }), `${name} at ${over} = ${shown(point.value, 10)}`);
            return make("li", {}, button);
        });
        for (const border of this.store.borders?.borders ?? []) {
            items.push(make("li", {}, make("button", { type: "button", onclick: go(border.value) }, make("i", { ".style": `background:${ORANGE}` }), `border orbit at ${over} = ${shown(border.value, 12)}`)));
        }
        this.list.replaceChildren(...items);
        this.status.textContent = this.words().join("  ·  ");
        this.show_menus();
        this.changed();
    }

    words() {
        const branches = /** @type {any[] | undefined} */ (this.branches?.branches);
        const words = [];
        if (branches) {
            const points = branches.reduce((sum, branch) => sum + branch.points.period.length, 0);
            words.push(`${points} orbits on ${branches.length === 1 ? "one branch" : `${branches.length} branches`}`);
            const { diagram } = this.store.state;
            if (!diagram.second && branches.some((branch) => !branch.points[diagram.observe])) words.push(`branches show a state, and ${diagram.observe} is none`);
            if (this.height() !== null && this.curves.found.length === 0 && this.points().length > 0) words.push("click a special point to follow it over the map");
        }
        words.push(...this.curves.words());
        const borders = this.store.borders?.borders;
        if (borders) words.push(borders.length === 0 ? "no border orbit in this range" : `${borders.length} border orbit${borders.length === 1 ? "" : "s"}`);
        return words;
    }

    /** @param {import("./curves.js").Found} found */
    follow(found) {
        const height = this.height();
        if (height !== null) return this.curves.follow(found, this.asked, height);
    }

    /**
     * Follows the special point of a map that is near, if one is.
     * @param {Plot} plot
     * @param {number} px
     * @param {number} py
     */
    follow_near(plot, px, py) {
        const height = this.height();
        if (height === null) return false;
        const off = (/** @type {any} */ { point }) => Math.hypot(plot.px(point.value) - px, plot.py(height) - py);
        const near = this.points().filter(({ point }) => is_followed(point.kind)).sort((one, other) => off(one) - off(other))[0];
        if (!near || off(near) > REACH) return false;
        void this.follow(near);
        return true;
    }

    /**
     * The periodic orbit of a branch that is nearest, if one is near.
     * @param {Plot} plot
     * @param {number} px
     * @param {number} py
     * @param {boolean} near whether it has to be
     * @returns {{ value: number, state: Record<string, number>, words: string } | null}
     */
    nearest(plot, px, py, near) {
        const { diagram } = this.store.state;
        const states = this.store.checked?.states.map(({ name }) => name) ?? [];
        if (diagram.second) return null;
        let best = null;
        let distance = near ? REACH : Infinity;
        for (const branch of this.branches?.branches ?? []) {
            const { points } = branch;
            const [x, y] = [points[diagram.over], points[diagram.observe]];
            if (!x || !y) continue;
            for (let k = 0; k < x.length; k += 1) {
                const off = Math.hypot(plot.px(x[k]) - px, plot.py(y[k] - diagram.slope * x[k]) - py);
                if (off > distance) continue;
                distance = off;
                best = {
                    value: x[k],
                    state: Object.fromEntries(states.map((name) => [name, points[name][k]])),
                    words: [`${diagram.over} = ${shown(x[k], 8)}`, points.stable[k] ? "stable" : points.neutral[k] ? "neutral" : "unstable", `period ${shown(points.period[k])}`, points.impacts[k] === null ? "complete chatter" : `${points.impacts[k]} impacts`].join("  ·  "),
                };
            }
        }
        return best;
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {Theme} colors
     */
    draw(context, plot, colors) {
        const { diagram } = this.store.state;
        const { borders } = this.store;
        if (borders) draw_borders(context, plot, colors, borders);
        if (!this.branches) return;
        if (!diagram.second) {
            draw_branches(context, plot, colors, this.branches, diagram);
            return;
        }
        draw_curves(context, plot, colors, this.curves.found.map(({ curve }) => curve), diagram);
        const height = this.height();
        if (height !== null) draw_special_points(context, plot, colors, this.branches, height);
    }
}
