/** Sliders for parameters and initial values. */

import { make } from "./dom.js";
import { plain } from "../drawing/labels.js";
import { rounded } from "../drawing/ticks.js";

/** @typedef {import("../state.js").Quantity} Quantity */
/** @typedef {import("../state.js").Store} Store */

/** Steps of a slider from end to end. */
const STEPS = 1000;

export class Knobs {
    /** @param {Store} store */
    constructor(store) {
        this.store = store;
        this.parameters = make("div", { class: "knobs" });
        this.starts = make("div", { class: "knobs" });
        this.element = make(
            "div", { class: "knob-groups" },
            make("details", { open: true }, make("summary", {}, "Parameters"), this.parameters),
            make("details", {}, make("summary", {}, "Initial values"), this.starts),
        );
        /** @type {Map<string, (value: number | null) => void>} */
        this.shows = new Map();
        store.on((change) => {
            if (change === "model") this.build();
            else this.follow();
        });
    }

    build() {
        const { checked } = this.store;
        if (!checked) return;
        this.shows = new Map();
        this.parameters.replaceChildren(...checked.parameters.map((one) => this.knob(one, "set")));
        this.starts.replaceChildren(...checked.states.map((one) => this.knob(one, "initial")));
        this.follow();
    }

    /**
     * The value that holds now: the one picked in the diagram, else the one set, else the model's.
     * @param {Quantity} quantity
     * @param {"set" | "initial"} where
     */
    value(quantity, where) {
        const { state } = this.store;
        if (where === "set" && quantity.name === state.diagram.over && state.picked !== null) return state.picked;
        const text = state[where][quantity.name];
        return text === undefined ? quantity.value : Number(text);
    }

    /**
     * @param {Quantity} quantity
     * @param {"set" | "initial"} where
     */
    knob(quantity, where) {
        const { name, label, depends } = quantity;
        const own = quantity.value;
        const reach = own === 0 ? 1 : Math.abs(own);
        const [low, high] = own === 0 ? [-1, 1] : own > 0 && where === "set" ? [0, 2 * own] : [own - reach, own + reach];
        const range = make("input", { type: "range", min: low, max: high, step: "any", id: `${where}-${name}`, "aria-label": `${name}, slider` });
        const box = make("input", { type: "number", step: "any", "aria-label": name });
        const set = (/** @type {number} */ value) => {
            if (!Number.isFinite(value)) return;
            this.store.change("values", (state) => {
                state.through = null;
                if (where === "set" && name === state.diagram.over && state.picked !== null) state.picked = value;
                else if (value === own) delete state[where][name];
                else state[where][name] = String(value);
            });
        };
        range.addEventListener("input", () => set(rounded(range.valueAsNumber, (high - low) / STEPS)));
        box.addEventListener("change", () => set(box.valueAsNumber));
        const back = make("button", { type: "button", class: "back", title: `back to ${own}`, "aria-label": `${name} back to ${own}`, onclick: () => {
            this.store.change("values", (state) => {
                if (where === "set" && name === state.diagram.over) state.picked = null;
                delete state[where][name];
            });
        } }, "↺");
        this.shows.set(`${where} ${name}`, () => {
            const value = this.value(quantity, where);
            if (value < range.valueAsNumber || value > Number(range.max)) range.max = String(Math.max(Number(range.max), value));
            if (value < Number(range.min)) range.min = String(value);
            range.value = String(value);
            if (document.activeElement !== box) box.value = String(value);
            back.hidden = value === own;
        });
        const words = label?.text ? plain(label.text) : "";
        return make("div", { class: "knob", title: [words, depends ? "computed from other parameters" : ""].filter(Boolean).join("; ") }, make("label", { for: `${where}-${name}` }, name), range, box, back);
    }

    follow() {
        for (const show of this.shows.values()) show(null);
    }
}
