/** The motion over time: each state, bands where contacts are closed, ticks at impacts. */

import { curve, disc } from "../drawing/curves.js";
import { field, make } from "../elements/dom.js";
import { axis_label } from "../drawing/labels.js";
import { gifts, panel } from "../elements/panel.js";
import { Plot, extent } from "../drawing/plot.js";
import { rounded, shown } from "../drawing/ticks.js";

/** @typedef {import("./motion.js").Motion} Motion */

export class HistoryView {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, motions, commands, say) {
        this.store = store;
        /** @type {Motion | null} */
        this.motion = null;
        this.quantity = "";
        /** @type {number | null} the time at which the mechanism is shown */
        this.now = null;
        this.readout = make("output", { class: "readout" });
        this.error = make("p", { class: "error", role: "alert", hidden: true });
        this.facts = make("p", { class: "facts" });
        this.plot = new Plot({
            label: "Time history. Arrow keys move the view, plus and minus zoom, 0 shows from the start.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            moved: (box, done) => this.moved(box, done),
            reset: () => store.change("motion", (state) => Object.assign(state, { to: state.to - state.from, from: 0 })),
            hover: (at) => this.hover(at),
        });
        this.axes = () => `${commands.time()},${this.quantity}`;
        this.select = make("select", { "aria-label": "Quantity", onchange: () => this.choose(this.select.value) });
        this.length = make("input", { type: "number", step: "any", "aria-label": "until", onchange: () => this.until(this.length.valueAsNumber) });
        const scale = (/** @type {number} */ factor) => () => store.change("motion", (state) => { state.to = rounded(state.from + (state.to - state.from) * factor, (state.to - state.from) / 1e4); });
        const controls = [
            this.select, field("until", this.length),
            make("button", { type: "button", title: "half as long", "aria-label": "half as long", onclick: scale(0.5) }, "÷2"),
            make("button", { type: "button", title: "twice as long", "aria-label": "twice as long", onclick: scale(2) }, "×2"),
        ];
        const menu = gifts(ask, {
            name: "time history",
            files: () => ({ asked: "history", question: { ...motions.question(), axes: [this.axes()] } }),
            command: () => commands.history("history", [this.axes()]),
            python: () => commands.python_history(motions.motion?.about.states.includes(this.quantity) ? `run.plot(${JSON.stringify(this.quantity)})` : "run.plot()"),
        }, say);
        this.element = panel("history", "Time history", controls, make("div", { class: "body" }, this.error, this.plot.element, make("div", { class: "foot" }, this.readout, this.facts)), menu);
        motions.on((motion, error) => this.take(motion, error));
        store.on(() => this.plot.repaint());
    }

    /** @param {number} until */
    until(until) {
        if (until > this.store.state.from) this.store.change("motion", (state) => { state.to = until; });
    }

    /** @param {string} quantity */
    choose(quantity) {
        this.quantity = quantity;
        this.fit();
    }

    /**
     * @param {Motion | null} motion
     * @param {string} error
     */
    take(motion, error) {
        this.error.textContent = error;
        this.error.hidden = !error;
        if (!motion) return;
        this.motion = motion;
        const names = /** @type {string[]} */ (motion.about.quantities);
        if (!names.includes(this.quantity)) this.quantity = names[0] ?? "";
        this.select.replaceChildren(...names.map((name) => make("option", { value: name, ".selected": name === this.quantity }, name)));
        if (document.activeElement !== this.length) this.length.value = String(this.store.state.to);
        const { counts, outcome, message } = motion.about;
        const count = (/** @type {number} */ number, /** @type {string} */ one, /** @type {string} */ more) => `${number} ${number === 1 ? one : more}`;
        const facts = [count(counts.impacts, "impact", "impacts"), count(counts.accumulations, "accumulation", "accumulations"), count(counts.releases, "release", "releases")];
        if (outcome !== "horizon") facts.push(message || outcome);
        this.facts.textContent = facts.join("  ·  ");
        const { dataset } = this.plot.canvas;
        dataset.time = String(motion.about.time);
        dataset.end = JSON.stringify(motion.about.state);
        dataset.impacts = String(counts.impacts);
        dataset.picked = String(motion.picked);
        this.fit();
    }

    fit() {
        const { motion } = this;
        if (!motion) return;
        const { from, to } = this.store.state;
        const values = motion.series.get(this.quantity);
        const [y0, y1] = (values && extent(values, 0.08)) ?? [0, 1];
        this.plot.box = { x0: from, x1: to, y0, y1 };
        this.plot.x_label = "time";
        this.plot.y_label = axis_label(this.quantity, this.store.label(this.quantity));
        this.plot.repaint();
    }

    /**
     * @param {import("../drawing/plot.js").Box} box
     * @param {boolean} done
     */
    moved(box, done) {
        if (!done) return;
        const start = this.motion?.about.start ?? 0;
        const step = (box.x1 - box.x0) / 1e4;
        this.store.change("motion", (state) => Object.assign(state, { from: Math.max(start, rounded(box.x0, step)), to: rounded(box.x1, step) }));
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("../drawing/palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { motion } = this;
        const values = motion?.series.get(this.quantity);
        if (!motion || !values) return;
        const { top, height } = plot.area;
        const contacts = motion.about.contacts.length;
        const band = height / Math.max(1, contacts);
        context.fillStyle = colors.band;
        for (const { contact, start, end } of motion.phases) {
            const right = Number.isNaN(end) ? plot.box.x1 : end;
            context.fillRect(plot.px(start), top + contact * band, Math.max(1, plot.px(right) - plot.px(start)), band);
        }
        curve(context, plot, colors, /** @type {Float64Array} */ (motion.series.get("time")), values, motion.jumps);
        const { events } = motion;
        context.strokeStyle = colors.accent;
        context.lineWidth = 1;
        context.beginPath();
        let last = -Infinity;
        events.kind.forEach((kind, place) => {
            if (kind !== "impact") return;
            const at = plot.px(events.time[place]);
            if (at - last < 0.5) return;
            last = at;
            context.moveTo(at, top + height - 7);
            context.lineTo(at, top + height);
        });
        context.stroke();
        context.fillStyle = colors.ink;
        const states = events.at.get(this.quantity);
        events.kind.forEach((kind, place) => {
            if (kind === "accumulation" && states) disc(context, plot.px(events.time[place]), plot.py(states[place]), 3);
        });
        if (this.now !== null) {
            context.strokeStyle = colors.ink;
            context.beginPath();
            context.moveTo(plot.px(this.now), top);
            context.lineTo(plot.px(this.now), top + height);
            context.stroke();
        }
    }

    /** @param {{ x: number, y: number } | null} at */
    hover(at) {
        const { motion } = this;
        const time = motion?.series.get("time");
        const values = motion?.series.get(this.quantity);
        if (!at || !time || !values || time.length === 0) {
            this.readout.textContent = "";
            return;
        }
        const place = nearest(time, at.x);
        this.readout.textContent = `time ${shown(time[place])}  ·  ${this.quantity} = ${shown(values[place])}`;
    }
}

/**
 * The place of the value nearest to one, in values that do not fall.
 * @param {ArrayLike<number>} values
 * @param {number} value
 */
export function nearest(values, value) {
    let [low, high] = [0, values.length - 1];
    while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (values[middle] <= value) low = middle;
        else high = middle;
    }
    return Math.abs(values[low] - value) <= Math.abs(values[high] - value) ? low : high;
}
