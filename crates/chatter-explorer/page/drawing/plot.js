/** A plot: axes, and looking around in it by mouse, touch and keys. What is drawn in it is its owner's. */

import { make } from "../elements/dom.js";
import { LEFT, draw_axes } from "./axes.js";
import { listen } from "./input.js";
import { theme } from "./palette.js";

/** @typedef {{ x0: number, x1: number, y0: number, y1: number }} Box */
/** @typedef {import("./palette.js").Theme} Theme */

const FONT = '12px system-ui, -apple-system, "Segoe UI", Roboto, sans-serif';
const BOTTOM = 40;
const TOP = 10;
const RIGHT = 14;

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
        listen(this);
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
        draw_axes(context, this, colors);
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
