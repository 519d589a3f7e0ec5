/** The sequence of impacts, their rates in logarithmic scale: complete chatter is a straight line. */

import { disc } from "../drawing/curves.js";
import { choice, field, make } from "../elements/dom.js";
import { gifts, panel } from "../elements/panel.js";
import { BLUE, GREEN, ORANGE, PURPLE, VERMILION } from "../drawing/palette.js";
import { Plot, extent } from "../drawing/plot.js";
import { shown } from "../drawing/ticks.js";

const COLORS = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, "#999999"];

export class ImpactsView {
    /**
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(ask, store, motions, commands, say) {
        /** @type {import("./motion.js").Motion | null} */
        this.motion = null;
        this.over = "number";
        this.by_hand = false;
        this.readout = make("output", { class: "readout" });
        this.plot = new Plot({
            label: "Rates of impacts in logarithmic scale. Arrow keys move the view, plus and minus zoom, 0 shows all.",
            draw: (context, plot, colors) => this.draw(context, plot, colors),
            moved: () => (this.by_hand = true),
            reset: () => {
                this.by_hand = false;
                this.fit();
            },
            hover: (at) => (this.readout.textContent = at ? `${this.over === "number" ? `impact ${Math.max(1, Math.round(at.x))}` : `time ${shown(at.x)}`}  ·  rate ${shown(10 ** at.y, 4)}` : ""),
        });
        this.plot.logarithmic.y = true;
        const over = choice("Over", [["number", "number"], ["time", "time"]], this.over, (value) => {
            this.over = value;
            this.by_hand = false;
            this.fit();
        });
        const axes = () => `${this.over === "time" ? commands.time() : "impact"},rate_before`;
        const menu = gifts(ask, {
            name: "impacts",
            files: () => ({ asked: "history", question: { ...motions.question(), axes: [axes()], sample: "events" } }),
            command: () => commands.history("impacts", [axes()], { sample: "events" }),
            python: () => commands.python_history(`e = ${commands.python_events("at:impact")}; plt.semilogy(${this.over === "time" ? "e.time, " : "range(1, len(e) + 1), "}-e.rate_before, ".")`),
        }, say);
        this.element = panel("impacts", "Impacts", [field("over", over)], make("div", { class: "body" }, this.plot.element, make("div", { class: "foot" }, this.readout)), menu);
        motions.on((motion) => {
            if (!motion) return;
            this.motion = motion;
            this.fit();
        });
        store.on(() => this.plot.repaint());
    }

    points() {
        const { motion } = this;
        if (!motion) return [];
        const { events } = motion;
        const points = [];
        for (let place = 0; place < events.kind.length; place += 1) {
            if (events.kind[place] === "impact") points.push({ time: events.time[place], rate: -events.before[place], contact: events.place[place] });
        }
        return points;
    }

    fit() {
        const points = this.points();
        const logarithms = points.map(({ rate }) => Math.log10(rate));
        this.plot.whole.x = this.over === "number";
        if (!this.by_hand) {
            const across = this.over === "number" ? [0, Math.max(2, points.length + 1)] : extent(points.map(({ time }) => time)) ?? [0, 1];
            const up = extent(logarithms, 0.08) ?? [-3, 0];
            this.plot.box = { x0: across[0], x1: across[1], y0: up[0], y1: up[1] };
        }
        this.plot.x_label = this.over === "number" ? "number of the impact" : "time";
        this.plot.y_label = "rate before impact";
        this.plot.repaint();
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Plot} plot
     * @param {import("../drawing/palette.js").Theme} colors
     */
    draw(context, plot, colors) {
        const contacts = this.motion?.about.contacts ?? [];
        this.points().forEach(({ time, rate, contact }, place) => {
            const index = Math.max(0, contacts.indexOf(contact)) % COLORS.length;
            // The first is the curves', which is brighter in the dark.
            context.fillStyle = index === 0 ? colors.curve : COLORS[index];
            const x = this.over === "number" ? place + 1 : time;
            if (rate > 0) disc(context, plot.px(x), plot.py(Math.log10(rate)), 2.3);
        });
    }
}
