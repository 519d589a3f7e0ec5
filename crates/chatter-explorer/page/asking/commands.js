/** The command line and the line of Python that make what is seen. */

import { sampled } from "../state.js";

/** @typedef {import("../state.js").Store} Store */

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
        const { set, initial } = this.store.model(picked);
        const { over, second } = this.store.state.diagram;
        return this.python_source([...(picked ? set : set.filter(([name]) => name !== over && name !== second)), ...initial]);
    }

    /** The model with these values. @param {[string, string][]} values */
    python_source(values) {
        const model = this.model();
        const source = this.shipped(model) ? `ch.Model.shipped(${string(model)})` : `ch.Model.from_file(${string(model)})`;
        const text = values.map(([name, value]) => `${name}=${Number.isFinite(Number(value)) ? value : string(value)}`).join(", ");
        return source + (values.length ? `.with_values(${text})` : "");
    }

    /** What the figures and tables call time. */
    time() {
        return this.store.checked?.states.find((state) => state.time)?.name ?? "t";
    }

    /**
     * @param {string} stem of the files
     * @param {string[]} axes of the panels
     * @param {{ sample?: string, until?: number }} [more] rows of the table; the end of what is shown
     */
    history(stem, axes, { sample, until } = {}) {
        const { from, to } = this.store.state;
        return line([
            "chatter", "simulate", this.model(), ...this.values(true), "--until", String(to), "--plot", `${stem}.svg`, "--window", `${from}:${until ?? to}`,
            ...axes.flatMap((axes) => ["--axes", axes]), ...(sample ? ["--sample", sample] : []), "--out", `${stem}.npz`,
        ]);
    }

    /** @param {string} rest what is done with `run`, and with matplotlib as `plt` */
    python_history(rest) {
        const { from, to } = this.store.state;
        const plots = rest.includes("plt.") ? "import matplotlib.pyplot as plt; " : "";
        const limits = from > 0 && rest.startsWith("run.plot") ? `.set_xlim(${from}, ${to})` : "";
        return `${plots}run = ${this.python_model(true)}.simulate(${to}); ${rest}${limits}`;
    }

    /**
     * The events at which orbits are sampled, as `run` has them within what is shown.
     * @param {string} sampling
     */
    python_events(sampling) {
        const [kind, name] = sampling.split(":");
        const events = kind === "section" ? `run.events.at(${string(name)})` : `run.events[${string(name)}]`;
        const { from } = this.store.state;
        return from > 0 ? `${events}; e = e[e.time >= ${from}]` : events;
    }

    /**
     * The question about the return map's own curve, which is a sweep over initial values.
     * @param {import("../motion/return-curve.js").Sampled} curve
     */
    returned(curve) {
        const { diagram } = this.store.state;
        const at = Object.entries(sampled(diagram.sampling)).flatMap(([name, value]) => [`--${name}`, value]);
        return line([
            "chatter", "diagram", this.model(), ...this.fixed(curve), "--sweep", curve.sweep, ...at,
            "--observe", curve.name, "--transient", "0", "--keep", "1", "--out", "returns-curve.npz", "--plot", "returns-curve.svg",
        ]);
    }

    /** @param {import("../motion/return-curve.js").Sampled} curve */
    fixed(curve) {
        const { set } = this.store.model(true);
        return [...set.flatMap(([name, value]) => ["--set", `${name}=${value}`]), "--initial", `${curve.held}=${curve.level}`];
    }

    /**
     * The return map with its cobweb, and the curve that it is on where there is one.
     * @param {string} name of the quantity
     * @param {boolean} state whether it is one
     * @param {import("../motion/return-curve.js").Sampled | null} curve
     */
    python_returned(name, state, curve) {
        const { sampling } = this.store.state.diagram;
        const events = `e = ${this.python_events(sampling)}`;
        if (!state) return this.python_history(`${events}; e`);
        const cobweb = `${events}; x = e[${string(name)}]; w = x[-61:].repeat(2); plt.plot(x[:-1], x[1:], ".", w[:-1], w[1:])`;
        if (!curve) return this.python_history(cobweb);
        const [from, to, count] = curve.sweep.slice(curve.sweep.indexOf("=") + 1).split(":");
        const at = Object.entries(sampled(sampling)).map(([option, value]) => `${option}=${string(value)}`);
        const asked = [`sweep={${string(`initial:${curve.name}`)}: (${from}, ${to}, ${count})}`, ...at, `observe=${string(curve.name)}`, "transient=0", "keep=1"];
        const drawn = `d = ${this.python_source([...this.store.model(true).set, [curve.held, String(curve.level)]])}.diagram(${asked.join(", ")}); plt.plot(d[${string(`initial_${curve.name}`)}][d["column"]], d[${string(curve.name)}])`;
        return this.python_history(`${cobweb}; ${drawn}`);
    }

    /** @param {{ restitution: number, slope: number, mu: number }} map */
    universal({ restitution, slope, mu }) {
        return line(["chatter", "universal", "--restitution", String(restitution), "--slope", String(slope), "--cobweb", `mu=${mu}`, "--out", "cobweb.npz", "--plot", "cobweb.svg"]);
    }

    /**
     * @param {{ restitution: number, slope: number, mu: number }} map
     * @param {[number, number]} range
     */
    python_universal({ restitution, slope, mu }, [low, high]) {
        return `import numpy as np, matplotlib.pyplot as plt; u = ch.Universal(${restitution}); z = np.linspace(${low}, ${high}, 1601); next = u(${slope} * z + ${mu}); plt.plot(z, next, z, z)`;
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

    /**
     * Model and values of a question about branches, without the parameter that they are over.
     * @param {any} asked
     */
    of_branches(asked) {
        const pairs = (/** @type {string} */ option, /** @type {[string, string][]} */ values) => values.filter(([name]) => name !== asked.parameter).flatMap(([name, value]) => [option, `${name}=${value}`]);
        return [this.model(), ...pairs("--set", asked.model.set), ...pairs("--initial", asked.model.initial), ...(asked.section ? ["--section", asked.section] : [])];
    }

    /** @param {any} asked for branches */
    branches(asked) {
        if (!asked) return "";
        return line(["chatter", "continue", ...this.of_branches(asked), "--sweep", `${asked.parameter}=${asked.from}:${asked.to}`, "--plot", "branches.svg", "--out", "branches.npz"]);
    }

    /** @param {any} asked */
    found_branches(asked) {
        const { set, initial } = asked.model;
        const values = [...set, ...initial].filter(([name]) => name !== asked.parameter);
        const how = asked.section ? `, how={"section": ${string(asked.section)}}` : "";
        return `ch.branches(${this.python_source(values)}, ${string(asked.parameter)}, ${asked.from}, ${asked.to}${how})`;
    }

    /** @param {any} asked */
    python_branches(asked) {
        return asked ? `branches = ${this.found_branches(asked)}; branches[0].plot()` : "";
    }

    /**
     * @param {any} asked for branches
     * @param {import("../theory/curves.js").Followed | undefined} followed
     */
    curve(asked, followed) {
        if (!asked || !followed) return "";
        const { question, of } = followed;
        const [first, second] = question.parameters;
        const branches = line(["chatter", "continue", ...this.of_branches(asked), "--sweep", `${asked.parameter}=${asked.from}:${asked.to}`, "--out", "branches.npz"]);
        const curve = line(["chatter", "continue", ...this.of_branches(asked), "--sweep", `${second}=${question.from}:${question.to}`, "--free", `${first},${second}`, "--from", `branches.npz:${of.number}`, "--plot", "curve.svg", "--out", "curve.npz"]);
        return `${branches} && ${curve}`;
    }

    /**
     * @param {any} asked
     * @param {import("../theory/curves.js").Followed | undefined} followed
     */
    python_curve(asked, followed) {
        if (!asked || !followed) return "";
        const { question, of } = followed;
        const [first, second] = question.parameters.map(string);
        return `curve = ${this.found_branches(asked)}[${of.branch}].special[${string(of.point.kind)}][${of.place}].follow(${first}, ${second}, low=${question.from}, high=${question.to}); curve.plot()`;
    }

    /** @param {any} border */
    border(border) {
        if (!border) return "";
        const { over } = this.store.state.diagram;
        return line(["chatter", "border", this.model(), ...this.varied(over), "--parameter", over, "--near", String(border.value), "--plot", "border.svg", "--out", "border.npz"]);
    }

    /** @param {any} border */
    python_border(border) {
        if (!border) return "";
        const { over } = this.store.state.diagram;
        const values = Object.entries(this.store.state.set).filter(([name]) => name !== over);
        return `border = ${this.python_source(values)}.border(${string(over)}, near=${border.value}); border.value`;
    }

    /** What is set but for one parameter. @param {string} over */
    varied(over) {
        return this.store.model(false).set.filter(([name]) => name !== over).flatMap(([name, value]) => ["--set", `${name}=${value}`]);
    }
}
