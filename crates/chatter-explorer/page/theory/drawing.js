/** Draws what theory says over a diagram: branches, curves of special points, border orbits and their windows. */

import { GREEN, ORANGE } from "../drawing/palette.js";
import { special } from "./special.js";

/** @typedef {import("../drawing/plot.js").Plot} Plot */
/** @typedef {import("../drawing/palette.js").Theme} Theme */
/** @typedef {import("../state.js").Diagram} Diagram */

/**
 * Branches over one parameter, stable orbits solid, neutral ones dotted, with their special points.
 * @param {CanvasRenderingContext2D} context
 * @param {Plot} plot
 * @param {Theme} colors
 * @param {any} document
 * @param {Diagram} diagram
 */
export function draw_branches(context, plot, colors, document, diagram) {
    const { slope } = diagram;
    for (const branch of document.branches) {
        const x = branch.points[diagram.over];
        const y = branch.points[diagram.observe];
        if (!x || !y) continue;
        const { stable, neutral } = branch.points;
        for (const [is_stable, is_neutral, dash] of /** @type {[boolean, boolean, number[]][]} */ ([[true, false, []], [false, true, [1, 2]], [false, false, [4, 3]]])) {
            context.beginPath();
            for (let k = 1; k < x.length; k += 1) {
                if (stable[k - 1] !== is_stable || neutral[k - 1] !== is_neutral) continue;
                context.moveTo(plot.px(x[k - 1]), plot.py(y[k - 1] - slope * x[k - 1]));
                context.lineTo(plot.px(x[k]), plot.py(y[k] - slope * x[k]));
            }
            context.strokeStyle = is_stable ? colors.curve : colors.muted;
            context.lineWidth = is_stable ? 2 : 1;
            context.setLineDash(dash);
            context.stroke();
        }
        context.setLineDash([]);
        for (const point of branch.special) mark(context, plot, colors, point.kind, point.value, point.state[diagram.observe] - slope * point.value);
    }
}

/**
 * Special points of branches at their place in a map over two parameters.
 * @param {CanvasRenderingContext2D} context
 * @param {Plot} plot
 * @param {Theme} colors
 * @param {any} document
 * @param {number} height the value of the second parameter
 */
export function draw_special_points(context, plot, colors, document, height) {
    for (const branch of document.branches) {
        for (const point of branch.special) mark(context, plot, colors, point.kind, point.value, height);
    }
}

/**
 * Curves of special points over a map, and the points of codimension two on them.
 * @param {CanvasRenderingContext2D} context
 * @param {Plot} plot
 * @param {Theme} colors
 * @param {any[]} curves
 * @param {Diagram} diagram
 */
export function draw_curves(context, plot, colors, curves, diagram) {
    for (const { kind, points, special: found } of curves) {
        const [x, y] = [points[diagram.over], points[diagram.second]];
        if (!x || !y) continue;
        // A light edge, so that they are seen on any cell.
        for (const [color, width] of /** @type {[string, number][]} */ ([[colors.surface, 4.5], [special(kind)[1], 2.5]])) {
            context.beginPath();
            for (let k = 0; k < x.length; k += 1) context.lineTo(plot.px(x[k]), plot.py(y[k]));
            context.strokeStyle = color;
            context.lineWidth = width;
            context.lineJoin = "round";
            context.stroke();
        }
        for (const point of found) mark(context, plot, colors, point.kind, point.at[diagram.over], point.at[diagram.second]);
    }
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Plot} plot
 * @param {Theme} colors
 * @param {string} kind
 * @param {number} x
 * @param {number} y
 */
function mark(context, plot, colors, kind, x, y) {
    context.beginPath();
    context.arc(plot.px(x), plot.py(y), 4, 0, 2 * Math.PI);
    context.fillStyle = special(kind)[1];
    context.fill();
    context.strokeStyle = colors.surface;
    context.lineWidth = 1.5;
    context.stroke();
}

/**
 * The ends of a predicted window, as far as there are any.
 * @param {any} window
 * @returns {number[]}
 */
const ends_of = (window) => [window.fold, window.period_doubling, window.grazing].filter((end) => typeof end === "number");

/**
 * Border orbits as upright lines, and beside them the windows that the one-dimensional map predicts.
 * @param {CanvasRenderingContext2D} context
 * @param {Plot} plot
 * @param {Theme} colors
 * @param {any} document
 */
export function draw_borders(context, plot, colors, document) {
    const { top, height } = plot.area;
    const upright = (/** @type {number} */ value, /** @type {string} */ color, /** @type {number[]} */ dash, /** @type {number} */ width) => {
        const at = Math.round(plot.px(value)) + 0.5;
        context.beginPath();
        context.moveTo(at, top);
        context.lineTo(at, top + height);
        context.strokeStyle = color;
        context.lineWidth = width;
        context.setLineDash(dash);
        context.stroke();
        context.setLineDash([]);
    };
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "center";
    context.textBaseline = "top";
    for (const border of document.borders) {
        for (const window of border.windows ?? []) {
            // Where the orbit is born and doubles; its graze lies within later windows.
            const dashes = [[], [5, 3], [2, 3]];
            [window.fold, window.period_doubling, window.grazing].forEach((end, place) => typeof end === "number" && upright(end, GREEN, dashes[place], 1));
            const [first] = ends_of(window);
            if (first === undefined) continue;
            context.fillStyle = colors.surface;
            context.fillRect(plot.px(first) - 17, top + 3, 34, 15);
            context.fillStyle = colors.ink;
            context.fillText(`n = ${window.n}`, plot.px(first), top + 5);
        }
        upright(border.value, ORANGE, [], 2);
    }
}
