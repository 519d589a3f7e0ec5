/** The rows of a diagram that are there: columns over one parameter, cells over two; and which are missing of what is seen. */

import { Lattice } from "./lattice.js";
import { Plane } from "./plane.js";
import { extent } from "../drawing/plot.js";

/** @typedef {import("../drawing/raster.js").Column} Column */
/** @typedef {import("../drawing/raster.js").Row} Row */
/** @typedef {import("../state.js").Diagram} Diagram */
/** @typedef {{ attractor: number, label: string, rows: number, share: number }} Attractor */

/** Numbers of a row before its samples. */
const HEAD = 8;
/** Columns of the first picture: so few that it is there at once. */
export const COARSE = 16;
/** Cells across a map's first picture, and of its last for so many columns. */
const COARSE_MAP = 16;
export const fine_map = (/** @type {number} */ columns) => Math.max(COARSE_MAP, Math.min(512, columns / 4));

/** @param {Diagram} diagram */
export const slope_of = (diagram) => (diagram.second ? 0 : diagram.slope);

/**
 * Whether what an orbit settles to depends on the sweep that it is part of: a carried one goes on from its neighbour, and
 * attractors keep their numbers from column to column.
 * @param {Diagram} diagram
 */
export const hangs_together = (diagram) => diagram.start.startsWith("carry") || (diagram.start.startsWith("random") && !diagram.second);

export class Rows {
    constructor() {
        /** @type {Map<number, Column>} */
        this.columns = new Map();
        /** @type {Column[] | null} in the order of their values; none where that is to be found again */
        this.sorted = null;
        this.lattice = new Lattice(0, 1);
        this.plane = new Plane();
        /** @type {Attractor[]} those that coexist; none where there is but one */
        this.attractors = [];
    }

    /** @param {Diagram} diagram */
    clear(diagram) {
        this.columns = new Map();
        this.sorted = null;
        this.attractors = [];
        this.plane.clear(diagram);
        this.lattice = new Lattice(diagram.from, diagram.to - diagram.from);
    }

    /** How many columns, or rows of a map, a file has. @param {Diagram} diagram */
    size(diagram) {
        return diagram.second ? fine_map(diagram.columns) : diagram.columns;
    }

    /** The sweeps that are missing, the coarse ones first. @param {Diagram} diagram */
    plan(diagram) {
        const { lattice } = this;
        if (diagram.second) return this.plane.plan(diagram, COARSE_MAP, this.size(diagram));
        /** @type {{ sweep: string[], run: import("./lattice.js").Run & { rows?: number } }[]} */
        const plan = [];
        const anew = hangs_together(diagram);
        const coarse = lattice.level(diagram.from, diagram.to, Math.min(COARSE, diagram.columns));
        const fine = lattice.level(diagram.from, diagram.to, diagram.columns);
        const known = new Set(anew ? [] : this.columns.keys());
        for (let level = coarse; level <= fine; level += 1) {
            const runs = lattice.missing(level, diagram.from, diagram.to, (key) => !anew && known.has(key));
            for (const run of runs) {
                for (let k = 0; k < run.count; k += 1) known.add(lattice.key(level, run.first + k * run.stride));
                const last = run.first + (run.count - 1) * run.stride;
                plan.push({ sweep: [`${diagram.over}=${lattice.value(run.level, run.first)}:${lattice.value(run.level, last)}:${run.count}`], run });
            }
        }
        return plan;
    }

    /**
     * The key of the column at a value.
     * @param {import("./lattice.js").Run} run
     * @param {number} x
     */
    key(run, x) {
        const last = run.first + (run.count - 1) * run.stride;
        const [low, high] = [this.lattice.value(run.level, run.first), this.lattice.value(run.level, last)];
        const index = run.count > 1 ? Math.round(((x - low) / (high - low)) * (run.count - 1)) : 0;
        return this.lattice.key(run.level, run.first + index * run.stride);
    }

    /**
     * @param {Float64Array} numbers of a row
     * @param {{ run: any }[]} plan
     * @param {Diagram} diagram
     */
    take(numbers, plan, diagram) {
        const [number, pass, x, y, outcome, period, impacts, exponent] = numbers;
        const { run } = plan[number];
        const row = { outcome, period, impacts, exponent, attractor: 0, samples: numbers.subarray(HEAD) };
        if (diagram.second) {
            this.plane.take(run, x, y, row);
            return;
        }
        const key = this.key(run, x);
        let column = this.columns.get(key);
        if (!column) {
            column = { x, key, level: run.level, rows: [] };
            this.columns.set(key, column);
            this.sorted = null;
        }
        column.rows[pass] = row;
    }

    /**
     * The numbers of attractors, five for each row: the sweep, the pass, the values, the number.
     * @param {Float64Array} numbers
     * @param {{ run: any }[]} plan
     * @param {Diagram} diagram
     */
    tell_apart(numbers, plan, diagram) {
        if (diagram.second) return;
        for (let at = 0; at < numbers.length; at += 5) {
            const [number, pass, x, , attractor] = numbers.subarray(at, at + 5);
            const row = this.columns.get(this.key(plan[number].run, x))?.rows[pass];
            if (row) row.attractor = attractor;
        }
    }

    /** @returns {Column[]} */
    in_order() {
        this.sorted ??= [...this.columns.values()].sort((one, other) => one.x - other.x);
        return this.sorted;
    }

    /** How many columns, or cells of a map, are seen. @param {Diagram} diagram */
    visible(diagram) {
        if (diagram.second) return this.plane.cells.size;
        return this.in_order().filter(({ x }) => x >= diagram.from && x <= diagram.to).length;
    }

    /** The range of the samples that are seen. @param {Diagram} diagram */
    seen(diagram) {
        const slope = slope_of(diagram);
        let [low, high] = [Infinity, -Infinity];
        for (const { x, rows } of this.in_order()) {
            if (x < diagram.from || x > diagram.to) continue;
            for (const row of rows) {
                if (!row || row.samples.length === 0) continue;
                const ends = extent(row.samples, 0);
                if (!ends) continue;
                low = Math.min(low, ends[0] - slope * x);
                high = Math.max(high, ends[1] - slope * x);
            }
        }
        return low > high ? null : extent([low, high]);
    }

    /** The slope of the line that fits what is seen best. @param {Diagram} diagram */
    fitted({ from, to }) {
        const points = this.in_order().filter(({ x }) => x >= from && x <= to).flatMap(({ x, rows }) => {
            const samples = rows.find((row) => row)?.samples;
            return samples?.length ? [{ x, y: samples.reduce((sum, value) => sum + value, 0) / samples.length }] : [];
        });
        const mean = (/** @type {(point: { x: number, y: number }) => number} */ of) => points.reduce((sum, point) => sum + of(point), 0) / points.length;
        const [x, y] = [mean((point) => point.x), mean((point) => point.y)];
        const slope = mean((point) => (point.x - x) * (point.y - y)) / mean((point) => (point.x - x) ** 2);
        return Number.isFinite(slope) ? Number(slope.toPrecision(4)) : 0;
    }

    /** @param {number} x */
    nearest(x) {
        let best = null;
        let distance = Infinity;
        for (const column of this.in_order()) {
            const off = Math.abs(column.x - x);
            if (off < distance) [best, distance] = [column, off];
        }
        return best;
    }
}
