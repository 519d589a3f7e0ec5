/** Looking around in a plot by mouse, touch and keys. */

/** @typedef {import("./plot.js").Plot} Plot */

/** So many clicks of the wheel halve a box. */
const WHEEL = 0.0018;

/** @param {Plot} plot */
export function listen(plot) {
    const { canvas, of } = plot;
    /** @type {Map<number, { x: number, y: number }>} */
    const fingers = new Map();
    /** @type {{ x: number, y: number, box: import("./plot.js").Box, zooming: boolean, axes: { x: boolean, y: boolean } } | null} */
    let drag = null;
    let travelled = 0;
    let grabbed = false;
    let wheel_timer = 0;
    const place = (/** @type {MouseEvent} */ event) => {
        const { left, top } = canvas.getBoundingClientRect();
        return { x: event.clientX - left, y: event.clientY - top };
    };
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        const { x, y } = place(event);
        const delta = event.deltaMode === 1 ? event.deltaY * 33 : event.deltaY;
        plot.zoom(Math.exp(delta * WHEEL), x, y, axes_at(plot, x, y), false);
        window.clearTimeout(wheel_timer);
        wheel_timer = window.setTimeout(() => of.moved?.(plot.box, true), 250);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        fingers.set(event.pointerId, place(event));
        const at = place(event);
        drag = { ...at, box: plot.box, zooming: event.shiftKey, axes: axes_at(plot, at.x, at.y) };
        travelled = 0;
        grabbed = !event.shiftKey && fingers.size === 1 && (of.grab?.(at.x, at.y, true) ?? false);
    });
    canvas.addEventListener("pointermove", (event) => {
        const at = place(event);
        const before = fingers.get(event.pointerId);
        if (before && drag) {
            travelled += Math.hypot(at.x - before.x, at.y - before.y);
            if (grabbed) {
                of.grab?.(at.x, at.y, false);
            } else if (fingers.size === 2) {
                const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, finger]) => finger);
                const [other] = others;
                const gap = (/** @type {{ x: number, y: number }} */ finger) => Math.max(10, Math.hypot(finger.x - other.x, finger.y - other.y));
                plot.zoom(gap(before) / gap(at), (at.x + other.x) / 2, (at.y + other.y) / 2, { x: true, y: true }, false);
            } else if (drag.zooming) {
                plot.band = [drag.x, drag.y, at.x, at.y];
                plot.repaint();
            } else if (travelled > 4) {
                const { box, axes } = drag;
                const { width, height } = plot.area;
                const dx = axes.x ? ((drag.x - at.x) / width) * (box.x1 - box.x0) : 0;
                const dy = axes.y ? ((at.y - drag.y) / height) * (box.y1 - box.y0) : 0;
                plot.move({ x0: box.x0 + dx, x1: box.x1 + dx, y0: box.y0 + dy, y1: box.y1 + dy }, false);
            }
            fingers.set(event.pointerId, at);
        }
        plot.at = at;
        of.hover?.({ x: plot.x(at.x), y: plot.y(at.y) });
    });
    const up = (/** @type {PointerEvent} */ event) => {
        fingers.delete(event.pointerId);
        if (!drag) return;
        const at = place(event);
        const { zooming } = drag;
        drag = fingers.size > 0 ? drag : null;
        if (grabbed) {
            grabbed = false;
        } else if (zooming && plot.band) {
            const [x0, y0, x1, y1] = plot.band;
            plot.band = null;
            const wide = Math.abs(x1 - x0) > 5 && Math.abs(y1 - y0) > 5;
            const box = { x0: plot.x(Math.min(x0, x1)), x1: plot.x(Math.max(x0, x1)), y0: plot.y(Math.max(y0, y1)), y1: plot.y(Math.min(y0, y1)) };
            if (wide) plot.move(box, true);
            else plot.repaint();
        } else if (travelled <= 4) {
            of.pick?.(plot.x(at.x), plot.y(at.y));
        } else {
            of.moved?.(plot.box, true);
        }
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("pointerleave", () => {
        plot.at = null;
        of.hover?.(null);
    });
    canvas.addEventListener("dblclick", () => of.reset?.());
    canvas.addEventListener("keydown", (event) => key(plot, event));
}

/**
 * On an axis only that one is changed.
 * @param {Plot} plot
 * @param {number} px
 * @param {number} py
 */
function axes_at(plot, px, py) {
    const { left, top, height } = plot.area;
    return { x: px >= left, y: py <= top + height };
}

/**
 * @param {Plot} plot
 * @param {KeyboardEvent} event
 */
function key(plot, event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { left, top, width, height } = plot.area;
    const { x0, x1, y0, y1 } = plot.box;
    const [dx, dy] = [(x1 - x0) / 8, (y1 - y0) / 8];
    const shift = (/** @type {number} */ x, /** @type {number} */ y) => plot.move({ x0: x0 + x, x1: x1 + x, y0: y0 + y, y1: y1 + y }, true);
    const middle = /** @type {[number, number]} */ ([left + width / 2, top + height / 2]);
    const both = { x: true, y: true };
    /** @type {Record<string, () => void>} */
    const keys = {
        ArrowLeft: () => (event.shiftKey || !plot.of.step ? shift(-dx, 0) : plot.of.step(-1)),
        ArrowRight: () => (event.shiftKey || !plot.of.step ? shift(dx, 0) : plot.of.step(1)),
        ArrowUp: () => shift(0, dy),
        ArrowDown: () => shift(0, -dy),
        "+": () => plot.zoom(0.5, ...middle, both, true),
        "=": () => plot.zoom(0.5, ...middle, both, true),
        "-": () => plot.zoom(2, ...middle, both, true),
        "0": () => plot.of.reset?.(),
        Home: () => plot.of.reset?.(),
    };
    const act = keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
}
