/** A map over two parameters: cells, which are halved again and again. */

import { Lattice } from "./lattice.js";
import { class_of } from "../drawing/palette.js";

/** @typedef {import("../drawing/raster.js").Row} Row */
/** @typedef {{ x: number, y: number, level: number, row: Row }} Cell */
/** @typedef {import("../state.js").Diagram} Diagram */

export class Plane {
    constructor() {
        /** @type {Map<string, Cell>} */
        this.cells = new Map();
        this.across = new Lattice(0, 1);
        this.up = new Lattice(0, 1);
        this.home = {};
        /** @type {Map<number, [number, number]>} sizes of cells by level */
        this.steps = new Map();
    }

    /** @param {Diagram} diagram */
    clear(diagram) {
        this.cells = new Map();
        this.across = new Lattice(diagram.from, diagram.to - diagram.from);
        this.up = new Lattice(diagram.second_from, diagram.second_to - diagram.second_from || 1);
        this.home = { second_from: diagram.second_from, second_to: diagram.second_to };
    }

    /**
     * The sweeps that are missing of what is seen, the coarse ones first.
     * @param {Diagram} diagram
     * @param {number} coarse
     * @param {number} fine
     */
    plan(diagram, coarse, fine) {
        const { across, up, cells } = this;
        const known = new Set(cells.keys());
        const plan = [];
        const [x0, x1] = [diagram.from, diagram.to];
        const [y0, y1] = [diagram.second_from, diagram.second_to];
        for (let count = coarse; count <= fine; count *= 2) {
            const level_x = across.level(x0, x1, count);
            const level_y = up.level(y0, y1, count);
            const [first, last] = up.places(level_y, y0, y1);
            /** @type {Map<string, number[]>} rows of the same missing places */
            const alike = new Map();
            for (let place = first; place <= last; place += 1) {
                const key_y = up.key(level_y, place);
                const runs = across.missing(level_x, x0, x1, (key) => known.has(`${key}|${key_y}`));
                for (const run of runs) {
                    const name = `${run.first}:${run.stride}:${run.count}`;
                    alike.set(name, [...(alike.get(name) ?? []), place]);
                    for (let k = 0; k < run.count; k += 1) known.add(`${across.key(level_x, run.first + k * run.stride)}|${key_y}`);
                }
            }
            for (const [name, places] of alike) {
                const [run_first, stride, run_count] = name.split(":").map(Number);
                const missing = new Set(places);
                const runs_up = up.missing(level_y, y0, y1, (key) => ![...missing].some((place) => up.key(level_y, place) === key));
                for (const run_up of runs_up) {
                    const run = { level: level_x, first: run_first, stride, count: run_count, rows: run_up.count, up: run_up, size: count };
                    const text = (/** @type {string} */ parameter, /** @type {Lattice} */ lattice, /** @type {import("./lattice.js").Run} */ run) =>
                        `${parameter}=${lattice.value(run.level, run.first)}:${lattice.value(run.level, run.first + (run.count - 1) * run.stride)}:${run.count}`;
                    plan.push({ sweep: [text(diagram.over, across, run), text(diagram.second, up, run_up)], run });
                }
            }
        }
        return plan;
    }

    /**
     * @param {any} run
     * @param {number} x
     * @param {number} y
     * @param {Row} row
     */
    take(run, x, y, row) {
        const key = (/** @type {Lattice} */ lattice, /** @type {import("./lattice.js").Run} */ run, /** @type {number} */ value) => {
            const low = lattice.value(run.level, run.first);
            const high = lattice.value(run.level, run.first + (run.count - 1) * run.stride);
            const index = run.count > 1 ? Math.round(((value - low) / (high - low)) * (run.count - 1)) : 0;
            return lattice.key(run.level, run.first + index * run.stride);
        };
        this.cells.set(`${key(this.across, run, x)}|${key(this.up, run.up, y)}`, { x, y, level: run.size, row });
        this.steps.set(run.size, [this.across.step(run.level), this.up.step(run.up.level)]);
    }

    /**
     * @param {CanvasRenderingContext2D} context
     * @param {import("../drawing/plot.js").Plot} plot
     * @param {string[]} outcomes
     */
    draw(context, plot, outcomes) {
        // Large cells first, small ones over them.
        const cells = [...this.cells.values()].sort((one, other) => one.level - other.level);
        for (const { x, y, level, row } of cells) {
            const [wide, high] = this.steps.get(level) ?? [0, 0];
            const [left, right] = [Math.round(plot.px(x - wide / 2)), Math.round(plot.px(x + wide / 2))];
            const [top, bottom] = [Math.round(plot.py(y + high / 2)), Math.round(plot.py(y - high / 2))];
            context.fillStyle = class_of(outcomes[row.outcome], row.period)[1];
            context.fillRect(left, top, Math.max(1, right - left), Math.max(1, bottom - top));
        }
    }

    /**
     * @param {number} x
     * @param {number} y
     * @returns {Cell | null}
     */
    at(x, y) {
        let best = null;
        let distance = Infinity;
        for (const cell of this.cells.values()) {
            const off = Math.hypot((cell.x - x) / this.across.width, (cell.y - y) / this.up.width);
            if (off < distance) [best, distance] = [cell, off];
        }
        return best;
    }
}
