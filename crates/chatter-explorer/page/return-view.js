/** The return map: each sample against the one before, and the cobweb between them. */

import { disc } from "./curves.js";
import { make } from "./dom.js";
import { axis_label } from "./labels.js";
import { gifts, panel } from "./panel.js";
import { Plot, extent } from "./plot.js";
import { shown } from "./ticks.js";

/** @typedef {import("./motion.js").Motion} Motion */

/** A cobweb of more steps is a blot. */
const MOST_STEPS = 60;

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
     * @param {import("./transport.js").Ask} ask
     * @param {import("./state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {import("./commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, motions, commands, say) {
        this.store = store;
        /** @type {Motion | null} */
        this.motion = null;
        /** @type {number[]} */
        this.values = [];
        this.readout = make("output", { class: "readout" });
        this.plot = new Plot({
            label: "Return map with cobweb. Arrow keys move the view, plus and minus zoom, 0 shows all.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            reset: () => this.fit(),
            hover: (at) => (this.readout.textContent = at ? `${shown(at.x)} → ${shown(at.y)}` : this.words()),
        });
        this.select = make("select", { "aria-label": "Quantity of the return map", onchange: () => { store.change("look", (state) => { state.returned = this.select.value; }); this.fit(); } });
        const menu = gifts(ask, {
            files: () => null,
            command: () => commands.history(),
            python: () => `${commands.python_history()}; x = run.events["section"]`,
            csv: () => ["x,next", ...this.values.slice(1).map((next, place) => `${this.values[place]},${next}`)].join("\n"),
        }, say);
        this.element = panel("returns", "Return map", [this.select], make("div", { class: "body" }, this.plot.element, make("div", { class: "foot" }, this.readout)), menu);
        motions.on((motion) => {
            if (!motion) return;
            this.motion = motion;
            const names = /** @type {string[]} */ (motion.about.quantities);
            if (!names.includes(store.state.returned)) store.state.returned = names[0];
            this.select.replaceChildren(...names.map((name) => make("option", { value: name, ".selected": name === store.state.returned }, name)));
            this.fit();
        });
        store.on((change) => {
            if (change === "view") this.fit();
            this.plot.repaint();
        });
    }

    words() {
        const { length } = this.values;
        return length < 2 ? "too few crossings of the section in the time that is shown" : `${length} crossings`;
    }

    fit() {
        const { motion } = this;
        if (!motion) return;
        const { returned, diagram } = this.store.state;
        const at = motion.events.at.get(returned);
        this.values = at ? section_points(motion, diagram.sampling).map((place) => at[place]) : [];
        const ends = extent(this.values, 0.1) ?? [0, 1];
        this.plot.box = { x0: ends[0], x1: ends[1], y0: ends[0], y1: ends[1] };
        const label = axis_label(returned, this.store.label(returned));
        this.plot.x_label = label;
        this.plot.y_label = `next ${label}`;
        this.readout.textContent = this.words();
        this.plot.repaint();
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("./palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { values } = this;
        const { x0, x1 } = plot.box;
        context.strokeStyle = colors.jump;
        context.lineWidth = 1;
        context.beginPath();
        context.moveTo(plot.px(x0), plot.py(x0));
        context.lineTo(plot.px(x1), plot.py(x1));
        context.stroke();
        const first = Math.max(0, values.length - 1 - MOST_STEPS);
        context.beginPath();
        for (let k = first; k + 1 < values.length; k += 1) {
            context[k === first ? "moveTo" : "lineTo"](plot.px(values[k]), plot.py(values[k]));
            context.lineTo(plot.px(values[k]), plot.py(values[k + 1]));
            context.lineTo(plot.px(values[k + 1]), plot.py(values[k + 1]));
        }
        context.strokeStyle = colors.curve;
        context.globalAlpha = 0.55;
        context.stroke();
        context.globalAlpha = 1;
        context.fillStyle = colors.ink;
        for (let k = 0; k + 1 < values.length; k += 1) disc(context, plot.px(values[k]), plot.py(values[k + 1]), 2.2);
    }
}
