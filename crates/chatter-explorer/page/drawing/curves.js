/** Draws motions: curves that are broken where an impact makes the state jump. */

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("./plot.js").Plot} plot
 * @param {import("./palette.js").Theme} colors
 * @param {Float64Array} x
 * @param {Float64Array} y
 * @param {number[]} jumps
 */
export function curve(context, plot, colors, x, y, jumps) {
    const at = new Set(jumps);
    context.lineJoin = "round";
    context.beginPath();
    for (const k of jumps) {
        context.moveTo(plot.px(x[k - 1]), plot.py(y[k - 1]));
        context.lineTo(plot.px(x[k]), plot.py(y[k]));
    }
    context.strokeStyle = colors.jump;
    context.lineWidth = 0.75;
    context.stroke();
    context.beginPath();
    let down = false;
    let [last_x, last_y] = [NaN, NaN];
    for (let k = 0; k < x.length; k += 1) {
        const [px, py] = [plot.px(x[k]), plot.py(y[k])];
        if (!down || at.has(k)) context.moveTo(px, py);
        // What is nearer than a third of a pixel is not seen.
        else if (Math.abs(px - last_x) + Math.abs(py - last_y) < 0.35 && k + 1 < x.length && !at.has(k + 1)) continue;
        else context.lineTo(px, py);
        down = true;
        [last_x, last_y] = [px, py];
    }
    context.strokeStyle = colors.curve;
    context.lineWidth = 1.6;
    context.stroke();
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} px
 * @param {number} py
 * @param {number} radius
 */
export function disc(context, px, py, radius) {
    context.beginPath();
    context.arc(px, py, radius, 0, 2 * Math.PI);
    context.fill();
}
