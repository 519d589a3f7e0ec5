/** Makes elements. */

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [attributes] properties begin with a dot, listeners with "on"
 * @param {...(Node | string | null | undefined | false)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
        if (value === undefined || value === null || value === false) continue;
        if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
        else if (name.startsWith(".")) /** @type {any} */ (element)[name.slice(1)] = value;
        else element.setAttribute(name, value === true ? "" : String(value));
    }
    element.append(...children.filter((child) => child !== null && child !== undefined && child !== false).map((child) => /** @type {Node | string} */ (child)));
    return element;
}

/**
 * A choice with its label.
 * @param {string} label
 * @param {[string, string][]} options value and text
 * @param {string} chosen
 * @param {(value: string) => void} choose
 */
export function choice(label, options, chosen, choose) {
    const select = make(
        "select",
        { onchange: () => choose(select.value), "aria-label": label },
        ...options.map(([value, text]) => make("option", { value, ".selected": value === chosen }, text)),
    );
    return select;
}

/**
 * A labelled control.
 * @param {string} text
 * @param {HTMLElement} control
 */
export const field = (text, control) => make("label", { class: "field" }, make("span", {}, text), control);

/** @param {string} text */
export async function copy(text) {
    await navigator.clipboard.writeText(text);
}

/**
 * Gives a file to the user.
 * @param {string} name
 * @param {BlobPart} content
 */
export function save(name, content) {
    const address = URL.createObjectURL(new Blob([content]));
    make("a", { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
