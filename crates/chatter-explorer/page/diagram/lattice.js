/**
 * Where the columns of a diagram are: on a lattice that is halved again and again, the same for every view. What was computed
 * for one view is there for the next.
 */

/** @typedef {{ level: number, first: number, stride: number, count: number }} Run of places first, first + stride, … */

export class Lattice {
    /**
     * @param {number} from where it has its origin
     * @param {number} width its step at level zero
     */
    constructor(from, width) {
        this.from = from;
        this.width = width;
    }

    /**
     * @param {number} level
     * @param {number} place
     */
    value(level, place) {
        // The fraction is exact, so that a place has one value at every level.
        return this.from + (place / 2 ** level) * this.width;
    }

    /** @param {number} level */
    step(level) {
        return this.width / 2 ** level;
    }

    /**
     * A place under the name that it has at the coarsest level.
     * @param {number} level
     * @param {number} place
     */
    key(level, place) {
        return place / 2 ** level;
    }

    /**
     * The coarsest level with so many columns between two values.
     * @param {number} low
     * @param {number} high
     * @param {number} count
     */
    level(low, high, count) {
        return Math.ceil(Math.log2((count * this.width) / (high - low)) - 1e-9);
    }

    /**
     * The places of a level between two values.
     * @param {number} level
     * @param {number} low
     * @param {number} high
     * @returns {[number, number]}
     */
    places(level, low, high) {
        const scale = 2 ** level / this.width;
        return [Math.ceil((low - this.from) * scale - 1e-6), Math.floor((high - this.from) * scale + 1e-6)];
    }

    /**
     * What is missing of a level between two values.
     * @param {number} level
     * @param {number} low
     * @param {number} high
     * @param {(key: number) => boolean} known
     * @returns {Run[]}
     */
    missing(level, low, high, known) {
        const [first, last] = this.places(level, low, high);
        /** @type {Run[]} */
        const runs = [];
        /** @type {number[]} */
        const open = [];
        for (let place = first; place <= last; place += 1) {
            if (!known(this.key(level, place))) open.push(place);
        }
        for (const place of open) {
            const run = runs.at(-1);
            const next = run ? run.first + run.stride * run.count : NaN;
            if (run && run.count === 1 && place - run.first <= 2) {
                run.stride = place - run.first;
                run.count = 2;
            } else if (run && place === next) {
                run.count += 1;
            } else {
                runs.push({ level, first: place, stride: 1, count: 1 });
            }
        }
        return runs;
    }
}
