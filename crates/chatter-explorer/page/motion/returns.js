/** The return map: each sample against the one before, the cobweb between them, and the curve that they are on where it is one;
 * near a border the universal map. */

import { disc } from "../drawing/curves.js";
import { make } from "../elements/dom.js";
import { axis_label } from "../drawing/labels.js";
import { gifts, panel } from "../elements/panel.js";
import { Plot, extent } from "../drawing/plot.js";
import { return_curve, universal_curve, universal_map } from "./return-curve.js";
import { shown } from "../drawing/ticks.js";
import { Latest, is_abort } from "../asking/transport.js";

/** @typedef {import("./motion.js").Motion} Motion */

/** A cobweb of more steps is a blot. */
const MOST_STEPS = 60;
/** Wait so long for a curve, in milliseconds, before it is given up for the next. */
const PATIENCE = 400;
/** What the universal map is called among quantities; no state is called so. */
const UNIVERSAL = "Υ(K z + μ)";

/**
 * The events at which orbits are sampled.
 * @param {Motion} motion
 * @param {string} sampling
 */
export function section_points(motion, sampling) {
    const [kind, name] = sampling.split(":");
    const wanted = kind === "section" ? "section" : name;
    const places = [];
    for (let place = 0; place < motion.events.kind.length; place += 1) {
        if (motion.events.kind[place] !== wanted) continue;
        if (kind === "section" && motion.events.place[place] !== name) continue;
        places.push(place);
    }
    return places;
}

export class ReturnView {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, motions, commands, say) {
        this.ask = ask;
        this.store = store;
        this.motions = motions;
        this.commands = commands;
        /** @type {Motion | null} */
        this.motion = null;
        /** @type {number[]} */
        this.values = [];
        /** @type {[number, number][]} */
        this.curve = [];
        /** @type {import("./return-curve.js").Sampled | null} how the curve is sampled, where there is one */
        this.sampled = null;
        /** @type {{ restitution: number, slope: number, mu: number } | null} */
        this.map = null;
        /** @type {[number, number]} */
        this.range = [0, 1];
        /** @type {string | undefined} what the curve is a curve of */
        this.key = undefined;
        this.latest = new Latest(PATIENCE);
        this.readout = make("output", { class: "readout" });
        this.plot = new Plot({
            label: "Return map with cobweb. Arrow keys move the view, plus and minus zoom, 0 shows all.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            reset: () => this.fit(),
            hover: (at) => (this.readout.textContent = at ? `${shown(at.x)} → ${shown(at.y)}` : this.words()),
        });
        this.select = make("select", { "aria-label": "Quantity of the return map", onchange: () => store.change("look", (state) => { state.returned = this.select.value; }) });
        this.element = panel("returns", "Return map", [this.select], make("div", { class: "body" }, this.plot.element, make("div", { class: "foot" }, this.readout)), gifts(ask, this.giving(), say));
        motions.on((motion) => {
            if (!motion) return;
            this.motion = motion;
            this.refresh();
        });
        store.on((change) => {
            if (change === "view" || change === "look") this.refresh();
            this.plot.repaint();
        });
    }

    /** The axes of a picture of it. */
    axes() {
        const { returned, diagram } = this.store.state;
        return `${returned},next:${diagram.sampling.split(":")[1]}`;
    }

    /** What is asked about the map of a motion. */
    question() {
        return { ...this.motions.question(), axes: [this.axes()] };
    }

    /** @returns {import("../elements/panel.js").Giving} */
    giving() {
        const { commands } = this;
        return {
            name: "return map",
            files: () => (this.map ? { asked: "universal", question: this.map } : { asked: "returns", question: { ...this.question(), sample: "events" } }),
            command: () => {
                if (this.map) return commands.universal(this.map);
                const crossings = commands.history("returns", [this.axes()], { sample: "events" });
                return this.sampled ? `${crossings} && ${commands.returned(this.sampled)}` : crossings;
            },
            python: () => (this.map ? commands.python_universal(this.map, this.range) : commands.python_returned(this.store.state.returned, Boolean(this.motion?.about.states.includes(this.store.state.returned)), this.sampled)),
        };
    }

    words() {
        if (this.map) return `K = ${shown(this.map.slope, 5)}  ·  μ = ${shown(this.map.mu, 5)}  ·  r = ${shown(this.map.restitution, 5)}`;
        const { length } = this.values;
        return length < 2 ? "too few crossings of the section in the time that is shown" : `${length} crossings`;
    }

    /** What can be shown, and what is. */
    refresh() {
        const { motion, store } = this;
        if (!motion) return;
        const names = /** @type {string[]} */ (motion.about.quantities);
        const map = universal_map(store);
        const { returned, diagram } = store.state;
        // An address may come before the border that it is about is found.
        const chosen = names.includes(returned) ? returned : returned === UNIVERSAL && map ? UNIVERSAL : names[0];
        if (returned !== UNIVERSAL) store.state.returned = chosen;
        this.select.replaceChildren(...[...names, ...(map ? [UNIVERSAL] : [])].map((name) => make("option", { value: name, ".selected": name === chosen }, name)));
        this.map = chosen === UNIVERSAL ? map : null;
        const at = motion.events.at.get(chosen);
        const places = section_points(motion, diagram.sampling);
        if (!this.map) this.values = at ? places.map((place) => at[place]) : [];
        const key = JSON.stringify(this.map ?? [this.question(), places.length]);
        if (key !== this.key) {
            this.key = key;
            this.curve = [];
            this.sampled = null;
            if (this.map) this.values = [];
            this.plot.canvas.dataset.curve = "";
            this.ask_for_curve(key);
        }
        this.fit();
    }

    /** @param {string} key what the curve is to be a curve of */
    ask_for_curve(key) {
        const { map } = this;
        // Where orbits are looked at in intervals of time there are no events to draw.
        if (!map && this.store.state.diagram.sampling.startsWith("period")) {
            this.latest.stop();
            return;
        }
        const question = this.question();
        this.latest.run(async (signal) => {
            try {
                if (map) {
                    const { curve, orbit, range } = await universal_curve(this.ask, map, signal);
                    if (this.key === key) Object.assign(this, { curve, range, values: Array.from(orbit) });
                } else {
                    const found = await return_curve(this.ask, question, signal);
                    if (found && this.key === key) Object.assign(this, found);
                }
            } catch (error) {
                if (is_abort(error)) return;
            }
            if (this.key !== key) return;
            this.plot.canvas.dataset.curve = this.curve.length ? JSON.stringify(this.curve) : "";
            this.fit();
        });
    }

    fit() {
        const { values, map } = this;
        const ends = map ? this.range : (extent(values, 0.1) ?? [0, 1]);
        this.plot.box = { x0: ends[0], x1: ends[1], y0: ends[0], y1: ends[1] };
        const label = map ? "z" : axis_label(this.store.state.returned, this.store.label(this.store.state.returned));
        this.plot.x_label = label;
        this.plot.y_label = map ? UNIVERSAL : `next ${label}`;
        this.plot.canvas.dataset.points = JSON.stringify(values);
        this.readout.textContent = this.words();
        this.plot.repaint();
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("../drawing/palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { values, curve } = this;
        const { x0, x1 } = plot.box;
        const stroke = (/** @type {string} */ color, /** @type {number} */ width, /** @type {() => void} */ path) => {
            context.beginPath();
            path();
            context.strokeStyle = color;
            context.lineWidth = width;
            context.lineJoin = "round";
            context.stroke();
        };
        stroke(colors.jump, 1, () => {
            context.moveTo(plot.px(x0), plot.py(x0));
            context.lineTo(plot.px(x1), plot.py(x1));
        });
        stroke(colors.ink, 1.5, () => {
            let down = false;
            for (const [x, y] of curve) {
                if (Number.isFinite(y)) context[down ? "lineTo" : "moveTo"](plot.px(x), plot.py(y));
                down = Number.isFinite(y);
            }
        });
        const first = Math.max(0, values.length - 1 - MOST_STEPS);
        context.globalAlpha = 0.55;
        stroke(colors.curve, 1, () => {
            for (let k = first; k + 1 < values.length; k += 1) {
                context[k === first ? "moveTo" : "lineTo"](plot.px(values[k]), plot.py(values[k]));
                context.lineTo(plot.px(values[k]), plot.py(values[k + 1]));
                context.lineTo(plot.px(values[k + 1]), plot.py(values[k + 1]));
            }
        });
        context.globalAlpha = 1;
        context.fillStyle = colors.ink;
        for (let k = 0; k + 1 < values.length; k += 1) disc(context, plot.px(values[k]), plot.py(values[k + 1]), 2.2);
    }
}
