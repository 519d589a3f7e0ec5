/** The state in the address of the page, so that a view can be shared, and the way back works. */

/** @typedef {import("./state.js").State} State */

const NUMBERS = /** @type {const} */ (["columns", "transient", "keep"]);

/**
 * @param {Uint8Array} bytes
 * @param {CompressionStream | DecompressionStream} through
 */
async function passed(bytes, through) {
    const stream = new Blob([/** @type {BlobPart} */ (bytes)]).stream().pipeThrough(through);
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {string} text */
export async function packed(text) {
    const bytes = await passed(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
    const letters = btoa(String.fromCharCode(...bytes));
    return letters.replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** @param {string} letters */
export async function unpacked(letters) {
    const bytes = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
    return new TextDecoder().decode(await passed(bytes, new DecompressionStream("deflate-raw")));
}

/**
 * @param {State} state
 * @param {(name: string) => string | undefined} shipped the text of a shipped model
 */
export async function address_of(state, shipped) {
    const { diagram } = state;
    const parts = new URLSearchParams();
    parts.set("model", state.name);
    if (shipped(state.name) !== state.text) parts.set("text", await packed(state.text));
    for (const [name, value] of Object.entries(state.set)) parts.append("set", `${name}=${value}`);
    for (const [name, value] of Object.entries(state.initial)) parts.append("initial", `${name}=${value}`);
    parts.set("over", `${diagram.over}=${diagram.from}:${diagram.to}`);
    if (diagram.y) parts.set("y", diagram.y.join(":"));
    if (diagram.second) parts.set("second", `${diagram.second}=${diagram.second_from}:${diagram.second_to}`);
    parts.set("observe", diagram.observe);
    parts.set("sampling", diagram.sampling);
    parts.set("start", diagram.start);
    if (diagram.bounds) parts.set("box", diagram.bounds);
    for (const name of NUMBERS) parts.set(name, String(diagram[name]));
    if (diagram.exponent) parts.set("exponent", "yes");
    if (diagram.slope) parts.set("slope", String(diagram.slope));
    if (state.picked !== null) parts.set("at", String(state.picked));
    for (const [name, value] of Object.entries(state.through ?? {})) parts.append("through", `${name}=${value}`);
    parts.set("time", `${state.from}:${state.to}`);
    parts.set("portrait", state.portrait.join(","));
    parts.set("returned", state.returned);
    return `#${parts}`;
}

/**
 * What an address says; nothing of what it leaves out or garbles.
 * @param {string} hash
 * @returns {Promise<any>}
 */
export async function state_of(hash) {
    const parts = new URLSearchParams(hash.replace(/^#/, ""));
    /** @type {any} */
    const found = { diagram: {} };
    const text = (/** @type {string} */ name) => parts.get(name) ?? undefined;
    const number = (/** @type {string | undefined} */ value) => {
        const read = value === undefined || value === "" ? NaN : Number(value);
        return Number.isFinite(read) ? read : undefined;
    };
    const range = (/** @type {string | undefined} */ value) => {
        const ends = (value ?? "").split(":").map(number);
        return ends.length === 2 && ends[0] !== undefined && ends[1] !== undefined && ends[0] < ends[1] ? /** @type {[number, number]} */ (ends) : undefined;
    };
    const pairs = (/** @type {string} */ name) =>
        parts.has(name) || parts.has("model") ? Object.fromEntries(parts.getAll(name).map((pair) => [pair.slice(0, pair.indexOf("=")), pair.slice(pair.indexOf("=") + 1)]).filter(([left]) => left)) : undefined;
    const swept = (/** @type {string} */ name) => {
        const [left, right] = (text(name) ?? "").split("=");
        const ends = range(right);
        return left && ends ? { name: left, ends } : undefined;
    };
    found.name = text("model");
    const letters = text("text");
    if (letters) found.text = await unpacked(letters).catch(() => undefined);
    found.set = pairs("set");
    found.initial = pairs("initial");
    const [over, second] = [swept("over"), swept("second")];
    if (over) Object.assign(found.diagram, { over: over.name, from: over.ends[0], to: over.ends[1] });
    if (second) Object.assign(found.diagram, { second: second.name, second_from: second.ends[0], second_to: second.ends[1] });
    else if (parts.has("model")) found.diagram.second = "";
    if (parts.has("model")) found.diagram.y = range(text("y")) ?? null;
    for (const name of ["observe", "sampling", "start"]) if (text(name)) found.diagram[name] = text(name);
    found.diagram.bounds = text("box");
    for (const name of NUMBERS) {
        const value = number(text(name));
        if (value !== undefined && value >= 0) found.diagram[name] = Math.floor(value);
    }
    if (parts.has("model")) {
        found.diagram.exponent = text("exponent") === "yes";
        found.diagram.slope = number(text("slope")) ?? 0;
        found.picked = number(text("at")) ?? null;
        const through = Object.entries(pairs("through") ?? {}).map(([name, value]) => /** @type {[string, number | undefined]} */ ([name, number(value)]));
        found.through = through.length > 0 && through.every(([, value]) => value !== undefined) ? Object.fromEntries(through) : null;
    }
    const time = range(text("time"));
    if (time) [found.from, found.to] = time;
    const portrait = (text("portrait") ?? "").split(",");
    if (portrait.length === 2) found.portrait = portrait;
    found.returned = text("returned");
    return found;
}
