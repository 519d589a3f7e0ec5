/** What can be chosen of a diagram: what is swept, observed, where orbits start and are sampled. */

import { choice, field, make } from "../elements/dom.js";
import { slope_of } from "./rows.js";
import { rounded } from "../drawing/ticks.js";

/** @typedef {import("../state.js").Diagram} Diagram */

export class DiagramControls {
    /**
     * @param {import("../state.js").Store} store
     * @param {import("./rows.js").Rows} rows
     * @param {() => void} reset everything is to be seen again
     */
    constructor(store, rows, reset) {
        this.store = store;
        this.rows = rows;
        this.reset = reset;
        this.settings_shown = false;
        /** @type {HTMLInputElement[]} */
        this.ends = [];
        this.element = make("div", { class: "toolbar" });
    }

    /** @param {(diagram: Diagram) => void} how @param {boolean} [home] the vertical axis shows everything again */
    edit(how, home = false) {
        this.store.change("view", (state) => {
            how(state.diagram);
            if (home) state.diagram.y = null;
        });
    }

    /** Some way around a parameter's value. @param {string} name @returns {number[]} */
    around(name) {
        const value = this.store.checked?.parameters.find((one) => one.name === name)?.value ?? 1;
        return value === 0 ? [-1, 1] : [value - 0.25 * Math.abs(value), value + 0.25 * Math.abs(value)].map((end) => rounded(end, Math.abs(value) / 100));
    }

    build() {
        const { diagram } = this.store.state;
        if (!this.store.checked) return;
        const level = make("button", { type: "button", title: "Draw a slanted diagram level", "aria-pressed": String(slope_of(diagram) !== 0), hidden: diagram.second !== "", onclick: () => {
            this.edit((diagram) => { diagram.slope = diagram.slope ? 0 : this.rows.fitted(diagram); }, true);
            this.build();
        } }, "Level");
        const all = make("button", { type: "button", title: "Show all (0)", onclick: () => this.reset() }, "All");
        this.element.replaceChildren(make("div", { class: "row" }, ...this.axes(), ...this.starts(), level, all), this.more());
    }

    /** Parameters and what is observed. */
    axes() {
        const { store } = this;
        const { diagram } = store.state;
        const checked = /** @type {import("../state.js").Checked} */ (store.checked);
        const parameters = /** @type {[string, string][]} */ (checked.parameters.filter((one) => !one.unused).map((one) => [one.name, one.name]));
        const over = choice("Parameter across", parameters, diagram.over, (name) => {
            const [from, to] = this.around(name);
            store.change("view", (state) => {
                Object.assign(state.diagram, { over: name, from, to, y: null, slope: 0 });
                if (state.diagram.second === name) state.diagram.second = "";
                state.picked = null;
                state.through = null;
            });
            this.build();
        });
        const from = number("from", diagram.from, (value) => this.edit((diagram) => { if (value < diagram.to) diagram.from = value; }, true));
        const to = number("to", diagram.to, (value) => this.edit((diagram) => { if (value > diagram.from) diagram.to = value; }, true));
        this.ends = [from, to];
        const others = /** @type {[string, string][]} */ ([["", "observe a quantity"], ...parameters.filter(([name]) => name !== diagram.over).map(([name]) => [name, `parameter ${name}`])]);
        const second = choice("Upwards", others, diagram.second, (name) => {
            const [low, high] = name ? this.around(name) : [0, 1];
            store.change("view", (state) => Object.assign(state.diagram, { second: name, second_from: low, second_to: high, y: null }));
            this.build();
        });
        const list = make("datalist", { id: "quantities" }, ...checked.states.filter((state) => !state.time).map((state) => make("option", { value: state.name })), make("option", { value: "impacts" }));
        const observe = make("input", {
            type: "text", list: "quantities", size: 8, ".value": diagram.observe, "aria-label": "Observed quantity, an expression", spellcheck: "false",
            onchange: () => this.edit((diagram) => { diagram.observe = observe.value.trim() || diagram.observe; diagram.slope = 0; }, true),
        });
        return [field("over", over), field("from", from), field("to", to), field("upwards", second), diagram.second ? "" : field("observed", observe), list];
    }

    starts() {
        const { diagram } = this.store.state;
        const start = choice("Where orbits start", [["fresh", "afresh"], ["carry", "carried up"], ["carry:down", "carried down"], ["carry:both", "carried both ways"], ["random:4", "at random"]], diagram.start, (value) => {
            if (value.startsWith("random") && !diagram.bounds) this.propose_bounds();
            this.edit((diagram) => { diagram.start = value; }, true);
            this.build();
        });
        const bounds = make("input", {
            type: "text", size: 22, ".value": diagram.bounds, "aria-label": "Bounds of random starts", placeholder: "y1=0:1, y2=-1:1", spellcheck: "false",
            onchange: () => this.edit((diagram) => { diagram.bounds = bounds.value; }),
        });
        return [field("starts", start), diagram.start.startsWith("random") ? field("within", bounds) : ""];
    }

    more() {
        const { diagram } = this.store.state;
        const checked = /** @type {import("../state.js").Checked} */ (this.store.checked);
        const where = /** @type {[string, string][]} */ ([...checked.sections.map((section) => [`section:${section.name}`, `section ${section.name}`]), ...(checked.contacts.length ? [["at:impact", "every impact"], ["at:release", "every release"]] : [])]);
        if (!where.some(([value]) => value === diagram.sampling)) where.push([diagram.sampling, diagram.sampling.replace(":", " ")]);
        const sampling = choice("Where orbits are sampled", where, diagram.sampling, (value) => this.edit((diagram) => { diagram.sampling = value; }, true));
        const columns = choice("Columns", ["128", "256", "512", "1024", "2048", "4096"].map((count) => [count, count]), String(diagram.columns), (value) => this.edit((diagram) => { diagram.columns = Number(value); }));
        const whole = { min: 0, step: 1 };
        const more = make(
            "details",
            { class: "more", ".open": this.settings_shown, ontoggle: () => (this.settings_shown = more.open) },
            make("summary", {}, "More"),
            make(
                "div", { class: "row" },
                field("sampled at", sampling),
                field("columns", columns),
                field("passed over", number("Samples passed over", diagram.transient, (value) => this.edit((diagram) => { diagram.transient = Math.max(0, Math.round(value)); }), whole)),
                field("kept", number("Samples kept", diagram.keep, (value) => this.edit((diagram) => { diagram.keep = Math.max(1, Math.round(value)); }), { ...whole, min: 1 })),
                field("exponent", make("input", { type: "checkbox", ".checked": diagram.exponent, onchange: (/** @type {Event} */ event) => this.edit((diagram) => { diagram.exponent = /** @type {HTMLInputElement} */ (event.target).checked; }) })),
            ),
        );
        return more;
    }

    /** Bounds for random starts: some way around the initial values. */
    propose_bounds() {
        const states = this.store.checked?.states.filter((state) => !state.time) ?? [];
        const plain = (/** @type {number} */ value) => String(Number(value.toPrecision(6)));
        const bound = (/** @type {{ name: string, value: number }} */ { name, value }) => `${name}=${plain(value)}:${plain(value + Math.max(1, Math.abs(value) * 0.2))}`;
        this.store.state.diagram.bounds = states.slice(0, 2).map(bound).join(", ");
    }

    /** The ends of the range, unless they are being typed. */
    follow() {
        const { from, to } = this.store.state.diagram;
        if (this.ends.some((end) => document.activeElement === end)) return;
        const step = (to - from) / 1000;
        [from, to].forEach((value, place) => this.ends[place] && (this.ends[place].value = String(rounded(value, step))));
    }
}

/**
 * @param {string} label
 * @param {number} value
 * @param {(value: number) => void} set
 * @param {object} [limits]
 */
const number = (label, value, set, limits = {}) =>
    make("input", {
        type: "number", step: "any", ".value": String(value), "aria-label": label, ...limits,
        onchange: (/** @type {Event} */ event) => {
            const input = /** @type {HTMLInputElement} */ (event.target);
            if (input.value !== "" && Number.isFinite(input.valueAsNumber)) set(input.valueAsNumber);
        },
    });
