/** The axes of a plot: a grid, numbers and labels. */

import { tick_texts, ticks } from "./ticks.js";

/** The left margin is at least so wide. */
export const LEFT = 52;

/**
 * Draws them; the left margin becomes as wide as its numbers need.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./plot.js").Plot} plot
 * @param {import("./palette.js").Theme} colors
 */
export function draw_axes(context, plot, colors) {
    const { x0, x1, y0, y1 } = plot.box;
    const of_axis = (/** @type {number} */ low, /** @type {number} */ high, /** @type {number} */ most, /** @type {boolean} */ logarithmic, /** @type {boolean} */ whole) => {
        let { values, step } = ticks(low, high, most);
        // A single number does not tell how long an axis is.
        if (values.length < 2) ({ values, step } = ticks(low, high, 2 * most));
        if ((logarithmic || whole) && step < 1) ({ values, step } = { values: ticks(Math.floor(low), Math.ceil(high), Math.max(1, Math.ceil(high) - Math.floor(low))).values.filter((value) => Number.isInteger(value) && value >= low && value <= high), step: 1 });
        if (logarithmic) return { values, texts: values.map((value) => (Number.isInteger(value) ? `10${[...String(value)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("")}` : "")), factor: "" };
        return { values, ...tick_texts(values, step) };
    };
    const of_y = of_axis(y0, y1, Math.max(2, plot.area.height / 45), plot.logarithmic.y, plot.whole.y);
    const widest = Math.max(...of_y.texts.map((text) => context.measureText(text).width), 0);
    plot.left = Math.max(LEFT, Math.ceil(widest) + 32);
    const { left, top, width, height } = plot.area;
    const of_x = of_axis(x0, x1, Math.max(2, width / 90), plot.logarithmic.x, plot.whole.x);
    context.strokeStyle = colors.grid;
    context.lineWidth = 1;
    context.beginPath();
    for (const value of of_x.values) {
        const at = Math.round(plot.px(value)) + 0.5;
        context.moveTo(at, top);
        context.lineTo(at, top + height);
    }
    for (const value of of_y.values) {
        const at = Math.round(plot.py(value)) + 0.5;
        context.moveTo(left, at);
        context.lineTo(left + width, at);
    }
    context.stroke();
    context.fillStyle = colors.muted;
    context.textAlign = "center";
    context.textBaseline = "top";
    of_x.values.forEach((value, place) => {
        const half = context.measureText(of_x.texts[place]).width / 2;
        const at = Math.min(plot.px(value), plot.width - half - 1);
        context.fillText(of_x.texts[place], at, top + height + 6);
    });
    context.textAlign = "right";
    context.textBaseline = "middle";
    of_y.values.forEach((value, place) => context.fillText(of_y.texts[place], left - 7, plot.py(value)));
    context.fillStyle = colors.ink;
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    const join = (/** @type {string} */ label, /** @type {string} */ factor) => (factor ? `${label}  (${factor})` : label);
    context.fillText(join(plot.x_label, of_x.factor), left + width / 2, plot.height - 6, width);
    context.save();
    context.translate(13, top + height / 2);
    context.rotate(-Math.PI / 2);
    context.fillText(join(plot.y_label, of_y.factor), 0, 0, height);
    context.restore();
}
