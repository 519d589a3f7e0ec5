/** Densities of samples as pictures: a cell for each pixel, shaded by how many samples are in it. */

/** @typedef {{ x: number, key: number, level: number, rows: (Row | undefined)[] }} Column */
/** @typedef {{ outcome: number, period: number, impacts: number, exponent: number, attractor: number, samples: Float64Array }} Row */
/** @typedef {{ colors: [number, number, number][], of: (row: Row, pass: number) => number }} Layers the colours of layers, and which of
 *   them a row is on */
/** @typedef {import("./plot.js").Box} Box */

/** Samples are at least so opaque that a single one is seen. */
const FAINTEST = 0.42;
/** Times the mean density, at which a cell is nearly opaque. */
const DENSE = 5;

/** Opacities by density, in steps of this part of one at which a cell is nearly opaque. */
const SHADES = 64;
const OPACITY = Uint8Array.from({ length: 8 * SHADES }, (_, k) => Math.round(255 * (FAINTEST + (1 - FAINTEST) * (1 - Math.exp(-k / SHADES)))));

export class Raster {
    constructor() {
        this.canvas = document.createElement("canvas");
        /** @type {Box} */
        this.box = { x0: 0, x1: 1, y0: 0, y1: 1 };
        /** How long the latest took, in milliseconds. */
        this.took = 0;
        this.points = 0;
    }

    /**
     * Counts and shades. Columns are in the order of their values; each reaches halfway to its neighbours.
     * @param {Column[]} columns
     * @param {Box} box
     * @param {number} width in pixels
     * @param {number} height
     * @param {number} dot height of a sample in pixels
     * @param {Layers} layers
     * @param {number} step distance of columns, where they have no neighbours
     * @param {number} slope of the line that is drawn level
     */
    draw(columns, box, width, height, dot, layers, step, slope) {
        const { colors } = layers;
        const began = performance.now();
        const { canvas } = this;
        if (canvas.width !== width || canvas.height !== height) {
            canvas.width = width;
            canvas.height = height;
        }
        const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
        const image = context.createImageData(width, height);
        const words = new Uint32Array(image.data.buffer);
        const scale = width / (box.x1 - box.x0);
        const up = height / (box.y1 - box.y0);
        this.points = 0;
        const sums = colors.map(() => new Float32Array(height));
        let filled = -1;
        let weight = colors.map(() => 0);
        const flush = (/** @type {number} */ from, /** @type {number} */ to) => {
            sums.forEach((sum, layer) => {
                if (weight[layer] === 0) return;
                const [r, g, b] = colors[layer];
                const unit = height / (weight[layer] * DENSE * dot);
                for (let y = 0; y < height; y += 1) {
                    if (sum[y] === 0) continue;
                    const alpha = OPACITY[Math.min(OPACITY.length - 1, (sum[y] * unit * SHADES) | 0)];
                    const word = ((alpha << 24) | (b << 16) | (g << 8) | r) >>> 0;
                    for (let x = from; x < to; x += 1) {
                        const at = y * width + x;
                        // Of two layers the later one lies on top, half seen through where both are.
                        words[at] = words[at] === 0 ? word : mixed(words[at], word);
                    }
                    sum[y] = 0;
                }
                weight[layer] = 0;
            });
        };
        for (let place = 0; place < columns.length; place += 1) {
            const { x, rows } = columns[place];
            const before = place > 0 ? columns[place - 1].x : x - step;
            const after = place + 1 < columns.length ? columns[place + 1].x : x + step;
            const left = Math.max(x - step, (before + x) / 2);
            const right = Math.min(x + step, (after + x) / 2);
            const from = Math.max(0, Math.round((left - box.x0) * scale));
            let to = Math.min(width, Math.round((right - box.x0) * scale));
            if (from >= width || to < 0) continue;
            to = Math.max(to, from + 1);
            if (from !== filled) {
                if (filled >= 0) flush(filled, Math.min(from, filled + 1));
                filled = from;
            }
            rows.forEach((row, pass) => {
                if (!row) return;
                const layer = layers.of(row, pass);
                const sum = sums[layer];
                const { samples } = row;
                const top = box.y1 + slope * x;
                weight[layer] += samples.length;
                this.points += samples.length;
                for (let k = 0; k < samples.length; k += 1) {
                    const y = Math.floor((top - samples[k]) * up);
                    for (let d = 0; d < dot; d += 1) {
                        const at = y + d;
                        if (at >= 0 && at < height) sum[at] += 1;
                    }
                }
            });
            if (to > from + 1) {
                flush(from, to);
                filled = -1;
            }
        }
        if (filled >= 0) flush(filled, Math.min(width, filled + 1));
        context.putImageData(image, 0, 0);
        this.box = box;
        this.took = performance.now() - began;
    }

    /**
     * The picture where it belongs, whatever is looked at by now.
     * @param {CanvasRenderingContext2D} context
     * @param {import("./plot.js").Plot} plot
     */
    show(context, plot) {
        const { x0, x1, y0, y1 } = this.box;
        const [left, right, top, bottom] = [plot.px(x0), plot.px(x1), plot.py(y1), plot.py(y0)];
        const same = Math.abs(right - left - plot.area.width) < 0.01 && Math.abs(bottom - top - plot.area.height) < 0.01;
        context.imageSmoothingEnabled = !same;
        context.drawImage(this.canvas, left, top, right - left, bottom - top);
    }
}

/**
 * @param {number} under
 * @param {number} over
 */
function mixed(under, over) {
    const part = (/** @type {number} */ shift) => (((under >>> shift) & 255) * 0.35 + ((over >>> shift) & 255) * 0.65) << shift;
    const alpha = Math.max(under >>> 24, over >>> 24);
    return ((alpha << 24) | (part(16) & 0xff0000) | (part(8) & 0xff00) | (part(0) & 0xff)) >>> 0;
}
