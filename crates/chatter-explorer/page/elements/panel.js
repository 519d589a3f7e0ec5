/** A view in its frame: a title, what can be chosen, and what it gives away. */

import { copy, make, save } from "./dom.js";
import { FILE, REMARK, file, text } from "../asking/records.js";
import { Refused } from "../asking/transport.js";

/** @typedef {{ asked: string, question: object }} Asked what is asked for a file */
/**
 * @typedef {object} Giving what a view gives
 * @property {string} name of what is given
 * @property {() => Asked} files what is asked for files
 * @property {string} [short] what its button says
 * @property {() => Asked} [data] for tables, if something else
 * @property {() => string} command the command line
 * @property {() => string} python
 */

/**
 * @param {string} id
 * @param {string} title
 * @param {HTMLElement[]} controls
 * @param {HTMLElement} body
 * @param {HTMLElement | null} menu
 */
export function panel(id, title, controls, body, menu) {
    const heading = make("h2", { id: `${id}-title` }, title);
    return make(
        "section",
        { id, class: "panel", "aria-labelledby": `${id}-title` },
        make("header", {}, heading, make("div", { class: "controls" }, ...controls), menu),
        body,
    );
}

/**
 * The menu of what a view gives.
 * @param {import("../asking/transport.js").Ask} ask
 * @param {Giving} giving
 * @param {(message: string) => void} say
 */
export function gifts(ask, giving, say) {
    /** @type {AbortController | null} */
    let asking = null;
    const fetch_file = async (/** @type {string} */ kind) => {
        const wanted = (["npz", "csv"].includes(kind) ? giving.data : null)?.() ?? giving.files();
        asking?.abort();
        asking = new AbortController();
        say(`making the ${kind.toUpperCase()} file …`);
        try {
            for await (const message of ask(`${wanted.asked}.${kind}`, wanted.question, asking.signal)) {
                if (message.kind === REMARK) say(text(message));
                if (message.kind !== FILE) continue;
                const { name, bytes } = file(message);
                save(name, /** @type {BlobPart} */ (bytes));
                say(`saved ${name}`);
            }
        } catch (error) {
            say(error instanceof Refused ? error.message : "broken off");
        }
    };
    const button = (/** @type {string} */ name, /** @type {() => void} */ act) => make("button", { type: "button", onclick: act }, name);
    const code = (/** @type {string} */ title, /** @type {() => string} */ of) => {
        const shown = make("code", { tabindex: 0 });
        const refresh = () => (shown.textContent = of());
        const copied = button("Copy", () => {
            copy(shown.textContent ?? "").then(() => say("copied"), () => say("the browser does not let the page copy: select the text"));
        });
        return { refresh, element: make("div", { class: "line" }, make("span", {}, title), make("pre", {}, shown), copied) };
    };
    const lines = [code("Command line", giving.command), code("Python", giving.python)];
    const kinds = (/** @type {string[]} */ names) => names.map((name) => button(name.toUpperCase(), () => void fetch_file(name)));
    const menu = make(
        "details",
        { class: "gifts", ontoggle: () => menu.open && lines.forEach((line) => line.refresh()) },
        make("summary", { "aria-label": `Export of ${giving.name}: picture, data, command` }, giving.short ?? "Export"),
        make(
            "div",
            { class: "sheet" },
            make("div", { class: "row" }, make("span", {}, "Picture"), ...kinds(["svg", "png", "pdf"])),
            make("div", { class: "row" }, make("span", {}, "Data"), ...kinds(["npz", "csv"])),
            ...lines.map((line) => line.element),
        ),
    );
    document.addEventListener("pointerdown", (event) => {
        if (event.target instanceof Node && !menu.contains(event.target)) menu.open = false;
    });
    menu.addEventListener("keydown", (event) => {
        if (event.key === "Escape") {
            menu.open = false;
            menu.querySelector("summary")?.focus();
        }
    });
    return menu;
}
