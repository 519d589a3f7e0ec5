/** A place of the diagram: what is there, in words, and the lines through the one that was picked. */

import { words } from "./classes.js";
import { slope_of } from "./rows.js";
import { shown } from "../drawing/ticks.js";

/**
 * What is at a place; nothing where no column is near.
 * @param {import("./rows.js").Rows} rows
 * @param {import("../state.js").Diagram} diagram
 * @param {string[]} outcomes
 * @param {{ x: number, y: number }} at
 */
export function there(rows, diagram, outcomes, at) {
    if (diagram.second) {
        const cell = rows.plane.at(at.x, at.y);
        const values = [`${diagram.over} = ${shown(at.x)}`, `${diagram.second} = ${shown(at.y)}`];
        return cell ? [...values, ...words(cell.row, outcomes)] : values;
    }
    const column = rows.nearest(at.x);
    if (!column) return [];
    const parts = [`${diagram.over} = ${shown(column.x, 8)}`];
    const [row] = column.rows.filter((row) => row);
    if (row) parts.push(...words(row, outcomes));
    if (Number.isFinite(at.y)) parts.push(`${diagram.observe} = ${shown(at.y + slope_of(diagram) * at.x)}`);
    return parts;
}

/**
 * Lines at the values that were picked.
 * @param {CanvasRenderingContext2D} context
 * @param {import("../drawing/plot.js").Plot} plot
 * @param {string} color
 * @param {[number, number | null]} values across, and upwards on a map
 */
export function draw_picked(context, plot, color, [x, y]) {
    const { left, top, width, height } = plot.area;
    context.strokeStyle = color;
    context.lineWidth = 1.25;
    context.beginPath();
    const across = Math.round(plot.px(x)) + 0.5;
    context.moveTo(across, top);
    context.lineTo(across, top + height);
    if (y !== null) {
        const up = Math.round(plot.py(y)) + 0.5;
        context.moveTo(left, up);
        context.lineTo(left + width, up);
    }
    context.stroke();
}
