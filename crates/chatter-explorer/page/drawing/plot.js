/** A plot: axes, and looking around in it by mouse, touch and keys. What is drawn in it is its owner's. */

import { make } from "../elements/dom.js";
import { theme } from "./palette.js";
import { tick_texts, ticks } from "./ticks.js";

/** @typedef {{ x0: number, x1: number, y0: number, y1: number }} Box */
/** @typedef {import("./palette.js").Theme} Theme */

const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
/** The left margin is at least so wide, and as wide as its numbers need. */
const LEFT = 52;
const BOTTOM = 40;
const TOP = 10;
const RIGHT = 14;

/** So many clicks of the wheel halve a box. */
const WHEEL = 0.0018;

export class Plot {
    /**
     * @param {object} of
     * @param {string} of.label what it shows, for those who cannot see it
     * @param {(context: CanvasRenderingContext2D, plot: Plot, theme: Theme) => void} of.draw
     * @param {(box: Box, done: boolean) => void} [of.moved] the box was changed by hand
     * @param {() => void} [of.reset] everything is to be seen again
     * @param {(x: number, y: number) => void} [of.pick]
     * @param {(at: { x: number, y: number } | null) => void} [of.hover]
     * @param {(direction: number) => void} [of.step] a key moves what is picked
     * @param {(px: number, py: number, first: boolean) => boolean} [of.grab] something is dragged, rather than the view
     */
    constructor(of) {
        this.of = of;
        /** @type {Box} */
        this.box = { x0: 0, x1: 1, y0: 0, y1: 1 };
        this.x_label = "";
        this.y_label = "";
        /** Where axes have decades: values are their logarithms. */
        this.logarithmic = { x: false, y: false };
        this.whole = { x: false, y: false };
        this.equal = false;
        this.canvas = make("canvas", { tabindex: 0, role: "img", "aria-label": of.label });
        this.element = make("div", { class: "plot" }, this.canvas);
        this.width = 0;
        this.height = 0;
        this.left = LEFT;
        this.scheduled = false;
        /** @type {{ x: number, y: number } | null} */
        this.at = null;
        /** @type {[number, number, number, number] | null} a box that is being dragged, in pixels */
        this.band = null;
        // For whoever looks at the page from outside, as tests do.
        Object.assign(this.canvas, { plot: this });
        this.listen();
        new ResizeObserver(() => this.resize()).observe(this.element);
    }

    get area() {
        const { left } = this;
        return { left, top: TOP, width: Math.max(1, this.width - left - RIGHT), height: Math.max(1, this.height - TOP - BOTTOM) };
    }

    resize() {
        const { width, height } = this.element.getBoundingClientRect();
        if (width === 0 || height === 0) return;
        this.width = width;
        this.height = height;
        this.ratio = window.devicePixelRatio || 1;
        this.canvas.width = Math.round(width * this.ratio);
        this.canvas.height = Math.round(height * this.ratio);
        this.paint();
    }

    /** @param {number} x */
    px(x) {
        const { left, width } = this.area;
        return left + ((x - this.box.x0) / (this.box.x1 - this.box.x0)) * width;
    }

    /** @param {number} y */
    py(y) {
        const { top, height } = this.area;
        return top + height - ((y - this.box.y0) / (this.box.y1 - this.box.y0)) * height;
    }

    /** @param {number} px */
    x(px) {
        const { left, width } = this.area;
        return this.box.x0 + ((px - left) / width) * (this.box.x1 - this.box.x0);
    }

    /** @param {number} py */
    y(py) {
        const { top, height } = this.area;
        return this.box.y0 + ((top + height - py) / height) * (this.box.y1 - this.box.y0);
    }

    /** Draws it at the next frame. */
    repaint() {
        if (this.scheduled) return;
        this.scheduled = true;
        requestAnimationFrame(() => {
            this.scheduled = false;
            this.paint();
        });
    }

    paint() {
        const context = this.canvas.getContext("2d");
        if (!context || this.width === 0) return;
        const colors = theme();
        context.setTransform(this.ratio ?? 1, 0, 0, this.ratio ?? 1, 0, 0);
        context.clearRect(0, 0, this.width, this.height);
        context.font = FONT;
        this.axes(context, colors);
        const { left, top, width, height } = this.area;
        context.save();
        context.beginPath();
        context.rect(left, top, width, height);
        context.clip();
        this.of.draw(context, this, colors);
        context.restore();
        context.strokeStyle = colors.muted;
        context.lineWidth = 1;
        context.strokeRect(Math.round(left) - 0.5, Math.round(top) - 0.5, Math.round(width) + 1, Math.round(height) + 1);
        if (this.band) {
            const [x0, y0, x1, y1] = this.band;
            context.fillStyle = "rgba(0,114,178,0.14)";
            context.fillRect(x0, y0, x1 - x0, y1 - y0);
            context.strokeStyle = colors.curve;
            context.strokeRect(x0, y0, x1 - x0, y1 - y0);
        }
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {Theme} colors
     */
    axes(context, colors) {
        const { x0, x1, y0, y1 } = this.box;
        const of_axis = (/** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ most, /** @type {boolean} */ logarithmic, /** @type {boolean} */ whole) => {
            let { values, step } = ticks(low, high, most);
            // A single number does not tell how long an axis is.
            if (values.length < 2) ({ values, step } = ticks(low, high, 2 * most));
            if ((logarithmic || whole) && step < 1) ({ values, step } = { values: ticks(Math.floor(low), Math.ceil(high), Math.max(1, Math.ceil(high) - Math.floor(low))).values.filter((value) => Number.isInteger(value) && value >= low && value <= high), step: 1 });
            if (logarithmic) return { values, texts: values.map((value) => (Number.isInteger(value) ? `10${[...String(value)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("")}` : "")), factor: "" };
            return { values, ...tick_texts(values, step) };
        };
        const of_y = of_axis(y0, y1, Math.max(2, this.area.height / 45), this.logarithmic.y, this.whole.y);
        const widest = Math.max(...of_y.texts.map((text) => context.measureText(text).width), 0);
        this.left = Math.max(LEFT, Math.ceil(widest) + 32);
        const { left, top, width, height } = this.area;
        const of_x = of_axis(x0, x1, Math.max(2, width / 90), this.logarithmic.x, this.whole.x);
        context.strokeStyle = colors.grid;
        context.lineWidth = 1;
        context.beginPath();
        for (const value of of_x.values) {
            const at = Math.round(this.px(value)) + 0.5;
            context.moveTo(at, top);
            context.lineTo(at, top + height);
        }
        for (const value of of_y.values) {
            const at = Math.round(this.py(value)) + 0.5;
            context.moveTo(left, at);
            context.lineTo(left + width, at);
        }
        context.stroke();
        context.fillStyle = colors.muted;
        context.textAlign = "center";
        context.textBaseline = "top";
        of_x.values.forEach((value, place) => {
            const half = context.measureText(of_x.texts[place]).width / 2;
            const at = Math.min(this.px(value), this.width - half - 1);
            context.fillText(of_x.texts[place], at, top + height + 6);
        });
        context.textAlign = "right";
        context.textBaseline = "middle";
        of_y.values.forEach((value, place) => context.fillText(of_y.texts[place], left - 7, this.py(value)));
        context.fillStyle = colors.ink;
        context.textAlign = "center";
        context.textBaseline = "alphabetic";
        const join = (/** @type {string} */ label, /** @type {string} */ factor) => (factor ? `${label}  (${factor})` : label);
        context.fillText(join(this.x_label, of_x.factor), left + width / 2, this.height - 6, width);
        context.save();
        context.translate(13, top + height / 2);
        context.rotate(-Math.PI / 2);
        context.fillText(join(this.y_label, of_y.factor), 0, 0, height);
        context.restore();
    }

    /**
     * @param {Box} box
     * @param {boolean} done
     */
    move(box, done) {
        const room = (/** @type {number} */ low, /** @type {number} */ high) => high - low > 1e-13 * Math.max(Math.abs(low), Math.abs(high)) && Number.isFinite(high - low);
        if (!room(box.x0, box.x1) || !room(box.y0, box.y1)) return;
        this.box = box;
        this.of.moved?.(box, done);
        this.repaint();
    }

    /**
     * @param {number} factor of the width of the box
     * @param {number} px
     * @param {number} py
     * @param {{ x: boolean, y: boolean }} axes
     * @param {boolean} done
     */
    zoom(factor, px, py, axes, done) {
        const { x0, x1, y0, y1 } = this.box;
        const [x, y] = [this.x(px), this.y(py)];
        const to = (/** @type {number} */ value, /** @type {number} */ centre, /** @type {boolean} */ along) => (along ? centre + (value - centre) * factor : value);
        this.move({ x0: to(x0, x, axes.x), x1: to(x1, x, axes.x), y0: to(y0, y, axes.y), y1: to(y1, y, axes.y) }, done);
    }

    /**
     * On an axis only that one is changed.
     * @param {number} px
     * @param {number} py
     */
    axes_at(px, py) {
        const { left, top, height } = this.area;
        return { x: px >= left, y: py <= top + height };
    }

    listen() {
        const { canvas } = this;
        /** @type {Map<number, { x: number, y: number }>} */
        const fingers = new Map();
        /** @type {{ x: number, y: number, box: Box, zooming: boolean, axes: { x: boolean, y: boolean } } | null} */
        let drag = null;
        let travelled = 0;
        let grabbed = false;
        let wheel_timer = 0;
        const place = (/** @type {MouseEvent} */ event) => {
            const { left, top } = canvas.getBoundingClientRect();
            return { x: event.clientX - left, y: event.clientY - top };
        };
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            const { x, y } = place(event);
            const delta = event.deltaMode === 1 ? event.deltaY * 33 : event.deltaY;
            this.zoom(Math.exp(delta * WHEEL), x, y, this.axes_at(x, y), false);
            window.clearTimeout(wheel_timer);
            wheel_timer = window.setTimeout(() => this.of.moved?.(this.box, true), 250);
        }, { passive: false });
        canvas.addEventListener("pointerdown", (event) => {
            canvas.setPointerCapture(event.pointerId);
            fingers.set(event.pointerId, place(event));
            const at = place(event);
            drag = { ...at, box: this.box, zooming: event.shiftKey, axes: this.axes_at(at.x, at.y) };
            travelled = 0;
            grabbed = !event.shiftKey && fingers.size === 1 && (this.of.grab?.(at.x, at.y, true) ?? false);
        });
        canvas.addEventListener("pointermove", (event) => {
            const at = place(event);
            const before = fingers.get(event.pointerId);
            if (before && drag) {
                travelled += Math.hypot(at.x - before.x, at.y - before.y);
                if (grabbed) {
                    this.of.grab?.(at.x, at.y, false);
                } else if (fingers.size === 2) {
                    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, finger]) => finger);
                    const [other] = others;
                    const gap = (/** @type {{ x: number, y: number }} */ finger) => Math.max(10, Math.hypot(finger.x - other.x, finger.y - other.y));
                    this.zoom(gap(before) / gap(at), (at.x + other.x) / 2, (at.y + other.y) / 2, { x: true, y: true }, false);
                } else if (drag.zooming) {
                    this.band = [drag.x, drag.y, at.x, at.y];
                    this.repaint();
                } else if (travelled > 4) {
                    const { box, axes } = drag;
                    const { width, height } = this.area;
                    const dx = axes.x ? ((drag.x - at.x) / width) * (box.x1 - box.x0) : 0;
                    const dy = axes.y ? ((at.y - drag.y) / height) * (box.y1 - box.y0) : 0;
                    this.move({ x0: box.x0 + dx, x1: box.x1 + dx, y0: box.y0 + dy, y1: box.y1 + dy }, false);
                }
                fingers.set(event.pointerId, at);
            }
            this.at = at;
            this.of.hover?.({ x: this.x(at.x), y: this.y(at.y) });
        });
        const up = (/** @type {PointerEvent} */ event) => {
            fingers.delete(event.pointerId);
            if (!drag) return;
            const at = place(event);
            const { zooming } = drag;
            drag = fingers.size > 0 ? drag : null;
            if (grabbed) {
                grabbed = false;
            } else if (zooming && this.band) {
                const [x0, y0, x1, y1] = this.band;
                this.band = null;
                const wide = Math.abs(x1 - x0) > 5 && Math.abs(y1 - y0) > 5;
                const box = { x0: this.x(Math.min(x0, x1)), x1: this.x(Math.max(x0, x1)), y0: this.y(Math.max(y0, y1)), y1: this.y(Math.min(y0, y1)) };
                if (wide) this.move(box, true);
                else this.repaint();
            } else if (travelled <= 4) {
                this.of.pick?.(this.x(at.x), this.y(at.y));
            } else {
                this.of.moved?.(this.box, true);
            }
        };
        canvas.addEventListener("pointerup", up);
        canvas.addEventListener("pointercancel", up);
        canvas.addEventListener("pointerleave", () => {
            this.at = null;
            this.of.hover?.(null);
        });
        canvas.addEventListener("dblclick", () => this.of.reset?.());
        canvas.addEventListener("keydown", (event) => this.key(event));
    }

    /** @param {KeyboardEvent} event */
    key(event) {
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const { left, top, width, height } = this.area;
        const { x0, x1, y0, y1 } = this.box;
        const [dx, dy] = [(x1 - x0) / 8, (y1 - y0) / 8];
        const shift = (/** @type {number} */ x, /** @type {number} */ y) => this.move({ x0: x0 + x, x1: x1 + x, y0: y0 + y, y1: y1 + y }, true);
        const middle = /** @type {[number, number]} */ ([left + width / 2, top + height / 2]);
        const both = { x: true, y: true };
        /** @type {Record<string, () => void>} */
        const keys = {
            ArrowLeft: () => (event.shiftKey || !this.of.step ? shift(-dx, 0) : this.of.step(-1)),
            ArrowRight: () => (event.shiftKey || !this.of.step ? shift(dx, 0) : this.of.step(1)),
            ArrowUp: () => shift(0, dy),
            ArrowDown: () => shift(0, -dy),
            "+": () => this.zoom(0.5, ...middle, both, true),
            "=": () => this.zoom(0.5, ...middle, both, true),
            "-": () => this.zoom(2, ...middle, both, true),
            "0": () => this.of.reset?.(),
            Home: () => this.of.reset?.(),
        };
        const act = keys[event.key];
        if (!act) return;
        event.preventDefault();
        act();
    }
}

/**
 * A box with a margin around values; none where there are none.
 * @param {ArrayLike<number>} values
 * @param {number} [margin]
 * @returns {[number, number] | null}
 */
export function extent(values, margin = 0.05) {
    let [low, high] = [Infinity, -Infinity];
    for (let place = 0; place < values.length; place += 1) {
        const value = values[place];
        if (value < low && Number.isFinite(value)) low = value;
        if (value > high && Number.isFinite(value)) high = value;
    }
    if (low > high) return null;
    if (margin === 0) return [low, high];
    const room = high > low ? (high - low) * margin : Math.max(Math.abs(high) * 0.1, 1e-9);
    return [low - room, high + room];
}
