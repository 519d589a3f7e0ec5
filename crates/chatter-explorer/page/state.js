/** What is looked at: all of it, in one place, and the address that brings it back. */

/**
 * @typedef {object} Diagram
 * @property {string} over the parameter
 * @property {number} from
 * @property {number} to
 * @property {[number, number] | null} y what is seen of the vertical axis; all without it
 * @property {string} second another parameter; none if empty
 * @property {number} second_from
 * @property {number} second_to
 * @property {string} observe
 * @property {string} sampling "section:NAME", "at:KIND", "period:EXPR"
 * @property {string} start as on the command line
 * @property {string} bounds of random starts, as on the command line, with commas between
 * @property {number} columns
 * @property {number} transient
 * @property {number} keep
 * @property {boolean} exponent
 * @property {number} slope a multiple of the parameter that is subtracted, so that a slanted diagram is level
 */

/**
 * @typedef {object} State
 * @property {string} name of the model
 * @property {string} text of the model
 * @property {Record<string, string>} set parameters that differ from the model's
 * @property {Record<string, string>} initial
 * @property {Diagram} diagram
 * @property {number | null} picked the value of the swept parameter that was clicked
 * @property {Record<string, number> | null} through where the picked periodic orbit starts; none for a motion from the initial values
 * @property {number} from shown of the motion
 * @property {number} to
 * @property {[string, string]} portrait
 * @property {string} returned the quantity of the return map
 */

/** @typedef {{ name: string, value: number, depends: boolean, label: import("./drawing/labels.js").Label, unused?: boolean, time?: boolean }} Quantity */
/**
 * @typedef {object} Checked what the model is
 * @property {string | null} title
 * @property {string | null} source
 * @property {Quantity[]} states
 * @property {Quantity[]} parameters
 * @property {string[]} contacts
 * @property {{ name: string, surface: string, direction: string }[]} sections
 * @property {string[]} phases
 * @property {string[]} warnings
 * @property {any} drawing
 */

/** @typedef {"model" | "values" | "view" | "motion" | "look"} Change what has changed: the text, parameters or starts, the
 *   diagram's box or options, the times that are shown, or how it is shown */

export class Store {
    /** @param {State} state */
    constructor(state) {
        this.state = state;
        /** @type {Checked | null} */
        this.checked = null;
        /** @type {any} border orbits that were found, as a document */
        this.borders = null;
        /** @type {((change: Change) => void)[]} */
        this.listeners = [];
    }

    /** @param {(change: Change) => void} listener */
    on(listener) {
        this.listeners.push(listener);
    }

    /**
     * @param {Change} change
     * @param {(state: State) => void} edit
     */
    change(change, edit) {
        edit(this.state);
        for (const listener of this.listeners) listener(change);
    }

    /** What questions say of the model: with the value that was picked, where there is one. */
    model(picked = true) {
        const { name, text, set, initial, picked: value, through, diagram } = this.state;
        const all = { ...set };
        const starts = { ...initial };
        if (picked && value !== null) all[diagram.over] = String(value);
        if (picked && through) for (const [state, start] of Object.entries(through)) starts[state] = String(start);
        return { name, text, set: Object.entries(all), initial: Object.entries(starts) };
    }

    /** The border orbit that is nearest to the value that is looked at, where one is known. */
    border() {
        const { picked, diagram } = this.state;
        const at = picked ?? (diagram.from + diagram.to) / 2;
        const borders = /** @type {any[]} */ (this.borders?.borders ?? []).filter(({ parameter }) => parameter === diagram.over);
        return borders.sort((one, other) => Math.abs(one.value - at) - Math.abs(other.value - at))[0] ?? null;
    }

    /**
     * The value of a parameter that is looked at.
     * @param {string} name
     */
    value(name) {
        const { picked, diagram, set } = this.state;
        if (name === diagram.over && picked !== null) return picked;
        const own = this.checked?.parameters.find((one) => one.name === name)?.value ?? NaN;
        return set[name] === undefined ? own : Number(set[name]);
    }

    /** @param {string} name */
    label(name) {
        const { checked } = this;
        const known = [...(checked?.states ?? []), ...(checked?.parameters ?? [])];
        return known.find((quantity) => quantity.name === name)?.label ?? null;
    }
}

/** How orbits are sampled, for questions about diagrams. */
export const sampled = (/** @type {string} */ sampling) => {
    const [kind, ...rest] = sampling.split(":");
    return kind ? { [kind]: rest.join(":") } : {};
};
