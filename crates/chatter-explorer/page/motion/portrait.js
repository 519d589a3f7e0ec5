/** Any quantity against any other, with the points at which the section is crossed. */

import { curve, disc } from "../drawing/curves.js";
import { make } from "../elements/dom.js";
import { axis_label } from "../drawing/labels.js";
import { gifts, panel } from "../elements/panel.js";
import { Plot, extent } from "../drawing/plot.js";
import { section_points } from "./returns.js";
import { shown } from "../drawing/ticks.js";

export class PortraitView {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, motions, commands, say) {
        this.store = store;
        /** @type {import("./motion.js").Motion | null} */
        this.motion = null;
        /** @type {number | null} */
        this.now = null;
        this.readout = make("output", { class: "readout" });
        this.plot = new Plot({
            label: "Phase portrait. Arrow keys move the view, plus and minus zoom, 0 shows all.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            moved: () => (this.by_hand = true),
            reset: () => {
                this.by_hand = false;
                this.fit();
            },
            hover: (at) => (this.readout.textContent = at ? `${shown(at.x)}, ${shown(at.y)}` : ""),
        });
        this.by_hand = false;
        const select = (/** @type {number} */ axis) => {
            const element = make("select", {
                "aria-label": axis === 0 ? "Quantity across" : "Quantity upwards",
                onchange: () => {
                    this.by_hand = false;
                    store.change("look", (state) => { state.portrait[axis] = element.value; });
                    this.fit();
                },
            });
            return element;
        };
        this.selects = [select(0), select(1)];
        const axes = () => store.state.portrait.map((name) => (name === "time" ? commands.time() : name)).join(",");
        const of_run = (/** @type {string} */ name) => (name === "time" ? "run.t" : `run[${JSON.stringify(name)}]`);
        const menu = gifts(ask, {
            name: "phase portrait",
            files: () => ({ asked: "history", question: { ...motions.question(), axes: [axes()] } }),
            command: () => commands.history("portrait", [axes()]),
            python: () => commands.python_history(`plt.plot(${this.store.state.portrait.map(of_run).join(", ")})`),
        }, say);
        this.element = panel("portrait", "Phase portrait", [this.selects[0], make("span", { class: "quiet" }, "×"), this.selects[1]], make("div", { class: "body" }, this.plot.element, make("div", { class: "foot" }, this.readout)), menu);
        motions.on((motion) => this.take(motion));
        store.on(() => this.plot.repaint());
    }

    /** @param {import("./motion.js").Motion | null} motion */
    take(motion) {
        if (!motion) return;
        this.motion = motion;
        const names = ["time", ...motion.about.quantities];
        this.selects.forEach((select, axis) => {
            const chosen = this.store.state.portrait[axis];
            const known = names.includes(chosen) ? chosen : names[Math.min(axis + 1, names.length - 1)];
            this.store.state.portrait[axis] = known;
            select.replaceChildren(...names.map((name) => make("option", { value: name, ".selected": name === known }, name)));
        });
        this.fit();
    }

    /** @returns {(Float64Array | undefined)[]} */
    series() {
        return this.store.state.portrait.map((name) => this.motion?.series.get(name));
    }

    fit() {
        const [x, y] = this.series();
        if (!x || !y) return;
        if (!this.by_hand) {
            const [x0, x1] = extent(x, 0.06) ?? [0, 1];
            const [y0, y1] = extent(y, 0.08) ?? [0, 1];
            this.plot.box = { x0, x1, y0, y1 };
        }
        const [across, up] = this.store.state.portrait;
        this.plot.x_label = axis_label(across, this.store.label(across));
        this.plot.y_label = axis_label(up, this.store.label(up));
        this.plot.repaint();
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("../drawing/palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const { motion } = this;
        const [x, y] = this.series();
        if (!motion || !x || !y) return;
        curve(context, plot, colors, x, y, motion.jumps);
        const [across, up] = this.store.state.portrait;
        const places = section_points(motion, this.store.state.diagram.sampling);
        const [of_x, of_y] = [motion.events.at.get(across), motion.events.at.get(up)];
        context.fillStyle = colors.accent;
        for (const place of places) {
            const px = across === "time" ? motion.events.time[place] : of_x?.[place];
            const py = up === "time" ? motion.events.time[place] : of_y?.[place];
            if (px !== undefined && py !== undefined) disc(context, plot.px(px), plot.py(py), 2.6);
        }
        if (this.now !== null) {
            const time = /** @type {Float64Array} */ (motion.series.get("time"));
            let place = 0;
            while (place + 1 < time.length && time[place + 1] <= this.now) place += 1;
            context.fillStyle = colors.ink;
            disc(context, plot.px(x[place]), plot.py(y[place]), 4.5);
        }
    }
}
