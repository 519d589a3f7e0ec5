/** The mechanism as the model's [drawing] has it, moving. */

import { choice, field, make } from "../elements/dom.js";
import { nearest } from "./history.js";
import { theme } from "../drawing/palette.js";
import { gifts, panel } from "../elements/panel.js";
import { Sound } from "./sound.js";
import { shown } from "../drawing/ticks.js";

/** @typedef {import("./motion.js").Motion} Motion */
/** @typedef {import("../drawing/palette.js").Theme} Theme */

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
            python: () => commands.python_history(`run(${this.now})`),
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
        const colors = theme();
        const glowing = (performance.now() - this.hit) / 1000 < GLOW;
        const ordered = shapes.map((shape, index) => ({ shape, index })).sort((one, other) => LAYERS.indexOf(one.shape.kind) - LAYERS.indexOf(other.shape.kind));
        for (const { shape, index } of ordered) {
            const at = numbers(index);
            if (at.some((value) => !Number.isFinite(value))) continue;
            if (shape.kind === "mass") mass(context, colors, shape, [px(at[0]), py(at[1])], [at[2] * scale, (at[3] ?? 0) * scale], at[4] ?? 0);
            else if (shape.kind === "disc") mass(context, colors, shape, [px(at[0]), py(at[1])], [at[2] * scale], at[3] ?? 0);
            else if (shape.kind === "round_wall") round_wall(context, colors, [px(at[0]), py(at[1])], at[2] * scale, glowing);
            else {
                const ends = /** @type {[number, number, number, number]} */ ([px(at[0]), py(at[1]), px(at[2]), py(at[3])]);
                if (shape.kind === "spring") spring(context, colors, ends);
                else if (shape.kind === "wall") wall(context, colors, ends, glowing);
                else rod(context, colors, ends);
            }
        }
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
        let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
        const reach = (/** @type {Float64Array} */ x, /** @type {Float64Array} */ y, /** @type {Float64Array | null} */ wide, /** @type {Float64Array | null} */ high) => {
            for (let k = 0; k < x.length; k += 1) {
                const [w, h] = [wide ? wide[k] : 0, high ? high[k] : 0];
                if (!Number.isFinite(x[k] + y[k] + w + h)) continue;
                x0 = Math.min(x0, x[k] - w);
                x1 = Math.max(x1, x[k] + w);
                y0 = Math.min(y0, y[k] - h);
                y1 = Math.max(y1, y[k] + h);
            }
        };
        this.shapes().forEach((shape, index) => {
            const values = motion.drawn[index];
            if (shape.kind === "mass") reach(values[0], values[1], values[2].map((w) => w / 2), values[3].map((h) => h / 2));
            else if (shape.kind === "disc" || shape.kind === "round_wall") reach(values[0], values[1], values[2], values[2]);
            else {
                reach(values[0], values[1], null, null);
                reach(values[2], values[3], null, null);
            }
        });
        if (x0 > x1) return [0, 1, 0, 1];
        const room = 0.06 * Math.max(x1 - x0, y1 - y0, 1e-9);
        motion.bounds = [x0 - room, x1 + room, y0 - room, y1 + room];
        return motion.bounds;
    }
}

/** From back to front. */
const LAYERS = ["round_wall", "wall", "spring", "rod", "mass", "disc"];

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {{ kind: string }} shape
 * @param {[number, number]} at
 * @param {number[]} size width and height, or a radius
 * @param {number} angle
 */
function mass(context, colors, shape, at, size, angle) {
    context.save();
    context.translate(...at);
    context.rotate(-angle);
    context.beginPath();
    if (shape.kind === "disc") {
        context.arc(0, 0, Math.max(2, size[0]), 0, 2 * Math.PI);
        context.moveTo(0, 0);
        context.lineTo(Math.max(2, size[0]), 0);
    } else {
        const [wide, high] = size.map((length) => Math.max(3, length));
        context.roundRect(-wide / 2, -high / 2, wide, high, Math.min(4, wide / 4, high / 4));
    }
    context.fillStyle = colors.dark ? "#2c4058" : "#d5e3f0";
    context.strokeStyle = colors.curve;
    context.lineWidth = 1.75;
    context.fill();
    context.stroke();
    context.restore();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {[number, number, number, number]} ends
 */
function spring(context, colors, [x0, y0, x1, y1]) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length === 0) return;
    const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
    const turns = 7;
    const lead = Math.min(10, length * 0.15);
    const wide = Math.min(9, 4 + length * 0.03);
    const at = (/** @type {number} */ along, /** @type {number} */ aside) => /** @type {[number, number]} */ ([x0 + ux * along - uy * aside, y0 + uy * along + ux * aside]);
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(...at(lead, 0));
    for (let k = 0; k < 2 * turns; k += 1) context.lineTo(...at(lead + ((k + 0.5) / (2 * turns)) * (length - 2 * lead), k % 2 ? wide : -wide));
    context.lineTo(...at(length - lead, 0));
    context.lineTo(x1, y1);
    context.strokeStyle = colors.muted;
    context.lineWidth = 1.5;
    context.lineJoin = "round";
    context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {[number, number, number, number]} ends hatched on the right of the way from the first to the second
 * @param {boolean} glowing
 */
function wall(context, colors, [x0, y0, x1, y1], glowing) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length === 0) return;
    const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
    context.beginPath();
    const count = Math.max(2, Math.round(length / 9));
    for (let k = 0; k <= count; k += 1) {
        const [x, y] = [x0 + (ux * length * k) / count, y0 + (uy * length * k) / count];
        context.moveTo(x, y);
        context.lineTo(x - uy * 7 - ux * 5, y + ux * 7 - uy * 5);
    }
    context.strokeStyle = colors.jump;
    context.lineWidth = 1;
    context.stroke();
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.strokeStyle = glowing ? colors.accent : colors.ink;
    context.lineWidth = glowing ? 3 : 2;
    context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {[number, number]} centre
 * @param {number} radius hatched outside
 * @param {boolean} glowing
 */
function round_wall(context, colors, [x, y], radius, glowing) {
    if (!(radius > 0)) return;
    const count = Math.max(12, Math.round((2 * Math.PI * radius) / 9));
    context.beginPath();
    for (let k = 0; k < count; k += 1) {
        const [one, other] = [(2 * Math.PI * k) / count, (2 * Math.PI * (k + 0.5)) / count];
        context.moveTo(x + radius * Math.cos(one), y + radius * Math.sin(one));
        context.lineTo(x + (radius + 7) * Math.cos(other), y + (radius + 7) * Math.sin(other));
    }
    context.strokeStyle = colors.jump;
    context.lineWidth = 1;
    context.stroke();
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.strokeStyle = glowing ? colors.accent : colors.ink;
    context.lineWidth = glowing ? 3 : 2;
    context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {[number, number, number, number]} ends
 */
function rod(context, colors, [x0, y0, x1, y1]) {
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.strokeStyle = colors.ink;
    context.lineWidth = 3;
    context.lineCap = "round";
    context.stroke();
    context.lineCap = "butt";
}
