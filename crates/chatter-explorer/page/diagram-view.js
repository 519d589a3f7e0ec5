/** The orbit diagram: sharpens column by column, keeps what it has, and shows where the picked value is. */

import { choice, field, make } from "./dom.js";
import { Lattice } from "./lattice.js";
import { axis_label } from "./labels.js";
import { Overlay } from "./overlay.js";
import { OUTCOMES, PERIODS, class_of } from "./palette.js";
import { gifts, panel } from "./panel.js";
import { Plane } from "./plane.js";
import { Plot, extent } from "./plot.js";
import { Raster } from "./raster.js";
import { DOCUMENT, REMARK, ROW, document_of, numbers, text } from "./records.js";
import { sampled } from "./state.js";
import { rounded, shown } from "./ticks.js";
import { Refused, is_abort } from "./transport.js";

/** @typedef {import("./raster.js").Column} Column */
/** @typedef {import("./plot.js").Box} Box */

/** Numbers of a row before its samples. */
const HEAD = 8;
/** Columns of the first picture. */
const COARSE = 64;
/** Cells across a map's first picture, and of its last for so many columns. */
const COARSE_MAP = 16;
const fine_map = (/** @type {number} */ columns) => Math.max(COARSE_MAP, Math.min(512, columns / 4));
/** After a change by hand, so long nothing is asked, in milliseconds. */
const REST = 160;
/** A picture that takes longer is moved as it is while it is dragged. */
const FRAME = 9;
/** While rows come in, the picture is counted again so often, in milliseconds. */
const FLOW = 90;

export class DiagramView {
    /**
     * @param {import("./transport.js").Ask} ask
     * @param {import("./state.js").Store} store
     * @param {import("./commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, commands, say) {
        this.ask = ask;
        this.store = store;
        this.commands = commands;
        this.say = say;
        this.raster = new Raster();
        this.plane = new Plane();
        this.overlay = new Overlay(ask, store, commands, say, () => this.plot.repaint());
        /** @type {Map<number, Column>} */
        this.columns = new Map();
        /** @type {Column[] | null} in the order of their values; none where that is to be found again */
        this.sorted = null;
        this.lattice = new Lattice(0, 1);
        /** @type {string[]} */
        this.outcomes = [];
        this.question_key = "";
        /** @type {AbortController | null} */
        this.asking = null;
        this.timer = 0;
        this.counted = 0;
        this.stale = true;
        this.settings_shown = false;
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
        this.readout = make("output", { class: "readout", "aria-live": "polite" });
        this.progress = make("progress", { max: 1, value: 0, "aria-label": "how much of the diagram is there", hidden: true });
        this.error = make("p", { class: "error", role: "alert", hidden: true });
        this.legend = make("div", { class: "legend" });
        this.toolbar = make("div", { class: "toolbar" });
        const menu = gifts(ask, {
            files: () => ({ asked: "diagram", question: { ...this.question(), runs: [this.whole()] } }),
            command: () => commands.diagram(this.size()),
            python: () => commands.python_diagram(this.size()),
        }, say);
        this.element = panel("diagram", "Orbit diagram", [], make("div", { class: "body" }, this.toolbar, this.error, this.plot.element, make("div", { class: "foot" }, this.readout, this.legend, this.progress), this.overlay.element), menu);
        store.on((change) => {
            if (change === "model") this.controls();
            if (change !== "look" && change !== "motion") this.refresh(change === "values");
            this.plot.repaint();
        });
    }

    get diagram() {
        return this.store.state.diagram;
    }

    /** How many columns, or rows of a map, a file has. */
    size() {
        return this.diagram.second ? fine_map(this.diagram.columns) : this.diagram.columns;
    }

    /** The sweep that a file is made of: what is seen. */
    whole() {
        const { over, from, to, second, second_from, second_to } = this.diagram;
        const first = `${over}=${from}:${to}:${this.size()}`;
        return second ? [first, `${second}=${second_from}:${second_to}:${this.size()}`] : [first];
    }

    question() {
        const { diagram } = this;
        const model = this.store.model(false);
        model.set = model.set.filter(([name]) => name !== diagram.over && name !== diagram.second);
        return {
            model,
            ...sampled(diagram.sampling),
            observe: [diagram.observe],
            transient: diagram.transient,
            keep: String(diagram.keep),
            start: diagram.start,
            bounds: this.commands.bounds(),
            exponent: diagram.exponent,
        };
    }

    /** What can be chosen. */
    controls() {
        const { store, diagram } = this;
        const checked = store.checked;
        if (!checked) return;
        const edit = (/** @type {(diagram: import("./state.js").Diagram) => void} */ how, home = false) =>
            store.change("view", (state) => {
                how(state.diagram);
                if (home) state.diagram.y = null;
            });
        const parameters = /** @type {[string, string][]} */ (checked.parameters.filter((one) => !one.unused).map((one) => [one.name, one.name]));
        const around = (/** @type {string} */ name) => {
            const value = checked.parameters.find((one) => one.name === name)?.value ?? 1;
            return value === 0 ? [-1, 1] : [value - 0.25 * Math.abs(value), value + 0.25 * Math.abs(value)].map((end) => rounded(end, Math.abs(value) / 100));
        };
        const number = (/** @type {string} */ label, /** @type {number} */ value, /** @type {(value: number) => void} */ set, /** @type {object} */ limits = {}) =>
            make("input", {
                type: "number", step: "any", ".value": String(value), "aria-label": label, ...limits,
                onchange: (/** @type {Event} */ event) => {
                    const input = /** @type {HTMLInputElement} */ (event.target);
                    if (input.value !== "" && Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber);
                },
            });
        const over = choice("Parameter across", parameters, diagram.over, (name) => {
            const [from, to] = around(name);
            store.change("view", (state) => {
                Object.assign(state.diagram, { over: name, from, to, y: null, slope: 0 });
                if (state.diagram.second === name) state.diagram.second = "";
                state.picked = null;
                state.through = null;
            });
            this.controls();
        });
        const from = number("from", diagram.from, (value) => edit((diagram) => { if (value < diagram.to) diagram.from = value; }, true));
        const to = number("to", diagram.to, (value) => edit((diagram) => { if (value > diagram.from) diagram.to = value; }, true));
        this.ends = [from, to];
        const others = /** @type {[string, string][]} */ ([["", "observe a quantity"], ...parameters.filter(([name]) => name !== diagram.over).map(([name]) => [name, `parameter ${name}`])]);
        const second = choice("Upwards", others, diagram.second, (name) => {
            const [low, high] = name ? around(name) : [0, 1];
            store.change("view", (state) => Object.assign(state.diagram, { second: name, second_from: low, second_to: high, y: null }));
            this.controls();
        });
        const list = make("datalist", { id: "quantities" }, ...checked.states.filter((state) => !state.time).map((state) => make("option", { value: state.name })), make("option", { value: "impacts" }));
        const observe = make("input", {
            type: "text", list: "quantities", size: 8, ".value": diagram.observe, "aria-label": "Observed quantity, an expression", spellcheck: "false",
            onchange: () => edit((diagram) => { diagram.observe = observe.value.trim() || diagram.observe; diagram.slope = 0; }, true),
        });
        const start = choice("Where orbits start", [["fresh", "afresh"], ["carry", "carried up"], ["carry:down", "carried down"], ["carry:both", "carried both ways"], ["random:4", "at random"]], diagram.start, (value) => {
            if (value.startsWith("random") && !diagram.bounds) this.propose_bounds();
            edit((diagram) => { diagram.start = value; }, true);
            this.controls();
        });
        const bounds = make("input", {
            type: "text", size: 22, ".value": diagram.bounds, "aria-label": "Bounds of random starts", placeholder: "y1=0:1, y2=-1:1", spellcheck: "false",
            onchange: () => edit((diagram) => { diagram.bounds = bounds.value; }),
        });
        const where = /** @type {[string, string][]} */ ([...checked.sections.map((section) => [`section:${section.name}`, `section ${section.name}`]), ...(checked.contacts.length ? [["at:impact", "every impact"], ["at:release", "every release"]] : [])]);
        if (!where.some(([value]) => value === diagram.sampling)) where.push([diagram.sampling, diagram.sampling.replace(":", " ")]);
        const sampling = choice("Where orbits are sampled", where, diagram.sampling, (value) => edit((diagram) => { diagram.sampling = value; }, true));
        const columns = choice("Columns", ["128", "256", "512", "1024", "2048", "4096"].map((count) => [count, count]), String(diagram.columns), (value) => edit((diagram) => { diagram.columns = Number(value); }));
        const whole = { min: 0, step: 1 };
        const more = make(
            "details",
            { class: "more", ".open": this.settings_shown, ontoggle: () => (this.settings_shown = more.open) },
            make("summary", {}, "More"),
            make(
                "div", { class: "row" },
                field("sampled at", sampling),
                field("columns", columns),
                field("passed over", number("Samples passed over", diagram.transient, (value) => edit((diagram) => { diagram.transient = Math.max(0, Math.round(value)); }), whole)),
                field("kept", number("Samples kept", diagram.keep, (value) => edit((diagram) => { diagram.keep = Math.max(1, Math.round(value)); }), { ...whole, min: 1 })),
                field("exponent", make("input", { type: "checkbox", ".checked": diagram.exponent, onchange: (/** @type {Event} */ event) => edit((diagram) => { diagram.exponent = /** @type {HTMLInputElement} */ (event.target).checked; }) })),
            ),
        );
        const level = make("button", { type: "button", title: "Draw a slanted diagram level", "aria-pressed": String(this.slope() !== 0), hidden: diagram.second !== "", onclick: () => {
            edit((diagram) => { diagram.slope = diagram.slope ? 0 : this.fitted(); }, true);
            this.controls();
        } }, "Level");
        const all = make("button", { type: "button", title: "Show all (0)", onclick: () => this.reset() }, "All");
        this.toolbar.replaceChildren(
            make("div", { class: "row" }, field("over", over), field("from", from), field("to", to), field("upwards", second), diagram.second ? "" : field("observed", observe), list, field("starts", start), diagram.start.startsWith("random") ? field("within", bounds) : "", level, all),
            more,
        );
    }

    /** Bounds for random starts: some way around the initial values. */
    propose_bounds() {
        const states = this.store.checked?.states.filter((state) => !state.time) ?? [];
        const bound = (/** @type {{ name: string, value: number }} */ { name, value }) => `${name}=${shown_plain(value)}:${shown_plain(value + Math.max(1, Math.abs(value) * 0.2))}`;
        this.diagram.bounds = states.slice(0, 2).map(bound).join(", ");
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
            this.columns = new Map();
            this.sorted = null;
            this.plane.clear(diagram);
            const width = diagram.to - diagram.from;
            this.lattice = new Lattice(diagram.from, width);
            this.asking?.abort();
        } else if (diagram.start.startsWith("carry")) {
            // A carried orbit remembers where the sweep began.
            this.asking?.abort();
        }
        this.show_box();
        window.clearTimeout(this.timer);
        this.timer = window.setTimeout(() => void this.compute(), soon ? REST : REST / 4);
    }

    /** The plot's box after the state's. */
    show_box() {
        const { diagram } = this;
        const y = diagram.second ? [diagram.second_from, diagram.second_to] : (diagram.y ?? this.seen() ?? [this.plot.box.y0, this.plot.box.y1]);
        this.plot.box = { x0: diagram.from, x1: diagram.to, y0: y[0], y1: y[1] };
        this.plot.x_label = axis_label(diagram.over, this.store.label(diagram.over));
        const up = diagram.second || diagram.observe;
        this.plot.y_label = axis_label(up, this.store.label(up)) + (this.slope() ? `  −  ${shown(this.slope(), 4)} ${diagram.over}` : "");
        if (this.ends && document.activeElement !== this.ends[0] && document.activeElement !== this.ends[1]) {
            const step = (diagram.to - diagram.from) / 1000;
            this.ends[0].value = String(rounded(diagram.from, step));
            this.ends[1].value = String(rounded(diagram.to, step));
        }
        this.stale = true;
        this.plot.repaint();
    }

    /** @returns {Column[]} */
    in_order() {
        this.sorted ??= [...this.columns.values()].sort((one, other) => one.x - other.x);
        return this.sorted;
    }

    /** The range of the samples that are seen. */
    seen() {
        const { from, to } = this.diagram;
        let [low, high] = [Infinity, -Infinity];
        for (const { x, rows } of this.in_order()) {
            if (x < from || x > to) continue;
            for (const row of rows) {
                if (!row || row.samples.length === 0) continue;
                const ends = extent(row.samples, 0);
                if (!ends) continue;
                low = Math.min(low, ends[0] - this.slope() * x);
                high = Math.max(high, ends[1] - this.slope() * x);
            }
        }
        return low > high ? null : extent([low, high]);
    }

    slope() {
        return this.diagram.second ? 0 : this.diagram.slope;
    }

    /** The slope of the line that fits what is seen best. */
    fitted() {
        const { from, to } = this.diagram;
        const points = this.in_order().filter(({ x }) => x >= from && x <= to).flatMap(({ x, rows }) => {
            const samples = rows.find((row) => row)?.samples;
            return samples?.length ? [{ x, y: samples.reduce((sum, value) => sum + value, 0) / samples.length }] : [];
        });
        const mean = (/** @type {(point: { x: number, y: number }) => number} */ of) => points.reduce((sum, point) => sum + of(point), 0) / points.length;
        const [x, y] = [mean((point) => point.x), mean((point) => point.y)];
        const slope = mean((point) => (point.x - x) * (point.y - y)) / mean((point) => (point.x - x) ** 2);
        return Number.isFinite(slope) ? Number(slope.toPrecision(4)) : 0;
    }

    /** The sweeps that are missing, the coarse ones first. */
    plan() {
        const { diagram, lattice } = this;
        const ends = (/** @type {string} */ name, /** @type {Lattice} */ lattice, /** @type {import("./lattice.js").Run} */ run) => {
            const last = run.first + (run.count - 1) * run.stride;
            return `${name}=${lattice.value(run.level, run.first)}:${lattice.value(run.level, last)}:${run.count}`;
        };
        if (diagram.second) return this.plane.plan(diagram, COARSE_MAP, this.size());
        /** @type {{ sweep: string[], run: import("./lattice.js").Run & { rows?: number } }[]} */
        const plan = [];
        const carried = diagram.start.startsWith("carry");
        const coarse = lattice.level(diagram.from, diagram.to, Math.min(COARSE, diagram.columns));
        const fine = lattice.level(diagram.from, diagram.to, diagram.columns);
        const known = new Set(carried ? [] : this.columns.keys());
        for (let level = coarse; level <= fine; level += 1) {
            const runs = lattice.missing(level, diagram.from, diagram.to, (key) => !carried && known.has(key));
            for (const run of runs) {
                for (let k = 0; k < run.count; k += 1) known.add(lattice.key(level, run.first + k * run.stride));
                plan.push({ sweep: [ends(diagram.over, lattice, run)], run });
            }
        }
        return plan;
    }

    async compute() {
        this.asking?.abort();
        const plan = this.plan();
        this.plot.canvas.dataset.state = plan.length ? "computing" : "complete";
        this.plot.canvas.dataset.columns = String(this.visible());
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
                }
                if (message.kind !== ROW) continue;
                this.take(numbers(message), plan);
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

    /**
     * @param {Float64Array} row
     * @param {{ run: any }[]} plan
     */
    take(row, plan) {
        const [number, pass, x, y, outcome, period, impacts, exponent] = row;
        const { run } = plan[number];
        const of_row = { outcome, period, impacts, exponent, samples: row.subarray(HEAD) };
        if (this.diagram.second) {
            this.plane.take(run, x, y, of_row);
            return;
        }
        const last = run.first + (run.count - 1) * run.stride;
        const [low, high] = [this.lattice.value(run.level, run.first), this.lattice.value(run.level, last)];
        const index = run.count > 1 ? Math.round(((x - low) / (high - low)) * (run.count - 1)) : 0;
        const key = this.lattice.key(run.level, run.first + index * run.stride);
        let column = this.columns.get(key);
        if (!column) {
            column = { x, key, level: run.level, rows: [] };
            this.columns.set(key, column);
            this.sorted = null;
        }
        column.rows[pass] = of_row;
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
        this.plot.canvas.dataset.columns = String(this.visible());
        this.plot.canvas.dataset.state = "complete";
        this.show_legend();
    }

    /** How many columns, or cells of a map, are seen. */
    visible() {
        const { from, to, second } = this.diagram;
        if (second) return this.plane.cells.size;
        return this.in_order().filter(({ x }) => x >= from && x <= to).length;
    }

    show_legend() {
        const { diagram } = this;
        const item = (/** @type {string} */ name, /** @type {string} */ color) => make("span", { class: "key" }, make("i", { ".style": `background:${color}` }), name);
        /** @type {HTMLElement[]} */
        let items = [];
        if (diagram.second) {
            const present = new Set([...this.plane.cells.values()].map((cell) => class_of(this.outcomes[cell.row.outcome], cell.row.period)[0]));
            const all = [...PERIODS.map(([, name, color]) => /** @type {[string, string]} */ ([name, color])), ...Object.values(OUTCOMES)];
            items = all.filter(([name]) => present.has(name)).map(([name, color]) => item(name, color));
        } else if (diagram.start === "carry:both") {
            items = [item("upwards", "var(--points)"), item("downwards", "var(--second)")];
        }
        this.legend.replaceChildren(...items);
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("./palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { diagram } = this;
        const { width, height } = plot.area;
        const ratio = plot.ratio ?? 1;
        if (diagram.second) {
            this.plane.draw(context, plot, this.outcomes);
        } else {
            const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
            const moving = this.dragging && this.raster.took > FRAME;
            if (this.stale && !moving) {
                const passes = diagram.start === "carry:both" ? [colors.points, colors.second] : [colors.points];
                const step = (diagram.to - diagram.from) / (2 * COARSE);
                this.raster.draw(this.in_order(), plot.box, wide, high, Math.max(1, Math.round(ratio)), passes, step, this.slope());
                this.stale = false;
            }
            this.raster.show(context, plot);
        }
        this.overlay.draw(context, plot, colors);
        const { picked } = this.store.state;
        if (picked !== null) {
            const at = Math.round(plot.px(picked)) + 0.5;
            context.strokeStyle = colors.accent;
            context.lineWidth = 1.25;
            context.beginPath();
            context.moveTo(at, plot.area.top);
            context.lineTo(at, plot.area.top + height);
            context.stroke();
            if (diagram.second) {
                const value = Number(this.store.state.set[diagram.second]);
                const up = Math.round(plot.py(value)) + 0.5;
                context.beginPath();
                context.moveTo(plot.area.left, up);
                context.lineTo(plot.area.left + width, up);
                context.stroke();
            }
        }
    }

    /**
     * @param {Box} box
     * @param {boolean} done
     */
    moved(box, done) {
        const { diagram } = this;
        this.dragging = !done;
        this.stale = true;
        Object.assign(diagram, { from: box.x0, to: box.x1 });
        if (diagram.second) Object.assign(diagram, { second_from: box.y0, second_to: box.y1 });
        else diagram.y = [box.y0, box.y1];
        if (done) {
            // Numbers that can be read and written down.
            const x = (box.x1 - box.x0) / 1e4;
            const y = (box.y1 - box.y0) / 1e4;
            this.store.change("view", ({ diagram }) => {
                Object.assign(diagram, { from: rounded(box.x0, x), to: rounded(box.x1, x) });
                const up = /** @type {[number, number]} */ ([rounded(box.y0, y), rounded(box.y1, y)]);
                if (diagram.second) Object.assign(diagram, { second_from: up[0], second_to: up[1] });
                else diagram.y = up;
            });
        }
    }

    /** Shows everything: the range that was typed last, or the values that are known. */
    reset() {
        const { from, width } = this.lattice;
        const { plane } = this;
        this.store.change("view", ({ diagram }) => {
            Object.assign(diagram, { from, to: from + width, y: null });
            if (diagram.second) Object.assign(diagram, plane.home);
        });
    }

    /** @param {number} x */
    nearest(x) {
        const columns = this.in_order();
        let best = null;
        let distance = Infinity;
        for (const column of columns) {
            const off = Math.abs(column.x - x);
            if (off < distance) [best, distance] = [column, off];
        }
        return best;
    }

    /**
     * @param {number} x
     * @param {number} y
     */
    pick(x, y) {
        const { diagram } = this;
        const column = diagram.second ? null : this.nearest(x);
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
        const columns = this.in_order().filter(({ x }) => x >= diagram.from && x <= diagram.to);
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
        const parts = [];
        if (diagram.second) {
            const cell = this.plane.at(at.x, at.y);
            parts.push(`${diagram.over} = ${shown(at.x)}`, `${diagram.second} = ${shown(at.y)}`);
            if (cell) parts.push(...this.words(cell.row));
        } else {
            const column = this.nearest(at.x);
            if (!column) return;
            parts.push(`${diagram.over} = ${shown(column.x, 8)}`);
            const [row] = column.rows.filter((row) => row);
            if (row) parts.push(...this.words(row));
            if (Number.isFinite(at.y)) parts.push(`${diagram.observe} = ${shown(at.y + this.slope() * at.x)}`);
        }
        this.readout.textContent = parts.join("  ·  ");
    }

    /** @param {import("./raster.js").Row} row */
    words(row) {
        const outcome = this.outcomes[row.outcome] ?? "";
        const name = outcome === "periodic" ? `period ${row.period}` : (OUTCOMES[outcome]?.[0] ?? outcome);
        const words = [name];
        if (!Number.isNaN(row.impacts)) words.push(`${shown(row.impacts, 4)} impacts per return`);
        if (!Number.isNaN(row.exponent)) words.push(`exponent ${shown(row.exponent, 3)}`);
        return words;
    }
}

/** @param {number} value */
const shown_plain = (value) => String(Number(value.toPrecision(6)));
