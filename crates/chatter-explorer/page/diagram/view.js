/** The orbit diagram: sharpens column by column, keeps what it has, and shows where the picked value is. */

import { make } from "../elements/dom.js";
import { look_at, readable } from "./box.js";
import { layers, legend } from "./classes.js";
import { DiagramControls } from "./controls.js";
import { draw_picked, there } from "./place.js";
import { question, whole } from "./question.js";
import { COARSE, Rows, hangs_together, slope_of } from "./rows.js";
import { axis_label } from "../drawing/labels.js";
import { Overlay } from "../theory/overlay.js";
import { theme } from "../drawing/palette.js";
import { gifts, panel } from "../elements/panel.js";
import { Plot } from "../drawing/plot.js";
import { Raster } from "../drawing/raster.js";
import { DOCUMENT, NUMBERS, REMARK, ROW, document_of, numbers, text } from "../asking/records.js";
import { rounded, shown } from "../drawing/ticks.js";
import { Refused, is_abort } from "../asking/transport.js";

/** @typedef {import("../drawing/plot.js").Box} Box */

/** After a change by hand, so long nothing is asked, in milliseconds. */
const REST = 160;
/** A picture that takes longer is moved as it is while it is dragged. */
const FRAME = 9;
/** While rows come in, the picture is counted again so often, in milliseconds. */
const FLOW = 90;

export class DiagramView {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, commands, say) {
        this.ask = ask;
        this.store = store;
        this.commands = commands;
        this.say = say;
        this.raster = new Raster();
        this.rows = new Rows();
        this.panel = new DiagramControls(store, this.rows, () => this.reset());
        this.overlay = new Overlay(ask, store, commands, say, () => this.plot.repaint());
        /** @type {string[]} */
        this.outcomes = [];
        this.question_key = "";
        /** @type {AbortController | null} */
        this.asking = null;
        this.timer = 0;
        this.counted = 0;
        this.stale = true;
        this.plot = new Plot({
            label: "Orbit diagram. Arrow keys move the picked value, with shift the view; plus and minus zoom, 0 shows all.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            moved: (box, done) => this.moved(box, done),
            reset: () => this.reset(),
            pick: (x, y) => this.pick(x, y),
            hover: (at) => this.hover(at),
            step: (direction) => this.step(direction),
            grab: (px, py, first) => this.grab(px, py, first),
        });
        // For whoever looks at the page from outside, as tests do.
        Object.assign(this.plot.canvas, { overlay: this.overlay, rows: this.rows });
        this.readout = make("output", { class: "readout", "aria-live": "polite" });
        this.progress = make("progress", { max: 1, value: 0, "aria-label": "how much of the diagram is there", hidden: true });
        this.error = make("p", { class: "error", role: "alert", hidden: true });
        this.legend = make("div", { class: "legend" });
        const menu = gifts(ask, {
            name: "orbit diagram",
            files: () => ({ asked: "diagram", question: { ...this.question(), runs: [whole(this.diagram, this.size())] } }),
            command: () => commands.diagram(this.size()),
            python: () => commands.python_diagram(this.size()),
        }, say);
        this.element = panel("diagram", "Orbit diagram", [], make("div", { class: "body" }, this.panel.element, this.error, this.plot.element, make("div", { class: "foot" }, this.readout, this.legend, this.progress), this.overlay.element), menu);
        store.on((change) => {
            if (change === "model") this.panel.build();
            if (change !== "look" && change !== "motion") this.refresh(change === "values");
            if (change === "look") this.show_legend();
            this.plot.repaint();
        });
    }

    get diagram() {
        return this.store.state.diagram;
    }

    /** How many columns, or rows of a map, a file has. */
    size() {
        return this.rows.size(this.diagram);
    }

    question() {
        return question(this.store, this.commands.bounds());
    }

    /**
     * Asks for what is missing of what is seen.
     * @param {boolean} [soon] while a slider is dragged
     */
    refresh(soon = false) {
        const { diagram } = this;
        if (!diagram.over || !this.store.checked) return;
        const key = JSON.stringify({ ...this.question(), over: diagram.over, second: diagram.second });
        if (key !== this.question_key) {
            this.question_key = key;
            this.rows.clear(diagram);
            this.asking?.abort();
        } else if (hangs_together(diagram)) {
            this.asking?.abort();
        }
        this.show_box();
        window.clearTimeout(this.timer);
        this.timer = window.setTimeout(() => void this.compute(), soon ? REST : REST / 4);
    }

    /** The plot's box after the state's. */
    show_box() {
        const { diagram } = this;
        const y = diagram.second ? [diagram.second_from, diagram.second_to] : (diagram.y ?? this.rows.seen(diagram) ?? [this.plot.box.y0, this.plot.box.y1]);
        this.plot.box = { x0: diagram.from, x1: diagram.to, y0: y[0], y1: y[1] };
        this.plot.x_label = axis_label(diagram.over, this.store.label(diagram.over));
        const up = diagram.second || diagram.observe;
        this.plot.y_label = axis_label(up, this.store.label(up)) + (slope_of(diagram) ? `  −  ${shown(slope_of(diagram), 4)} ${diagram.over}` : "");
        this.panel.follow();
        this.stale = true;
        this.plot.repaint();
    }

    async compute() {
        this.asking?.abort();
        const { diagram } = this;
        const plan = this.rows.plan(diagram);
        this.plot.canvas.dataset.state = plan.length ? "computing" : "complete";
        this.plot.canvas.dataset.columns = String(this.rows.visible(this.diagram));
        if (plan.length === 0) {
            this.finish();
            return;
        }
        const controller = new AbortController();
        this.asking = controller;
        const total = plan.reduce((sum, { run }) => sum + run.count * (run.rows ?? 1), 0);
        let done = 0;
        this.progress.hidden = false;
        this.progress.value = 0;
        const question = { ...this.question(), runs: plan.map(({ sweep }) => sweep) };
        try {
            for await (const message of this.ask("diagram", question, controller.signal)) {
                if (message.kind === REMARK) this.say(text(message));
                if (message.kind === DOCUMENT) {
                    const document = document_of(message);
                    if (document.outcomes) this.outcomes = document.outcomes;
                    if (document.attractors) {
                        this.rows.attractors = document.attractors;
                        this.show_legend();
                        this.show_box();
                    }
                }
                if (message.kind === NUMBERS) this.rows.tell_apart(numbers(message), plan, diagram);
                if (message.kind !== ROW) continue;
                this.rows.take(numbers(message), plan, diagram);
                done += 1;
                this.progress.value = done / total;
                this.flow();
            }
            this.error.hidden = true;
            if (this.asking === controller) this.finish();
        } catch (error) {
            if (this.asking !== controller || is_abort(error)) return;
            this.finish();
            this.plot.canvas.dataset.state = "refused";
            this.error.textContent = error instanceof Refused ? [error.message, error.refusal.help].filter(Boolean).join(". ") : String(error);
            this.error.hidden = false;
        }
    }

    show_legend() {
        this.legend.replaceChildren(...legend(this.rows, this.outcomes, this.diagram, theme()));
    }

    /** Rows have come in. */
    flow() {
        const now = performance.now();
        if (now - this.counted < FLOW) return;
        this.counted = now;
        this.show_box();
    }

    finish() {
        this.asking = null;
        this.progress.hidden = true;
        this.counted = 0;
        this.show_box();
        this.plot.canvas.dataset.columns = String(this.rows.visible(this.diagram));
        this.plot.canvas.dataset.state = "complete";
        this.show_legend();
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("../drawing/palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { diagram } = this;
        const { width, height } = plot.area;
        const ratio = plot.ratio ?? 1;
        if (diagram.second) {
            this.rows.plane.draw(context, plot, this.outcomes);
        } else {
            const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
            const moving = this.dragging && this.raster.took > FRAME;
            if (this.stale && !moving) {
                const step = (diagram.to - diagram.from) / (2 * COARSE);
                this.raster.draw(this.rows.in_order(), plot.box, wide, high, Math.max(1, Math.round(ratio)), layers(this.rows, diagram, colors), step, slope_of(diagram));
                this.stale = false;
            }
            this.raster.show(context, plot);
        }
        this.overlay.draw(context, plot, colors);
        const { picked, set } = this.store.state;
        if (picked !== null) draw_picked(context, plot, colors.accent, [picked, diagram.second ? Number(set[diagram.second]) : null]);
    }

    /**
     * @param {Box} box
     * @param {boolean} done
     */
    moved(box, done) {
        const { diagram } = this;
        this.dragging = !done;
        this.stale = true;
        look_at(diagram, box);
        if (done) this.store.change("view", ({ diagram }) => look_at(diagram, readable(box)));
    }

    /** Shows everything: the range that was typed last, or the values that are known. */
    reset() {
        const { plane, lattice: { from, width } } = this.rows;
        this.store.change("view", ({ diagram }) => {
            Object.assign(diagram, { from, to: from + width, y: null });
            if (diagram.second) Object.assign(diagram, plane.home);
        });
    }

    /**
     * @param {number} x
     * @param {number} y
     */
    pick(x, y) {
        const { diagram } = this;
        if (diagram.second && this.overlay.follow_near(this.plot, this.plot.px(x), this.plot.py(y))) return;
        const column = diagram.second ? null : this.rows.nearest(x);
        const near = column && Math.abs(this.plot.px(column.x) - this.plot.px(x)) < 6;
        const value = near ? column.x : rounded(x, (diagram.to - diagram.from) / 1e4);
        this.store.change("motion", (state) => {
            state.picked = value;
            state.through = null;
            if (diagram.second) state.set[diagram.second] = String(rounded(y, (diagram.second_to - diagram.second_from) / 1e4));
        });
    }

    /**
     * Takes the periodic orbit that is near along its branch.
     * @param {number} px
     * @param {number} py
     * @param {boolean} first
     */
    grab(px, py, first) {
        const found = this.overlay.nearest(this.plot, px, py, first);
        if (!found) return false;
        this.store.change("motion", (state) => Object.assign(state, { picked: found.value, through: found.state }));
        this.readout.textContent = found.words;
        return true;
    }

    /** @param {number} direction */
    step(direction) {
        const { picked, diagram } = this.store.state;
        const columns = this.rows.in_order().filter(({ x }) => x >= diagram.from && x <= diagram.to);
        if (columns.length === 0) return;
        const here = picked ?? (diagram.from + diagram.to) / 2;
        const next = direction > 0 ? columns.find(({ x }) => x > here) : columns.findLast(({ x }) => x < here);
        if (next) this.pick(next.x, NaN);
        this.hover({ x: next?.x ?? here, y: NaN });
    }

    /** @param {{ x: number, y: number } | null} at */
    hover(at) {
        const { diagram } = this;
        if (!at) {
            this.readout.textContent = "";
            return;
        }
        const parts = there(this.rows, diagram, this.outcomes, at);
        if (parts.length === 0) return;
        this.readout.textContent = parts.join("  ·  ");
    }
}
