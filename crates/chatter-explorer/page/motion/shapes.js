/** The shapes of a drawing on a canvas, and how far they reach. */

/** @typedef {import("../drawing/palette.js").Theme} Theme */
/** @typedef {{ px: (x: number) => number, py: (y: number) => number, scale: number }} Frame from units of length to pixels */

/** From back to front. */
const LAYERS = ["round_wall", "wall", "spring", "rod", "mass", "disc"];

/**
 * Draws shapes, those that have a place.
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {Frame} frame
 * @param {{ kind: string, at: number[] }[]} shapes and their numbers
 * @param {boolean} glowing whether walls have just been hit
 */
export function draw_shapes(context, colors, { px, py, scale }, shapes, glowing) {
    const ordered = shapes.toSorted((one, other) => LAYERS.indexOf(one.kind) - LAYERS.indexOf(other.kind));
    for (const { kind, at } of ordered) {
        if (at.some((value) => !Number.isFinite(value))) continue;
        if (kind === "mass") mass(context, colors, kind, [px(at[0]), py(at[1])], [at[2] * scale, (at[3] ?? 0) * scale], at[4] ?? 0);
        else if (kind === "disc") mass(context, colors, kind, [px(at[0]), py(at[1])], [at[2] * scale], at[3] ?? 0);
        else if (kind === "round_wall") round_wall(context, colors, [px(at[0]), py(at[1])], at[2] * scale, glowing);
        else {
            const ends = /** @type {[number, number, number, number]} */ ([px(at[0]), py(at[1]), px(at[2]), py(at[3])]);
            if (kind === "spring") spring(context, colors, ends);
            else if (kind === "wall") wall(context, colors, ends, glowing);
            else rod(context, colors, ends);
        }
    }
}

/**
 * How far shapes reach over the whole time; none where they have no place.
 * @param {{ kind: string, along: Float64Array[] }[]} shapes and their numbers over time
 * @returns {[number, number, number, number] | null}
 */
export function reach(shapes) {
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    const take = (/** @type {Float64Array} */ x, /** @type {Float64Array} */ y, /** @type {Float64Array | null} */ wide, /** @type {Float64Array | null} */ high) => {
        for (let k = 0; k < x.length; k += 1) {
            const [w, h] = [wide ? wide[k] : 0, high ? high[k] : 0];
            if (!Number.isFinite(x[k] + y[k] + w + h)) continue;
            x0 = Math.min(x0, x[k] - w);
            x1 = Math.max(x1, x[k] + w);
            y0 = Math.min(y0, y[k] - h);
            y1 = Math.max(y1, y[k] + h);
        }
    };
    for (const { kind, along } of shapes) {
        if (kind === "mass") take(along[0], along[1], along[2].map((w) => w / 2), along[3].map((h) => h / 2));
        else if (kind === "disc" || kind === "round_wall") take(along[0], along[1], along[2], along[2]);
        else {
            take(along[0], along[1], null, null);
            take(along[2], along[3], null, null);
        }
    }
    return x0 > x1 ? null : [x0, x1, y0, y1];
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Theme} colors
 * @param {string} kind
 * @param {[number, number]} at
 * @param {number[]} size width and height, or a radius
 * @param {number} angle
 */
function mass(context, colors, kind, at, size, angle) {
    context.save();
    context.translate(...at);
    context.rotate(-angle);
    context.beginPath();
    if (kind === "disc") {
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
