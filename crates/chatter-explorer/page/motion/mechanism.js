/** The mechanism as the model's [drawing] has it, moving. */

import { choice, field, make } from "../elements/dom.js";
import { nearest } from "./history.js";
import { theme } from "../drawing/palette.js";
import { gifts, panel } from "../elements/panel.js";
import { draw_shapes, reach } from "./shapes.js";
import { Sound } from "./sound.js";
import { shown } from "../drawing/ticks.js";

/** @typedef {import("./motion.js").Motion} Motion */

/** The whole of what is shown lasts so long, in seconds. */
const LASTS = 8;
/** A wall that was hit glows for so long, in seconds. */
const GLOW = 0.12;
const EXAMPLE = `[[drawing.mass]]
at = ["0", "y"]
radius = 0.1

[[drawing.wall]]
from = [-1, -0.1]
to = [1, -0.1]`;

export class MechanismView {
    /**
     * @param {import("../state.js").Store} store
     * @param {import("./motion.js").Motions} motions
     * @param {{ now: number | null, plot: import("../drawing/plot.js").Plot }[]} followers views that show the time, too
     * @param {import("../asking/transport.js").Ask} ask
     * @param {import("../asking/commands.js").Commands} commands
     * @param {(message: string) => void} say
     */
    constructor(store, motions, followers, ask, commands, say) {
        this.store = store;
        this.followers = followers;
        /** @type {Motion | null} */
        this.motion = null;
        this.playing = false;
        this.speed = 1;
        this.now = 0;
        this.hit = -Infinity;
        this.sound = new Sound();
        this.canvas = make("canvas", { role: "img", "aria-label": "The mechanism at the time that the slider shows" });
        this.frame = make("div", { class: "plot" }, this.canvas);
        this.hint = make("div", { class: "hint", hidden: true }, make("p", {}, "The model has no drawing. Add one to its text:"), make("pre", {}, EXAMPLE));
        this.slider = make("input", { type: "range", min: 0, max: 1, step: "any", value: 0, "aria-label": "Time", oninput: () => { this.pause(); this.seek(this.slider.valueAsNumber); } });
        this.button = make("button", { type: "button", class: "play", "aria-label": "Play", onclick: () => (this.playing ? this.pause() : this.play()) }, "▶");
        this.readout = make("output", { class: "readout" });
        const heard = make("input", { type: "checkbox", onchange: () => (heard.checked ? this.sound.on() : this.sound.off()) });
        const speed = choice("Speed", [["0.1", "÷10"], ["0.25", "÷4"], ["0.5", "÷2"], ["1", "×1"], ["2", "×2"], ["4", "×4"]], "1", (value) => (this.speed = Number(value)));
        // An interval has some length.
        const until = () => Math.max(this.now, store.state.from + 1e-9 * (store.state.to - store.state.from));
        this.menu = gifts(ask, {
            name: "mechanism",
            files: () => ({ asked: "history", question: { ...motions.question(), window: `${store.state.from}:${until()}`, axes: ["drawing"] } }),
            command: () => commands.history("mechanism", ["drawing"], { until: until() }),
            python: () => commands.python_history(`run.draw(${this.now})`),
        }, say);
        this.element = panel("mechanism", "Mechanism", [field("sound", heard), field("speed", speed)], make("div", { class: "body" }, this.frame, this.hint, make("div", { class: "foot player" }, this.button, this.slider, this.readout)), this.menu);
        motions.on((motion) => {
            if (!motion) return;
            this.motion = motion;
            const { from, to } = store.state;
            this.slider.min = String(from);
            this.slider.max = String(to);
            this.seek(Math.min(to, Math.max(from, this.now)), false);
        });
        store.on((change) => {
            if (change === "model") this.hint.hidden = Boolean(this.shapes().length);
            this.paint();
        });
        new ResizeObserver(() => this.paint()).observe(this.frame);
    }

    /** @returns {any[]} */
    shapes() {
        return this.store.checked?.drawing?.shapes ?? [];
    }

    play() {
        const { from, to } = this.store.state;
        if (this.now >= this.end()) this.now = from;
        this.playing = true;
        this.button.textContent = "❚❚";
        this.button.setAttribute("aria-label", "Pause");
        let last = performance.now();
        const tick = (/** @type {number} */ moment) => {
            if (!this.playing) return;
            const passed = Math.min(0.1, (moment - last) / 1000);
            last = moment;
            const rate = (this.speed * (to - from)) / LASTS;
            const next = Math.min(this.end(), this.now + passed * rate);
            this.knock(this.now, next, rate);
            this.seek(next);
            if (next >= this.end()) this.pause();
            else requestAnimationFrame(tick);
        };
        requestAnimationFrame(tick);
    }

    pause() {
        this.playing = false;
        this.button.textContent = "▶";
        this.button.setAttribute("aria-label", "Play");
    }

    end() {
        return Math.min(this.store.state.to, this.motion?.about.time ?? this.store.state.to);
    }

    /**
     * Impacts between two times.
     * @param {number} from
     * @param {number} to
     * @param {number} rate
     */
    knock(from, to, rate) {
        const events = this.motion?.events;
        if (!events) return;
        let fastest = 0;
        events.before.forEach((before, place) => {
            if (events.kind[place] === "impact") fastest = Math.max(fastest, -before);
        });
        const impacts = [];
        for (let place = 0; place < events.kind.length; place += 1) {
            const time = events.time[place];
            if (events.kind[place] !== "impact" || time <= from || time > to) continue;
            impacts.push({ delay: (time - from) / rate, strength: -events.before[place] / (fastest || 1) });
            this.hit = performance.now();
        }
        this.sound.play(impacts);
    }

    /**
     * @param {number} time
     * @param {boolean} [tell] the other views, too
     */
    seek(time, tell = true) {
        this.now = time;
        this.slider.value = String(time);
        this.readout.textContent = `time ${shown(time, 5)}`;
        for (const follower of this.followers) {
            if (tell) follower.now = time;
            follower.plot.repaint();
        }
        this.paint();
    }

    paint() {
        const shapes = this.shapes();
        this.frame.hidden = shapes.length === 0;
        this.hint.hidden = shapes.length > 0;
        const { motion, canvas } = this;
        const context = canvas.getContext("2d");
        const { width, height } = this.frame.getBoundingClientRect();
        // While another model is opened, the motion is still that of the one before.
        if (!context || !motion || shapes.length === 0 || motion.drawn.length !== shapes.length || width === 0) return;
        const ratio = window.devicePixelRatio || 1;
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        context.setTransform(ratio, 0, 0, ratio, 0, 0);
        const place = this.place();
        const numbers = (/** @type {number} */ index) => motion.drawn[index].map((values) => values[place]);
        const [x0, x1, y0, y1] = this.bounds();
        const scale = Math.min((width - 24) / (x1 - x0), (height - 24) / (y1 - y0));
        const px = (/** @type {number} */ x) => width / 2 + (x - (x0 + x1) / 2) * scale;
        const py = (/** @type {number} */ y) => height / 2 - (y - (y0 + y1) / 2) * scale;
        const glowing = (performance.now() - this.hit) / 1000 < GLOW;
        draw_shapes(context, theme(), { px, py, scale }, shapes.map((shape, index) => ({ kind: shape.kind, at: numbers(index) })), glowing);
    }

    /** The sample that is shown. */
    place() {
        const time = /** @type {Float64Array} */ (this.motion?.series.get("time"));
        return time.length ? nearest(time, this.now) : 0;
    }

    /** What is seen: everything, over the whole time. @returns {[number, number, number, number]} */
    bounds() {
        const { motion } = this;
        if (!motion) return [0, 1, 0, 1];
        if (motion.bounds) return motion.bounds;
        const reached = reach(this.shapes().map((shape, index) => ({ kind: shape.kind, along: motion.drawn[index] })));
        if (!reached) return [0, 1, 0, 1];
        const [x0, x1, y0, y1] = reached;
        const room = 0.06 * Math.max(x1 - x0, y1 - y0, 1e-9);
        motion.bounds = [x0 - room, x1 + room, y0 - room, y1 + room];
        return motion.bounds;
    }
}
