/** The command line and the line of Python that make what is seen. */

import { sampled } from "./state.js";

/** @typedef {import("./state.js").Store} Store */

/** @param {string} text */
const quoted = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);

/** @param {(string | null | undefined | false)[]} parts */
const line = (parts) => parts.filter((part) => typeof part === "string").map((part) => quoted(/** @type {string} */ (part))).join(" ");

/** @param {string} text */
const string = (text) => JSON.stringify(text);

export class Commands {
    /**
     * @param {Store} store
     * @param {(name: string) => string | undefined} shipped
     * @param {{ name: string, text: string }} given the model that the explorer was opened with
     */
    constructor(store, shipped, given) {
        this.store = store;
        this.shipped = shipped;
        this.given = given;
    }

    /** What the model is called on the command line; what was changed has to be saved first. */
    model() {
        const { name, text } = this.store.state;
        if (this.shipped(name) === text || (this.given.name === name && this.given.text === text)) return name;
        const bare = name.replace(/^.*[/\\]/, "").replace(/\.toml$/, "");
        return `${bare}.toml`;
    }

    /** @param {boolean} picked */
    values(picked) {
        const { set, initial } = this.store.model(picked);
        const { over, second } = this.store.state.diagram;
        const kept = picked ? set : set.filter(([name]) => name !== over && name !== second);
        const options = (/** @type {string} */ option, /** @type {[string, string][]} */ pairs) => pairs.flatMap(([name, value]) => [option, `${name}=${value}`]);
        return [...options("--set", kept), ...options("--initial", initial)];
    }

    /** @param {boolean} picked */
    python_model(picked) {
        const model = this.model();
        const source = this.shipped(model) ? `ch.Model.shipped(${string(model)})` : `ch.Model.from_file(${string(model)})`;
        const { set, initial } = this.store.model(picked);
        const { over, second } = this.store.state.diagram;
        const kept = picked ? set : set.filter(([name]) => name !== over && name !== second);
        const named = (/** @type {[string, string][]} */ pairs) => pairs.map(([name, value]) => `${name}=${Number.isFinite(Number(value)) ? value : string(value)}`).join(", ");
        const values = [...kept, ...initial];
        return source + (values.length ? `.with_values(${named(values)})` : "");
    }

    history() {
        const { from, to } = this.store.state;
        return line(["chatter", "simulate", this.model(), ...this.values(true), "--until", String(to), "--plot", "history.svg", "--window", `${from}:${to}`, "--out", "history.npz"]);
    }

    python_history() {
        return `run = ${this.python_model(true)}.simulate(${this.store.state.to}); run.plot()`;
    }

    /** @param {number} columns across what is seen */
    diagram(columns) {
        const { diagram } = this.store.state;
        const at = sampled(diagram.sampling);
        const maps = diagram.second !== "";
        return line([
            "chatter", "diagram", this.model(), ...this.values(false),
            "--sweep", `${diagram.over}=${diagram.from}:${diagram.to}:${columns}`,
            ...(maps ? ["--sweep", `${diagram.second}=${diagram.second_from}:${diagram.second_to}:${columns}`] : []),
            ...Object.entries(at).flatMap(([name, value]) => [`--${name}`, value]),
            "--observe", diagram.observe,
            ...(diagram.start === "fresh" ? [] : ["--start", diagram.start]),
            ...this.bounds().flatMap((bound) => ["--box", bound]),
            "--transient", String(diagram.transient), "--keep", String(diagram.keep),
            ...(diagram.exponent ? ["--exponent"] : []),
            "--out", "diagram.npz", "--plot", "diagram.svg",
            ...(diagram.slope && !maps ? ["--shear", String(diagram.slope)] : []),
        ]);
    }

    bounds() {
        const { diagram } = this.store.state;
        if (!diagram.start.startsWith("random")) return [];
        return diagram.bounds.split(",").map((bound) => bound.trim()).filter(Boolean);
    }

    /** @param {number} columns */
    python_diagram(columns) {
        const { diagram } = this.store.state;
        const sweeps = [[diagram.over, diagram.from, diagram.to], ...(diagram.second ? [[diagram.second, diagram.second_from, diagram.second_to]] : [])];
        const options = [
            ...sweeps.map(([name, from, to]) => `${name}=(${from}, ${to}, ${columns})`),
            `observe=${string(diagram.observe)}`,
            ...Object.entries(sampled(diagram.sampling)).map(([name, value]) => `${name}=${string(value)}`),
            ...(diagram.start === "fresh" ? [] : [`start=${string(diagram.start)}`]),
            ...(this.bounds().length ? [`box={${this.bounds().map((bound) => `${string(bound.split("=")[0])}: (${bound.split("=")[1].replace(":", ", ")})`).join(", ")}}`] : []),
            `transient=${diagram.transient}`, `keep=${diagram.keep}`,
            ...(diagram.exponent ? ["exponent=True"] : []),
        ];
        return `d = ${this.python_model(false)}.diagram(${options.join(", ")}); d.plot(${diagram.slope ? `shear=${diagram.slope}` : ""})`;
    }

    branches() {
        const { diagram } = this.store.state;
        return line(["chatter", "continue", this.model(), ...this.values(false), "--sweep", `${diagram.over}=${diagram.from}:${diagram.to}`, "--plot", "branch.svg", "--out", "branch.npz"]);
    }

    python_branches() {
        const { diagram } = this.store.state;
        return `branch = ${this.python_model(false)}.orbit().follow(${string(diagram.over)}, to=${diagram.to}); branch.plot()`;
    }
}
