/** What theory says, over the diagram: branches of periodic orbits with their special points, border orbits and the windows beside them. */

import { make } from "./dom.js";
import { BLUE, GREEN, ORANGE, PURPLE, VERMILION } from "./palette.js";
import { gifts } from "./panel.js";
import { shown } from "./ticks.js";
import { Refused, collected, is_abort } from "./transport.js";

/** @typedef {import("./plot.js").Plot} Plot */
/** @typedef {import("./palette.js").Theme} Theme */

/** @type {Record<string, [string, string]>} words and colour of special points */
const SPECIAL = {
    fold: ["fold", VERMILION],
    period_doubling: ["period doubling", GREEN],
    neimark_sacker: ["Neimark–Sacker", PURPLE],
    branch_point: ["branch point", "#777777"],
    impact_graze: ["graze of an impact", BLUE],
    flight_graze: ["graze of a flight", BLUE],
    chatter_border: ["chatter border", ORANGE],
    touch: ["touch", "#999999"],
};

/** A branch is met within so many pixels. */
const REACH = 7;

export class Overlay {
    /**
     * @param {import("./transport.js").Ask} ask
     * @param {import("./state.js").Store} store
     * @param {import("./commands.js").Commands} commands
     * @param {(message: string) => void} say
     * @param {() => void} changed
     */
    constructor(ask, store, commands, say, changed) {
        this.ask = ask;
        this.store = store;
        this.changed = changed;
        this.say = say;
        /** @type {any} */
        this.branches = null;
        /** @type {any} */
        this.borders = null;
        /** @type {Record<string, AbortController>} */
        this.running = {};
        this.key = "";
        this.status = make("output", { class: "status" });
        this.list = make("ul", { class: "special" });
        this.buttons = {
            branches: make("button", { type: "button", "aria-pressed": "false", onclick: () => void this.toggle("branches") }, "Periodic orbits"),
            border: make("button", { type: "button", "aria-pressed": "false", onclick: () => void this.toggle("border") }, "Chatter borders"),
        };
        const menu = gifts(ask, {
            files: () => ({ asked: "branches", question: this.question("branches") }),
            command: () => commands.branches(),
            python: () => commands.python_branches(),
        }, say);
        this.menu = menu;
        menu.hidden = true;
        this.element = make("div", { class: "overlay" }, make("div", { class: "row" }, make("span", { class: "quiet" }, "Over it"), this.buttons.branches, this.buttons.border, menu, this.status), this.list);
        store.on((change) => {
            if (change === "model" || change === "values") this.clear();
        });
    }

    clear() {
        for (const controller of Object.values(this.running)) controller.abort();
        this.branches = null;
        this.borders = null;
        this.menu.hidden = true;
        for (const button of Object.values(this.buttons)) button.setAttribute("aria-pressed", "false");
        this.status.textContent = "";
        this.list.replaceChildren();
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
            if (what === "branches") this.branches = null;
            else this.borders = null;
            this.menu.hidden = !this.branches;
            this.tell();
            return;
        }
        const controller = new AbortController();
        this.running[what] = controller;
        this.status.textContent = what === "branches" ? "following the branch …" : "looking for borders …";
        try {
            const { documents } = await collected(this.ask(what, this.question(what), controller.signal), (message) => (this.status.textContent = message));
            if (what === "branches") this.branches = documents[0];
            else this.borders = documents[0];
            this.menu.hidden = !this.branches;
            this.tell();
        } catch (error) {
            if (is_abort(error)) return;
            button.setAttribute("aria-pressed", "false");
            this.status.textContent = error instanceof Refused ? [error.message, error.refusal.help].filter(Boolean).join(". ") : String(error);
        }
    }

    tell() {
        const items = [];
        const { over } = this.store.state.diagram;
        const go = (/** @type {number} */ value) => () => this.store.change("motion", (state) => Object.assign(state, { picked: value, through: null }));
        for (const branch of this.branches?.branches ?? []) {
            for (const special of branch.special) {
                const [name, color] = SPECIAL[special.kind] ?? [special.kind, "#777777"];
                items.push(make("li", {}, make("button", { type: "button", onclick: go(special.value) }, make("i", { ".style": `background:${color}` }), `${name} at ${over} = ${shown(special.value, 10)}`)));
            }
        }
        for (const border of this.borders?.borders ?? []) {
            items.push(make("li", {}, make("button", { type: "button", onclick: go(border.value) }, make("i", { ".style": `background:${ORANGE}` }), `border orbit at ${over} = ${shown(border.value, 12)}`)));
        }
        this.list.replaceChildren(...items);
        const points = (this.branches?.branches ?? []).reduce((/** @type {number} */ sum, /** @type {any} */ branch) => sum + branch.points.period.length, 0);
        const words = [];
        if (this.branches) words.push(`${points} orbits on ${this.branches.branches.length === 1 ? "one branch" : `${this.branches.branches.length} branches`}`);
        if (this.borders) words.push(this.borders.borders.length === 0 ? "no border orbit in this range" : `${this.borders.borders.length} border orbit${this.borders.borders.length === 1 ? "" : "s"}`);
        this.status.textContent = words.join("  ·  ");
        this.changed();
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
                    words: [`${diagram.over} = ${shown(x[k], 8)}`, points.stable[k] ? "stable" : "unstable", `period ${shown(points.period[k])}`, points.impacts[k] === null ? "complete chatter" : `${points.impacts[k]} impacts`].join("  ·  "),
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
        if (this.borders) this.draw_borders(context, plot, colors);
        if (!this.branches || diagram.second) return;
        const { slope } = diagram;
        for (const branch of this.branches.branches) {
            const x = branch.points[diagram.over];
            const y = branch.points[diagram.observe];
            if (!x || !y) {
                this.status.textContent = `branches show a state, and ${diagram.observe} is none`;
                return;
            }
            const { stable } = branch.points;
            for (const kind of [true, false]) {
                context.beginPath();
                for (let k = 1; k < x.length; k += 1) {
                    if (stable[k - 1] !== kind) continue;
                    context.moveTo(plot.px(x[k - 1]), plot.py(y[k - 1] - slope * x[k - 1]));
                    context.lineTo(plot.px(x[k]), plot.py(y[k] - slope * x[k]));
                }
                context.strokeStyle = kind ? colors.curve : colors.muted;
                context.lineWidth = kind ? 2 : 1;
                context.setLineDash(kind ? [] : [4, 3]);
                context.stroke();
            }
            context.setLineDash([]);
            for (const special of branch.special) {
                context.beginPath();
                context.arc(plot.px(special.value), plot.py(special.state[diagram.observe] - slope * special.value), 4, 0, 2 * Math.PI);
                context.fillStyle = SPECIAL[special.kind]?.[1] ?? colors.muted;
                context.fill();
                context.strokeStyle = colors.surface;
                context.lineWidth = 1.5;
                context.stroke();
            }
        }
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {Theme} colors
     */
    draw_borders(context, plot, colors) {
        const { top, height } = plot.area;
        const upright = (/** @type {number} */ value, /** @type {string} */ color, /** @type {number[]} */ dash, /** @type {number} */ width) => {
            const at = Math.round(plot.px(value)) + 0.5;
            context.beginPath();
            context.moveTo(at, top);
            context.lineTo(at, top + height);
            context.strokeStyle = color;
            context.lineWidth = width;
            context.setLineDash(dash);
            context.stroke();
            context.setLineDash([]);
        };
        context.font = "11px system-ui, sans-serif";
        for (const border of this.borders.borders) {
            for (const window of border.windows ?? []) {
                const ends = [window.fold, window.period_doubling, window.grazing].filter((end) => typeof end === "number");
                ends.forEach((end) => upright(end, GREEN, [2, 3], 1));
                if (ends.length && plot.px(Math.max(...ends)) - plot.px(Math.min(...ends)) > 18) {
                    context.fillStyle = colors.muted;
                    context.textAlign = "center";
                    context.textBaseline = "top";
                    context.fillText(`n = ${window.n}`, (plot.px(Math.min(...ends)) + plot.px(Math.max(...ends))) / 2, top + 4);
                }
            }
            upright(border.value, ORANGE, [], 1.5);
        }
    }
}
