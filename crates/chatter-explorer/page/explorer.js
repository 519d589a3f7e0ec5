/** The explorer: all views, and what passes between them. */

import { address_of, state_of } from "./address.js";
import { Commands } from "./asking/commands.js";
import { DiagramView } from "./diagram/view.js";
import { make } from "./elements/dom.js";
import { Editor } from "./elements/editor.js";
import { HistoryView } from "./motion/history.js";
import { ImpactsView } from "./motion/impacts.js";
import { Knobs } from "./elements/knobs.js";
import { MechanismView } from "./motion/mechanism.js";
import { Motions } from "./motion/motion.js";
import { PortraitView } from "./motion/portrait.js";
import { ReturnView } from "./motion/returns.js";
import { start_of } from "./starts.js";
import { Store } from "./state.js";
import { collected } from "./asking/transport.js";

/**
 * @typedef {object} Place where the state is kept beside the page
 * @property {() => string} read
 * @property {(address: string, step: boolean) => void} write as a step that one can go back from, or in place of the latest
 * @property {(listener: () => void) => void} on one has gone back
 */

/** The address of the page. @returns {Place} */
export const in_address = () => ({
    read: () => location.hash,
    write: (address, step) => history[step ? "pushState" : "replaceState"](null, "", address),
    on: (listener) => {
        window.addEventListener("popstate", listener);
        window.addEventListener("hashchange", listener);
    },
});

/** Between changes that are one step of the way back, in milliseconds. */
const STEP = 700;

/**
 * @param {HTMLElement} root
 * @param {import("./asking/transport.js").Ask} ask
 * @param {Place} place
 */
export async function explore(root, ask, place) {
    const { documents } = await collected(ask("start", {}, new AbortController().signal));
    const given = documents[0];
    const texts = new Map(given.shipped.map((/** @type {any} */ model) => [model.name, model.text]));
    const shipped = (/** @type {string} */ name) => /** @type {string | undefined} */ (texts.get(name));
    const said = make("p", { class: "said", role: "status", "aria-live": "polite" });
    let quiet = 0;
    const say = (/** @type {string} */ message) => {
        said.textContent = message;
        window.clearTimeout(quiet);
        quiet = window.setTimeout(() => (said.textContent = ""), 6000);
    };
    const store = new Store({ name: given.name, text: given.text, ...start_of(given.name, null) });
    const commands = new Commands(store, shipped, given);
    const motions = new Motions(ask, store);
    const editor = new Editor(ask, store);
    const knobs = new Knobs(store);
    const diagram = new DiagramView(ask, store, commands, say);
    const history_view = new HistoryView(ask, store, motions, commands, say);
    const portrait = new PortraitView(ask, store, motions, commands, say);
    const returns = new ReturnView(ask, store, motions, commands, say);
    const impacts = new ImpactsView(ask, store, motions, commands, say);
    const mechanism = new MechanismView(store, motions, [history_view, portrait], ask, commands, say);

    const title = make("span", { class: "title" });
    const select = make("select", { "aria-label": "Model", onchange: () => void open(select.value) });
    const names = [...(shipped(given.name) === given.text ? [] : [{ name: given.name, title: null }]), ...given.shipped];
    select.append(...names.map((model) => make("option", { value: model.name }, model.title ?? model.name)));
    const look = make("button", { type: "button", class: "icon", title: "light or dark", "aria-label": "light or dark", onclick: () => toggle_theme(store) }, "◐");
    const link = make("button", { type: "button", onclick: () => navigator.clipboard.writeText(location.href).then(() => say("the address of this view is copied"), () => say("the address of this view is that of the page")) }, "Copy address");
    const keys = make("details", { class: "gifts keys" }, make("summary", {}, "Keys"), make("div", { class: "sheet" }, ...[
        ["drag", "move a view; on an axis, along it"], ["wheel, pinch", "zoom; on an axis, along it"], ["shift and drag", "zoom to a box"], ["click", "pick a value: its motion is shown"], ["double click, 0", "show all"],
        ["← →", "step from column to column"], ["shift and arrows", "move the view"], ["+ −", "zoom"],
    ].map(([key, does]) => make("div", { class: "row" }, make("kbd", {}, key), make("span", {}, does)))));
    const header = make("header", { class: "top" }, make("h1", {}, make("span", { class: "mark", "aria-hidden": "true" }), "chatter"), select, title, make("span", { class: "space" }), said, link, keys, look);
    const side = make("aside", { class: "side", "aria-label": "Model and values" }, make("details", { open: true, class: "model" }, make("summary", {}, "Model"), editor.element), knobs.element);
    const views = make("div", { class: "views" }, diagram.element, history_view.element, portrait.element, returns.element, impacts.element, mechanism.element);
    root.replaceChildren(header, make("main", {}, side, views));

    /** @param {string} name */
    async function open(name) {
        Object.assign(store.state, { name, text: shipped(name) ?? given.text });
        await begin(null);
    }

    /**
     * Begins with the model that is there.
     * @param {any} address what the address says of it
     */
    async function begin(address) {
        const { name, text } = store.state;
        store.checked = null;
        opening = true;
        editor.show(text);
        select.value = name;
        const good = await editor.check();
        Object.assign(store.state, start_of(name, store.checked));
        if (address) merge(store.state, address);
        opening = false;
        if (good) all();
        remember(true);
    }

    /** Everything after a change from outside. */
    function all() {
        title.textContent = store.checked?.source ?? "";
        document.title = `${store.checked?.title ?? store.state.name} · chatter`;
        diagram.panel.build();
        knobs.build();
        diagram.question_key = "";
        diagram.refresh();
        motions.refresh();
    }

    let opening = true;
    let latest_step = 0;
    let written = "";

    /** @param {boolean} step */
    async function remember(step) {
        const address = await address_of(store.state, shipped);
        if (address === written) return;
        const now = performance.now();
        const push = step && written !== "" && now - latest_step > STEP;
        if (push) latest_step = now;
        written = address;
        place.write(address, push);
    }

    async function return_to() {
        const address = place.read();
        if (address === written) return;
        written = address;
        const found = await state_of(address);
        const name = found.name ?? store.state.name;
        const text = found.text ?? shipped(name) ?? (name === given.name ? given.text : store.state.text);
        if (name !== store.state.name || text !== store.state.text) {
            Object.assign(store.state, { name, text });
            await begin(found);
            return;
        }
        merge(store.state, found);
        store.change("view", () => {});
        diagram.panel.build();
        knobs.follow();
        motions.refresh();
    }

    store.on((change) => {
        if (opening) return;
        if (change === "model") {
            const known = store.checked?.parameters.map((one) => one.name) ?? [];
            const states = store.checked?.states.map((one) => one.name) ?? [];
            for (const name of Object.keys(store.state.set)) if (!known.includes(name)) delete store.state.set[name];
            for (const name of Object.keys(store.state.initial)) if (!states.includes(name)) delete store.state.initial[name];
            const fresh = start_of(store.state.name, store.checked).diagram;
            if (!known.includes(store.state.diagram.over)) store.state.diagram = fresh;
            store.state.through = null;
            title.textContent = store.checked?.source ?? "";
            diagram.panel.build();
        }
        if (change !== "look" && change !== "view") motions.refresh();
        void remember(change !== "values");
    });
    place.on(() => void return_to());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => store.change("look", () => {}));
    const first = await state_of(place.read());
    if (first.name) {
        store.state.name = first.name;
        store.state.text = first.text ?? shipped(first.name) ?? given.text;
        await begin(first);
    } else {
        await begin(null);
    }
    return store;
}

/**
 * @param {import("./state.js").State} state
 * @param {any} found
 */
function merge(state, found) {
    for (const [name, value] of Object.entries(found)) {
        if (value === undefined || name === "diagram" || name === "name" || name === "text") continue;
        /** @type {any} */ (state)[name] = value;
    }
    for (const [name, value] of Object.entries(found.diagram ?? {})) {
        if (value !== undefined) /** @type {any} */ (state.diagram)[name] = value;
    }
}

/** @param {Store} store */
function toggle_theme(store) {
    const { dataset } = document.documentElement;
    const dark = dataset.theme ? dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    dataset.theme = dark ? "light" : "dark";
    store.change("look", () => {});
}
